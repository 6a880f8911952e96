// SPDX-License-Identifier: Apache-2.0
// Every picture starts from a file that has been opened and not looked at, so that its time is that of a
// moment at random. Rays through raw frames get the same camera and transfer function.
#include "tests/bench/moments/level_pictures.h"

#include <cmath>
#include <memory>

#include "shade/gradient_noise.h"
#include "tests/bench/image_error.h"
#include "tests/bench/ray_march/ray_march.h"

namespace bccsplat::bench {
namespace {

constexpr int size = level_picture_size;

RenderStats draw(const Slice& slice, Quality quality, Lit lit, const Context& context, Image& image) {
  const CoarseLevels levels;
  RenderOptions options;
  options.quality = quality;
  return render(scene_of_codes(slice, levels, lit), options, context, image);
}

} // namespace

TransferFunction function_of_codes() {
  TransferFunction f;
  f.colors = {{100, {0.1, 0.2, 0.6}}, {170, {0.9, 0.8, 0.5}}, {255, {1, 1, 1}}};
  f.opacities = {{0, 0}, {120, 0}, {220, 0.12}};
  return f;
}

Scene scene_of_codes(const Slice& slice, const CoarseLevels& levels, Lit lit) {
  Scene scene;
  scene.slice = &slice, scene.levels = &levels;
  scene.camera = fit_camera(slice, false, 20, 30, size, size);
  scene.function = function_of_codes();
  if (lit == Lit::surfaces)
    scene.lights.noise = gradient_noise(ValueSurvey{}, 1, 0), scene.noise_of_ripple = true;
  return scene;
}

double moment_of(const MomentOptions& options) { return 0.47 * options.frames; }

std::vector<LevelOption> level_options(const Opened& volume, const Slice& slice) {
  const VolumeInfo& info = volume.reader->info();
  std::vector<LevelOption> options;
  for (int l = 0; l < info.level_count(); ++l)
    options.push_back({distances_per_pixel(
                           slice, info.level(l).lattice,
                           make_sight(fit_camera(slice, false, 20, 30, size, size), size, size), size, size),
                       level_error(info, 0, l)});
  return options;
}

std::unique_ptr<ImageStorage> best_picture(const WrittenSeries& series, const MomentOptions& options,
                                           Lit lit) {
  auto best = std::make_unique<ImageStorage>(size, size);
  Opened volume(series, options);
  (void)draw(volume.moment(moment_of(options)), Quality::best, lit, volume.context.get(), best->image);
  return best;
}

void level_picture_rows(const Row& head, const WrittenSeries& series, const MomentOptions& options,
                        const Image& truth, std::vector<Row>& rows) {
  const double frame = moment_of(options);
  for (const Quality quality : {Quality::draft, Quality::normal})
    for (int level = 0; level <= options.levels; ++level) {
      Opened volume(series, options, level);
      Slice slice;
      const double sliced = cpu_seconds([&] { slice = volume.moment(frame); });
      ImageStorage picture(size, size);
      const double drawn = cpu_seconds(
          [&] { (void)draw(slice, quality, Lit::surfaces, volume.context.get(), picture.image); });
      const std::vector<LevelOption> known = level_options(volume, slice);
      RenderOptions asked;
      asked.quality = quality;
      const LevelOption& own = known[level];
      const ImageError error = image_error(picture.image, truth);
      Row row = head;
      row.push_back(word("quality", quality == Quality::draft ? "draft" : "normal"));
      row.push_back(figure("level", level, 0));
      row.push_back(word("unasked", enough_level(known, asked) == level ? "yes" : ""));
      row.push_back(figure("T per pixel", own.per_pixel, 2));
      row.push_back(figure("added where filled, dB", own.error ? -20 * std::log10(own.error->rmse) : 0, 1));
      row.push_back(figure("largest, of the range", own.error ? own.error->largest : 0, 4));
      row.push_back(figure("slice, CPU s", sliced, 3));
      row.push_back(figure("picture, CPU s", drawn, 3));
      row.push_back(
          figure("MB read", static_cast<double>(volume.reader->bytes_read() - volume.opening) / 1e6, 2));
      row.push_back(figure("MiB held", volume.mebibytes(), 0));
      row.push_back(figure("dB", error.psnr(), 1));
      rows.push_back(std::move(row));
    }
}

void raw_picture_rows(const Row& head, const MomentSeries& series, const MomentOptions& options,
                      const Image& truth, std::vector<Row>& rows) {
  const double frame = moment_of(options), part = frame - std::floor(frame);
  const auto first = static_cast<uint32_t>(frame);
  const std::vector<uint8_t> a = series.frame(first), b = series.frame(first + 1);
  std::vector<float> blended(a.size());
  const double blend = cpu_seconds([&] {
    for (size_t i = 0; i < a.size(); ++i)
      blended[i] = static_cast<float>(a[i]) + static_cast<float>(part) * static_cast<float>(b[i] - a[i]);
  });
  const int n = series.edge;
  const auto sample = [&](double x, double y, double z) {
    return static_cast<double>(blended[static_cast<size_t>((z * n + y) * n + x)]);
  };
  const MarchGrid grid = make_march_grid({n, n, n}, sample);
  test::TestContext context(1);
  for (const double step : {1.0, 0.5}) {
    MarchOptions march;
    march.step = step;
    MarchScene scene;
    scene.grid = &grid, scene.function = function_of_codes();
    scene.camera = fit_camera(grid_domain(grid), false, 20, 30, size, size);
    const std::vector<uint8_t> distances = march_distances(grid, scene.function, march);
    scene.distance = &distances;
    ImageStorage picture(size, size);
    const double drawn = cpu_seconds([&] { ray_march(scene, march, context.get(), picture.image); });
    Row row = head;
    row.push_back(word("quality", step == 1 ? "raw frames, rays of 1 voxel" : "of 0.5"));
    for (const char* of_levels :
         {"level", "unasked", "T per pixel", "its error where filled, dB", "largest, of the range"})
      row.push_back(word(of_levels, ""));
    row.push_back(figure("slice, CPU s", blend, 3));
    row.push_back(figure("picture, CPU s", drawn, 3));
    row.push_back(figure("MB read", static_cast<double>(a.size() + b.size()) / 1e6, 2));
    row.push_back(figure(
        "MiB held",
        static_cast<double>(2 * a.size() + sizeof(float) * (blended.size() + grid.value.size())) / mebibyte,
        0));
    row.push_back(figure("dB", image_error(picture.image, truth).psnr(), 1));
    rows.push_back(std::move(row));
  }
}

} // namespace bccsplat::bench
