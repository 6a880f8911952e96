// SPDX-License-Identifier: Apache-2.0
// Sums that do not depend on the order of adding.
#include "base/exact_sum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "base/error.h"

namespace bccsplat {
namespace {

std::vector<std::byte> bytes_of(const ExactSum& sum) {
  ByteWriter out;
  sum.write(out);
  return out.release();
}

// Numbers whose plain sum depends on their order.
std::vector<double> uneven_numbers(int count) {
  std::mt19937 random(7);
  std::vector<double> numbers;
  for (int i = 0; i < count; ++i)
    numbers.push_back(
        std::ldexp(1 + static_cast<double>(random()) / 4294967296.0, static_cast<int>(random() % 90) - 70));
  return numbers;
}

TEST(ExactSum, IsTheSameInAnyOrder) {
  std::vector<double> numbers = uneven_numbers(5000);
  ExactSum forward, backward;
  for (const double v : numbers) forward.add(v);
  std::reverse(numbers.begin(), numbers.end());
  for (const double v : numbers) backward.add(v);
  EXPECT_EQ(bytes_of(forward), bytes_of(backward));
  EXPECT_EQ(forward.value(), backward.value());
  long double plain = 0;
  for (const double v : numbers) plain += v;
  EXPECT_NEAR(forward.value() / static_cast<double>(plain), 1, 1e-12);
  double doubles_forward = 0, doubles_backward = 0;
  for (const double v : numbers) doubles_backward += v;
  std::reverse(numbers.begin(), numbers.end());
  for (const double v : numbers) doubles_forward += v;
  EXPECT_NE(doubles_forward, doubles_backward) << "else the numbers test nothing";
}

TEST(ExactSum, OfSumsIsThatOfAll) {
  const std::vector<double> numbers = uneven_numbers(6000);
  ExactSum all;
  std::array<ExactSum, 7> parts;
  for (size_t i = 0; i < numbers.size(); ++i) all.add(numbers[i]), parts[i * i % 7].add(numbers[i]);
  ExactSum joined;
  for (const size_t i : {3, 0, 6, 1, 5, 2, 4}) joined.add(parts[i]);
  EXPECT_EQ(bytes_of(joined), bytes_of(all));
  joined.add(ExactSum());
  EXPECT_EQ(bytes_of(joined), bytes_of(all));
}

// A bin fills after some thousands of equal numbers.
TEST(ExactSum, OfManyEqualNumbers) {
  ExactSum sum, twice;
  for (int i = 0; i < 3000000; ++i) sum.add(3.25);
  EXPECT_EQ(sum.value(), 3.25 * 3000000);
  twice.add(sum), twice.add(sum);
  EXPECT_EQ(twice.value(), 6.5 * 3000000);
}

TEST(ExactSum, OfExtremeNumbers) {
  ExactSum sum;
  EXPECT_EQ(sum.value(), 0);
  sum.add(0), sum.add(1e-310);
  EXPECT_EQ(sum.value(), 0);
  EXPECT_EQ(bytes_of(sum), bytes_of(ExactSum()));
  sum.add(0x1p-1022);
  EXPECT_EQ(sum.value(), 0x1p-1022);
  sum.add(0x1p900);
  EXPECT_EQ(sum.value(), 0x1p900);
  ExactSum rounded;
  rounded.add(2 - 0x1p-50); // all ones round up to the next exponent
  EXPECT_EQ(rounded.value(), 2);
}

TEST(ExactSum, IsReadAsItWasWritten) {
  ExactSum sum;
  for (const double v : uneven_numbers(300)) sum.add(v);
  const std::vector<std::byte> bytes = bytes_of(sum);
  ByteReader in(bytes, "sum");
  const ExactSum again = ExactSum::read(in);
  in.expect_end();
  EXPECT_EQ(bytes_of(again), bytes);
  EXPECT_EQ(again.value(), sum.value());
  const std::vector<std::byte> bad{std::byte{0}, std::byte{0}, std::byte{0xff}, std::byte{0xff}};
  ByteReader wrong(bad, "sum");
  EXPECT_THROW((void)ExactSum::read(wrong), Error);
}

} // namespace
} // namespace bccsplat
