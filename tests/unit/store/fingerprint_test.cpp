// SPDX-License-Identifier: Apache-2.0
#include "store/fingerprint.h"

#include <functional>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace bccsplat {
namespace {

TEST(Fingerprint, EveryOptionThatChangesSamplesAndIsNotInTheFileCounts) {
  const std::vector<std::function<void(FitOptions&)>> changes{
      [](FitOptions&) {},
      [](FitOptions& o) { o.filter = Filter::bspline3; },
      [](FitOptions& o) { o.nonfinite = NonFinite::clamp; },
      [](FitOptions& o) { o.lowpass = true; },
      [](FitOptions& o) { o.masks = true; },
      [](FitOptions& o) { o.lead = 2; },
      [](FitOptions& o) { o.lead = 4; },
      [](FitOptions& o) { o.periodic = true; },
      [](FitOptions& o) {
        o.turning = {true, false, false};
      },
      [](FitOptions& o) {
        o.margins = {2, 0, 0};
      },
      [](FitOptions& o) {
        o.margins = {0, 0, 2};
      },
      [](FitOptions& o) { o.channels[0].threshold = 0.5f; },
      [](FitOptions& o) { o.channels[0].ringing = 0; },
      [](FitOptions& o) {
        o.channels[0].range = Range{0, 1};
      },
      [](FitOptions& o) { o.channels.resize(2); },
  };
  std::set<uint32_t> seen;
  for (const auto& change : changes) {
    FitOptions options;
    change(options);
    EXPECT_TRUE(seen.insert(options_checksum(options, 0, 0, {})).second) << seen.size();
    EXPECT_EQ(options_checksum(options, 0, 0, {}), options_checksum(options, 0, 0, {}));
  }
  EXPECT_TRUE(seen.insert(options_checksum({}, 0, 0.25, {})).second) << "a bound";
  EXPECT_TRUE(seen.insert(options_checksum({}, 0, 0, 40.0)).second) << "a PSNR";
}

// Older versions made levels otherwise. How many there are is in the file.
TEST(Fingerprint, LevelsOfHalvedFramesAreNotThoseOfOlderVersions) {
  EXPECT_NE(options_checksum({}, 1, 0, {}), options_checksum({}, 0, 0, {}));
  EXPECT_EQ(options_checksum({}, 2, 0, {}), options_checksum({}, 1, 0, {}));
}

TEST(Fingerprint, PartsDifferByTheirFrames) {
  FitPart part;
  part.first_counted = 2, part.end_counted = 5;
  const uint32_t one = part_checksum(7, part);
  part.end_counted = 6;
  EXPECT_NE(part_checksum(7, part), one);
  EXPECT_NE(part_checksum(8, part), part_checksum(7, part));
}

} // namespace
} // namespace bccsplat
