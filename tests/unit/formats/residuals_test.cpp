// SPDX-License-Identifier: Apache-2.0
// Corrections as bytes.
#include <gtest/gtest.h>

#include <cstdint>
#include <span>

#include "base/error.h"
#include "formats/bcc4/coding/residuals.h"

namespace bccsplat {
namespace {

TEST(Residuals, SurviveTheirCodingAndBadBytesAreRefused) {
  FrameResiduals r;
  r.add = {{0, 1}, {1, -1}, {7, 300}, {99, INT64_MIN}};
  r.set = {{5, 0}, {98, INT64_MAX}};
  const auto bytes = write_residuals(r);
  EXPECT_EQ(read_residuals(bytes, 100, 0), r);
  EXPECT_THROW((void)read_residuals(bytes, 99, 0), Error); // a voxel beyond the frame
  for (size_t n = 0; n < bytes.size(); ++n)
    EXPECT_THROW((void)read_residuals(std::span(bytes).first(n), 100, 0), Error) << n;
  auto longer = bytes;
  longer.push_back(std::byte{0});
  EXPECT_THROW((void)read_residuals(longer, 100, 0), Error);
  auto many = bytes;
  many[3] = std::byte{0x7f}; // 2^31 samples in a few bytes
  EXPECT_THROW((void)read_residuals(many, 100, 0), Error);
}

} // namespace
} // namespace bccsplat
