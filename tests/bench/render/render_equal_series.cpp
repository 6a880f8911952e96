// SPDX-License-Identifier: Apache-2.0
// A moment between two frames of a large series, at equal error and at equal time: from a file that was
// opened and not looked at, at level 0 and at the level that is drawn unasked; and from raw frames in memory,
// blended, by rays. The truth is the waves that the series was made of.
#include <array>
#include <cmath>
#include <optional>

#include "base/text.h"
#include "reference/reference.h"
#include "tests/bench/moments/level_pictures.h"
#include "tests/bench/render/equal_error.h"

namespace bccsplat::bench {
namespace {

constexpr int size = level_picture_size, stride = 8;

// The moment as those see it who have raw frames: `count` of them around it, mixed.
struct Mixed {
  std::vector<float> values;
  double ms = 0; // of mixing, the frames being at hand
};

Mixed mix_frames(const MomentSeries& series, double frame, int count) {
  const auto at = static_cast<int>(frame);
  const auto t = static_cast<float>(frame - at);
  const std::array<float, 2> linear{1 - t, t};
  const std::array<float, 4> cubic{0.5f * t * (t * (2 - t) - 1), 0.5f * (t * t * (3 * t - 5) + 2),
                                   0.5f * t * (t * (4 - 3 * t) + 1), 0.5f * t * t * (t - 1)};
  std::vector<std::vector<uint8_t>> frames;
  for (int i = 0; i < count; ++i) frames.push_back(series.frame(at + i - (count == 4 ? 1 : 0)));
  Mixed out;
  out.values.resize(frames[0].size());
  out.ms = 1e3 * cpu_seconds([&] {
             for (size_t i = 0; i < out.values.size(); ++i) {
               const auto v = [&](size_t n) { return static_cast<float>(frames[n][i]); };
               out.values[i] = count == 2
                                   ? linear[0] * v(0) + linear[1] * v(1)
                                   : cubic[0] * v(0) + cubic[1] * v(1) + cubic[2] * v(2) + cubic[3] * v(3);
             }
           });
  return out;
}

// The box of the series, and how it is seen.
Slice box_of(const MomentSeries& series) {
  MarchGrid box;
  const int n = series.edge;
  box.dims = {n, n, n}, box.low = {0}, box.high = {255};
  return grid_domain(box);
}

std::unique_ptr<ImageStorage> true_picture(const MomentSeries& series, double frame, Lit lit) {
  const Slice box = box_of(series);
  const CoarseLevels levels;
  Scene scene = scene_of_codes(box, levels, lit);
  scene.camera = strided_camera(scene.camera, size, stride);
  const bccsplat::FieldAt waves = [&](const Vec3& p, Vec3* gradient) { return waves_at(p, frame, gradient); };
  auto out = std::make_unique<ImageStorage>(size / stride, size / stride);
  BenchContext context(2);
  render_reference(scene, {}, waves, {1.0 / 8}, context.get(), out->image);
  return out;
}

// What measured the ways is gone; what it found stays.
void forget_scenes(std::vector<Way>& ways) {
  for (Way& w : ways)
    for (Method& m : w.methods) m.draw = nullptr;
}

double mib(size_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

// Rays through the moment. The grid and its macro cells are made beforehand.
Way ray_way(const MomentSeries& series, double frame, Interpolation interpolation, int frames,
            const Image& truth) {
  const Mixed mixed = mix_frames(series, frame, frames);
  const int n = series.edge;
  const MarchGrid grid = make_march_grid(
      {n, n, n},
      [&](double x, double y, double z) {
        return static_cast<double>(mixed.values[static_cast<size_t>((z * n + y) * n + x)]);
      },
      interpolation);
  BenchContext one(1);
  MarchOptions m;
  const std::vector<uint8_t> distance = march_distances(grid, function_of_codes(), m);
  MarchScene march;
  march.grid = &grid, march.distance = &distance, march.function = function_of_codes();
  march.camera = fit_camera(grid_domain(grid), false, 20, 30, size, size);
  std::vector<Way> ways(1);
  ways[0].name = concat("rays, ", interpolation == Interpolation::tricubic ? "tricubic" : "trilinear", ", ",
                        frames, " frames");
  ways[0].rays = true;
  ways[0].before_ms = mixed.ms;
  ways[0].held_mib = mib(mixed.values.size() * frames + distance.size() +
                         (grid.value.size() + grid.low.size() + grid.high.size()) * sizeof(float));
  for (const double step : {5.6, 4.0, 2.8, 2.0, 1.4, 1.0, 0.7, 0.5}) {
    m.step = step;
    ways[0].methods.push_back(march_method(march, m, one));
  }
  measure_ways(ways, size, 2, truth, stride);
  forget_scenes(ways);
  return ways[0];
}

// The same moment of a level of the file: `settings` or steps.
std::vector<Way> level_ways(const WrittenSeries& written, const MomentOptions& options, int level,
                            const Image& truth) {
  Opened volume(written, options, level);
  Slice slice;
  std::optional<KeptPoints> points;
  const double before = 1e3 * cpu_seconds([&] {
                          slice = volume.moment(moment_of(options));
                          points.emplace(make_points(slice, volume.context.get()));
                        });
  const CoarseLevels levels;
  Scene scene = scene_of_codes(slice, levels, Lit::surfaces);
  scene.points = &*points;
  BenchContext one(1);
  std::vector<Way> ways(2);
  ways[0].name = concat("level ", level, ", settings"), ways[0].at_any_step = false;
  ways[1].name = concat("level ", level);
  for (const Quality q : {Quality::draft, Quality::normal, Quality::fine}) {
    RenderOptions o;
    o.quality = q;
    ways[0].methods.push_back(splat_method(quality_name(q), scene, o, one));
  }
  for (const double step : {2.8, 2.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25}) { // of the level's own distances
    ways[1].methods.push_back(splat_method("splat", scene, options_at(step), one));
  }
  for (Way& w : ways) w.before_ms = before, w.held_mib = mib(volume.context.memory.used());
  measure_ways(ways, size, 2, truth, stride);
  forget_scenes(ways);
  return ways;
}

// The level that a picture of normal quality is drawn of unasked.
int chosen_level(const WrittenSeries& written, const MomentOptions& options) {
  Opened volume(written, options, options.levels);
  const Slice slice = volume.moment(moment_of(options));
  return enough_level(level_options(volume, slice), {});
}

void equal_series(const Report& report, uint32_t edge, int coarser) {
  MomentOptions o;
  o.edge = edge, o.frames = 8, o.levels = coarser;
  MomentSeries series{.edge = o.edge, .frames = o.frames, .levels = o.levels, .measured = true};
  const double frame = moment_of(o);
  const auto everything = true_picture(series, frame, Lit::everything);
  const auto surfaces = true_picture(series, frame, Lit::surfaces);
  std::vector<Way> ways;
  {
    const WrittenSeries written = write_series(series);
    const int chosen = chosen_level(written, o);
    ways = level_ways(written, o, chosen, surfaces->image);
    if (chosen != 0)
      for (Way& w : level_ways(written, o, 0, surfaces->image)) ways.push_back(std::move(w));
  }
  for (const int frames : {2, 4})
    for (const Interpolation interpolation : {Interpolation::trilinear, Interpolation::tricubic})
      ways.push_back(ray_way(series, frame, interpolation, frames, everything->image));
  const std::string name = concat("waves ", o.edge, "^3 x ", o.frames, " u8");
  std::vector<Row> before;
  std::vector<Way> at_hand = ways;
  for (Way& w : at_hand) {
    before.push_back({word("way", w.name), figure("before the picture, ms", w.before_ms, 1),
                      figure("held, MiB", w.held_mib, 0)});
    for (double& ms : w.ms) ms -= w.before_ms;
  }
  report.table(concat(name,
                      ", the moment: from an opened file (slice and points), or of frames in memory with "
                      "the grid that rays go through"),
               before);
  report_ways(report, concat(name, ", any moment and its picture, shaded, ", size, "^2"),
              ", against the waves themselves; CPU ms of one thread, least of 2", "series", ways);
  std::vector<Row> rows = equal_rows("any moment", ways, ways[0].ms[0], ways[0].ms[1]);
  for (Row& row : equal_rows("the same again", at_hand, at_hand[0].ms[0], at_hand[0].ms[1]))
    rows.push_back(std::move(row));
  report.table(concat("Equal error and equal time, one thread, ", machine_facts()), rows);
  report.table("Time of rays over time of the splatter at equal error",
               {ratio_row("any moment", ways), ratio_row("the same again", at_hand)});
}

} // namespace

void render_equal_series(const Report& report) {
  equal_series(report, report.quick ? 48 : 256, report.quick ? 1 : 2);
}

void render_equal_large(const Report& report) {
  equal_series(report, report.quick ? 64 : 512, report.quick ? 1 : 3);
}

} // namespace bccsplat::bench
