#include "render/trail.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "slice/maximum_slice.h"
#include "slice/time_slice.h"

namespace bccsplat {
namespace {

bool is_time_slice(const Slice& s) {
  return s.hyperplane[0] == 0 && s.hyperplane[1] == 0 && s.hyperplane[2] == 0;
}

} // namespace

std::vector<TrailSlice> make_trail(const Coefficients& coefficients, const Slice& slice,
                                   const TrailOptions& options, const Context& context) {
  if (!is_time_slice(slice)) fail(Code::unsupported, "trail: it belongs to time slices (a = b = c = 0)");
  if (!(options.interval[0] <= options.interval[1]) || !std::isfinite(options.interval[0]) ||
      !std::isfinite(options.interval[1]))
    fail(Code::invalid_argument, "trail: the interval must be finite and ordered");
  if (options.samples < 0 || options.samples > 4096 || options.intervals < 1 || options.intervals > 256)
    fail(Code::invalid_argument, "trail: at most 4096 samples in each of 1 .. 256 sub-intervals");
  const Lattice4& lattice = coefficients.source().lattice();
  const double end = lattice.last_frame();
  const double begin_frame = std::clamp(slice.frame + options.interval[0], 0.0, end);
  const double end_frame = std::clamp(slice.frame + options.interval[1], 0.0, end);
  std::vector<TrailSlice> trail;
  if (!(begin_frame < end_frame) || lattice.is_static()) return trail;

  const double part = (end_frame - begin_frame) / options.intervals;
  const int samples = options.samples > 0
                          ? options.samples
                          : std::clamp(static_cast<int>(std::ceil(part / lattice.time_step)), 4, 64);
  const auto add = [&](Slice&& s, double weight, int interval) {
    TrailSlice t;
    t.points = make_points(s, context);
    t.slice = std::move(s);
    t.weight = weight, t.interval = interval;
    trail.push_back(std::move(t));
  };
  for (int i = 0; i < options.intervals; ++i) {
    const double from = begin_frame + i * part;
    if (options.content == TrailContent::mean) {
      const double middle = from + part / 2;
      add(time_slice(coefficients, middle, {-part / 2, part / 2}, slice.slice_to_world, context),
          1.0 / options.intervals, i);
      continue;
    }
    std::vector<Slice> stills;
    for (int k = 0; k < samples; ++k)
      stills.push_back(
          time_slice(coefficients, from + (k + 0.5) * part / samples, {0, 0}, slice.slice_to_world, context));
    if (options.content == TrailContent::maximum) {
      add(maximum_slice(stills, context), 1.0 / options.intervals, i);
      continue;
    }
    for (Slice& s : stills) add(std::move(s), 1.0 / (samples * options.intervals), i);
  }
  return trail;
}

TransferFunction tinted(const TransferFunction& function, const Vec3& color) {
  TransferFunction f = function;
  for (ColorPoint& p : f.colors) p.color = color;
  return f;
}

Vec3 ramp_color(int interval, int intervals) {
  const double x = intervals > 1 ? 2.0 * interval / (intervals - 1) - 1 : 0; // -1 .. 1
  constexpr Vec3 cold{0.05, 0.2, 1}, middle{0.9, 0.9, 0.9}, warm{1, 0.3, 0.02};
  return x < 0 ? (1 + x) * middle + (-x) * cold : (1 - x) * middle + x * warm;
}

} // namespace bccsplat
