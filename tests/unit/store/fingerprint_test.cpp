// SPDX-License-Identifier: Apache-2.0
#include "store/fingerprint.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "fit/kept/packed_block.h"
#include "fit/resample/halved_frame.h"
#include "store/journal_options.h"
#include "tests/unit/fit/fit_series.h"

namespace bccsplat {
namespace {

TEST(Fingerprint, EveryOptionThatChangesSamplesAndIsNotInTheFileCounts) {
  const std::vector<std::function<void(FitOptions&)>> changes{
      [](FitOptions&) {},
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
    EXPECT_TRUE(seen.insert(options_checksum(options, 0, "0", {})).second) << seen.size();
    EXPECT_EQ(options_checksum(options, 0, "0", {}), options_checksum(options, 0, "0", {}));
  }
  EXPECT_TRUE(seen.insert(options_checksum({}, 0, "0.25", {})).second) << "a bound";
  EXPECT_TRUE(seen.insert(options_checksum({}, 0, "0", 40.0)).second) << "a PSNR";
  EXPECT_TRUE(seen.insert(options_checksum({}, 0, "0", {}, {.resampling = resampling_rules - 1})).second)
      << "an older version";
  EXPECT_TRUE(seen.insert(options_checksum({}, 0, "0", {}, {.tiles = 2})).second) << "tiles";
  EXPECT_TRUE(seen.insert(options_checksum({}, 0, "0", {}, {.tiles = 3})).second)
      << "tiles of a newer version";
}

// What becomes of a ball, at level 0 and halved.
TEST(Fingerprint, ANewRuleHasANewNumber) {
  using test::Bench, test::Series;
  const Series ball({40, 40, 40, 1}, [](double x, double y, double z, double) {
    return std::hypot(x - 19.5, y - 19.5, z - 19.5) < 10 ? 1.0 : 0.0;
  });
  FitOptions options = test::options_for(ball);
  options.channels[0].quantiser.type = ValueType::f32;
  const uint64_t kept = test::run_fit(options, ball).report.channels[0].sites_kept;
  Bench bench(1);
  const FrameBox box = ball.box(0);
  const Frame frame(std::span(&box, 1), {40, 40, 40}, 0, "frame");
  const FrameScan scan = scan_frame(frame, 0, bench.context);
  FrameHalver halver({40, 40, 40}, {true, true, true}, {});
  HalvedFrame halved = halver.halve(frame, scan.cells, usual_face_levels, 1.0f / 512, bench.context);
  halved.memory = {};
  const auto air = std::count(halved.values.begin(), halved.values.end(), 0.0f);
  const char* const advice =
      "The rules have changed: raise resampling_rules, and write it and the new counts here.";
  EXPECT_EQ(resampling_rules, 8) << advice;
  EXPECT_EQ(coarsest_unit(1), 4) << advice;
  EXPECT_EQ(kept, 4599u) << advice;
  EXPECT_EQ(air, 7928) << advice;
}

// Older versions made levels otherwise. How many there are is in the file.
TEST(Fingerprint, LevelsOfHalvedFramesAreNotThoseOfOlderVersions) {
  EXPECT_NE(options_checksum({}, 1, "0", {}), options_checksum({}, 0, "0", {}));
  EXPECT_EQ(options_checksum({}, 2, "0", {}), options_checksum({}, 1, "0", {}));
}

// What a journal could not be read with must not be in it.
TEST(Fingerprint, OptionsInWordsAreShort) {
  WriterSettings settings;
  std::vector<double>& x = settings.axes[0].coordinates;
  for (int i = 0; i < 60000; ++i) x.push_back(i + 0.1);
  const JournalOptions options = journal_options(settings, "", 0, {});
  for (const auto& option : options) EXPECT_LE(option.second.size(), 1000u) << option.first;
  x.back() += 0.5;
  EXPECT_NE(journal_options(settings, "", 0, {}), options);
}

TEST(Fingerprint, PartsDifferByTheirFrames) {
  FitPart part;
  part.counted = SeriesBlock::of_frames(2, 5);
  const uint32_t one = part_checksum(7, part);
  part.counted = SeriesBlock::of_frames(2, 6);
  EXPECT_NE(part_checksum(7, part), one);
  EXPECT_NE(part_checksum(8, part), part_checksum(7, part));
}

} // namespace
} // namespace bccsplat
