// SPDX-License-Identifier: Apache-2.0
#include "readers/stored_values.h"

#include <gtest/gtest.h>

namespace bcc4::test {
namespace {

Bytes bytes_of_float(float value) {
  Bytes bytes(sizeof value);
  store_as<float>(value, bytes.data());
  return bytes;
}

TEST(StoredValues, ScalesFloatsThatHaveNoHoles) {
  StoredValues s{.type = Type::f32, .slope = 2, .intercept = 1, .fills = {}, .valid = {}};
  Bytes bytes = bytes_of_float(3);
  s.convert(bytes);
  EXPECT_EQ(load_as<float>(bytes.data()), 7);
}

TEST(StoredValues, ConvertsToAnotherTypeThatHoldsThem) {
  StoredValues s{.type = Type::f32, .slope = 1, .intercept = 0, .fills = {}, .valid = {}};
  Bytes bytes = bytes_of_float(3);
  s.convert(bytes, Type::f64);
  ASSERT_EQ(bytes.size(), 8u);
  EXPECT_EQ(load_as<double>(bytes.data()), 3);
}

} // namespace
} // namespace bcc4::test
