// SPDX-License-Identifier: Apache-2.0
// The tool stores the kept frames with its defaults; everything is made of what the library reads back, and
// compared with the frames that were left out.
#include "tests/bench/motion/motion.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/error.h"
#include "base/text.h"
#include "motion/finder.h"
#include "tests/bench/motion/dense_moment.h"
#include "tests/bench/motion/fixed_in_time.h"
#include "tests/bench/motion/motion_blobs.h"
#include "tests/bench/motion/motion_set.h"
#include "tests/bench/motion/motion_smoke.h"
#include "tests/bench/motion/motion_stored.h"
#include "tests/bench/paper/paper.h"

namespace bccsplat::bench {
namespace {

using motion::Box;
using motion::Finder;

struct MotionArguments {
  std::string data, set;
};

MotionArguments motion_arguments(std::span<const std::string> args) {
  MotionArguments out;
  for (size_t i = 0; i + 1 < args.size(); i += 2) {
    if (args[i] == "--data")
      out.data = args[i + 1];
    else if (args[i] == "--set")
      out.set = args[i + 1];
    else
      fail(Code::invalid_argument, "motion: no option ", args[i], "; there are --data, --set");
  }
  if (args.size() % 2 != 0) fail(Code::invalid_argument, "motion: ", args.back(), " needs a value");
  return out;
}

// Errors of one way to make the frames that were left out.
struct Way {
  double squares = 0;
  size_t samples = 0;
  void add(const Box& made, const LeftOut& truth) {
    samples += truth.frame.size();
    for (size_t i = 0; i < truth.frame.size(); ++i)
      squares += std::pow(double{made.values[i]} - truth.frame[i], 2);
  }
  [[nodiscard]] double psnr(double peak) const {
    return 10 * std::log10(peak * peak * static_cast<double>(samples) / squares);
  }
};

struct Ways {
  Way stored, blend, library, reader, two, four, gated; // stored: the kept frames themselves
  std::array<Way, time_cubics> cubics;
  double best_cubic(double peak) const {
    double best = -INFINITY;
    for (const Way& w : cubics) best = std::max(best, w.psnr(peak));
    return best;
  }
};

std::vector<Box> frames_of(const StoredMoments& volume, size_t count) {
  std::vector<Box> frames;
  for (size_t i = 0; i < count; ++i) frames.push_back(volume.moment(static_cast<double>(i)));
  return frames;
}

// Share of the nodes where the flow is followed.
double share_on(Finder& finder) {
  double on = 0, all = 0;
  for (size_t i = 0; i + 1 < finder.times().size(); ++i)
    for (const float m : finder.interval(i)->mask) on += double{m}, all += 1;
  return on / all;
}

Ways ways_of(const MotionSet& set, const StoredMoments& volume, const std::vector<Box>& frames,
             Finder& finder) {
  Ways ways;
  for (uint32_t i = 0; i < frames.size(); ++i) ways.stored.add(frames[i], {0, set.kept.frame(i)});
  for (const LeftOut& left : set.left_out) {
    const double index = set.index(left.time);
    const Box still = volume.moment(index);
    ways.blend.add(weighted(frames, blend_weights(index, frames.size())), left);
    const auto cubics = cubic_weights(index, frames.size());
    for (size_t k = 0; k < time_cubics; ++k) ways.cubics[k].add(weighted(frames, cubics[k]), left);
    ways.library.add(still, left);
    ways.reader.add(volume.moment(index, BCCSPLAT_MOTION_ON), left);
    ways.two.add(dense_moment(finder, left.time, still, {.cubic = false, .gated = false}), left);
    ways.four.add(dense_moment(finder, left.time, still, {.gated = false}), left);
    ways.gated.add(dense_moment(finder, left.time, still), left);
  }
  return ways;
}

Row quality_row(const MotionSet& set, const Ways& ways, double on) {
  const double library = ways.library.psnr(set.peak), gated = ways.gated.psnr(set.peak);
  return {word("set", set.kept.name),
          figure("kept frames", ways.stored.psnr(set.peak), 1),
          figure("blend", ways.blend.psnr(set.peak), 1),
          figure("best cubic", ways.best_cubic(set.peak), 1),
          figure("the library", library, 2),
          figure("two frames warped", ways.two.psnr(set.peak), 1),
          figure("four, no gate", ways.four.psnr(set.peak), 2),
          figure("four, gated", gated, 2),
          figure("nodes that follow, %", 100 * on, 0),
          figure("gain", gated - library, 2),
          figure("the reader's gain", ways.reader.psnr(set.peak) - library, 2),
          figure("wanted", set.wanted, 1),
          word("met", gated - library >= set.wanted ? "yes" : "no")};
}

// CPU seconds, one thread.
struct Costs {
  double import_frame = 0, interval = 0, moment = 0, four_frames = 0;
  double follows_wavelets = 0, follows_samples = 0; // in the reader
  MomentSeconds wavelets, samples;
};

Row cost_row(const MotionSet& set, const Costs& c) {
  return {word("set", set.kept.name),
          figure("import of a frame", c.import_frame, 3),
          figure("finding an interval", c.interval, 3),
          figure("of the import", c.interval / c.import_frame, 2),
          figure("along the ways", c.moment, 3),
          figure("ns a voxel", 1e9 * c.moment / static_cast<double>(set.kept.frame_samples()), 0),
          figure("a moment of wavelets", c.wavelets.first, 3),
          figure("of it", c.moment / c.wavelets.first, 2),
          figure("of samples", c.samples.first, 3),
          figure("of that", c.moment / c.samples.first, 2),
          figure("the next, of wavelets", c.wavelets.next, 3),
          figure("of samples ", c.samples.next, 3),
          figure("four frames read", c.four_frames, 3),
          figure("the reader's, of wavelets", c.follows_wavelets, 3),
          figure("the reader's, of samples", c.follows_samples, 3)};
}

struct Tables {
  std::vector<Row> quality, costs;
};

void measure(const MotionSet& set, Tables& tables) {
  const ToolImport tool(set.kept);
  Costs costs;
  costs.import_frame = tool.seconds("") / set.kept.dims[3];
  const size_t middle = set.left_out.size() / 2;
  const double time = set.left_out[middle].time, index = set.index(time);
  const double last = set.kept.dims[3] - 1;
  costs.wavelets = moment_seconds(tool.file(), index, last);
  costs.follows_wavelets = following_seconds(tool.file(), index);
  costs.four_frames = four_frames_seconds(tool.file(), index, last);

  const StoredMoments volume(tool.file());
  const std::vector<Box> frames = frames_of(volume, set.times.size());
  Finder finder(set.times);
  const auto intervals = static_cast<double>(set.times.size() - 1);
  costs.interval = cpu_seconds([&] {
                     for (size_t i = 0; i < frames.size(); ++i) finder.give(i, frames[i]);
                     for (size_t i = 0; i + 1 < set.times.size(); ++i) (void)finder.interval(i);
                   }) /
                   intervals;
  const Box still = volume.moment(index);
  costs.moment = median_cpu_seconds([&] { (void)dense_moment(finder, time, still, {.gated = false}); }, 3);
  tables.quality.push_back(quality_row(set, ways_of(set, volume, frames, finder), share_on(finder)));

  (void)tool.seconds("--density .5");
  costs.samples = moment_seconds(tool.file(), index, last);
  costs.follows_samples = following_seconds(tool.file(), index);
  tables.costs.push_back(cost_row(set, costs));
  std::fprintf(stderr, "motion: %s measured\n", set.kept.name.c_str());
}

// Measures sets whose names begin as they should, and makes no others.
class Sets {
 public:
  Sets(const MotionArguments& arguments, bool quick) : arguments_(arguments), quick_(quick) {}

  void blobs() {
    const uint32_t edge = quick_ ? 32 : 80;
    for (int w = 0; w < blob_ways; ++w)
      for (const double speed : {1., 2., 4., 8.}) {
        const auto ways = static_cast<BlobWays>(w);
        if (wanted(concat("blobs ", name_of(ways), ", ", speed)))
          measure(moving_blobs(ways, speed * edge / 80, edge), tables_);
      }
  }
  void smoke() {
    if (!wanted("smoke")) return;
    const auto smoke = simulated_smoke(quick_ ? 32 : 80, quick_ ? 9 : 49);
    if (!smoke) {
      std::fprintf(stderr, "motion: *** simulate_smoke is not built here: no smoke is measured ***\n");
      return;
    }
    const std::vector<double> times = even_times(smoke->dims[3]);
    measure(every(*smoke, 2, times, 8), tables_);
    measure(every(*smoke, 4, times, 5), tables_);
  }
  void real() {
    for (const PaperSet& set : real_series()) {
      if (!wanted(set.name)) continue;
      const auto source = arguments_.data.empty() ? std::nullopt : load_paper_set(set, arguments_.data);
      if (source)
        series(*source);
      else
        std::fprintf(stderr, "motion: *** %s is not in '%s' (--data DIR): not measured ***\n", set.file,
                     arguments_.data.c_str());
    }
  }
  [[nodiscard]] const Tables& tables() const { return tables_; }

 private:
  [[nodiscard]] bool wanted(const std::string& name) const {
    return name.starts_with(arguments_.set) || arguments_.set.starts_with(name);
  }
  void series(const FitSource& source) {
    // Not evenly spaced; the hurricane in three runs, between which everything is another.
    const std::vector<double> times =
        source.name == "hurricane"  ? std::vector<double>{2, 3, 4, 5, 30, 31, 32, 33, 45, 46, 47, 48}
        : source.name == "forecast" ? std::vector<double>{0, 6, 12, 24, 30, 36, 48}
                                    : even_times(source.dims[3]);
    if (source.name == "hurricane") {
      measure(every(source, 2, times, .5, 2), tables_);
      return;
    }
    measure(every(source, 2, times), tables_);
    if (source.name == "fingers") measure(every(source, 4, times, .8), tables_);
  }

  const MotionArguments& arguments_;
  bool quick_;
  Tables tables_;
};

} // namespace

int run_motion_suite(std::span<const std::string> args, const Report& report) {
  const MotionArguments arguments = motion_arguments(args);
  if (!has_tool())
    fail(Code::unsupported,
         "motion runs bcc4, which is not built here: configure with -DBCCSPLAT_BUILD_TOOL=ON");
  Sets sets(arguments, report.quick);
  sets.blobs();
  sets.smoke();
  sets.real();
  report.table("frames that were left out, dB", sets.tables().quality);
  report.table("what they cost, CPU s of one thread", sets.tables().costs);
  return 0;
}

} // namespace bccsplat::bench
