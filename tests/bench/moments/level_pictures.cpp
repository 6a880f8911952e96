// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/moments/level_pictures.h"

#include <cmath>
#include <memory>

#include "render/gradient_noise.h"
#include "render/picture.h"
#include "render/picture_needs.h"
#include "tests/bench/image_error.h"

namespace bccsplat::bench {
namespace {

constexpr int size = 512;

// Half transparent where values are high, and nothing below the middle of their range.
TransferFunction function_of_codes() {
  TransferFunction f;
  f.colors = {{100, {0.1, 0.2, 0.6}}, {170, {0.9, 0.8, 0.5}}, {255, {1, 1, 1}}};
  f.opacities = {{0, 0}, {120, 0}, {220, 0.12}};
  return f;
}

RenderStats draw(const Slice& slice, Quality quality, const Context& context, Image& image) {
  const CoarseLevels levels;
  Scene scene;
  scene.slice = &slice, scene.levels = &levels;
  scene.camera = fit_camera(slice, false, 20, 30, size, size);
  scene.function = function_of_codes();
  scene.lights.noise =
      gradient_noise(ValueSurvey{}, 1, 0, ripple_gradient(slice.kernel, true)); // of whole codes
  scene.lights.noise = per_length(scene.lights.noise, mean_distance(slice));
  RenderOptions options;
  options.quality = quality;
  return render(scene, options, context, image);
}

double moment_of(const MomentOptions& options) { return 0.47 * options.frames; }

std::vector<LevelOption> level_options(const Opened& volume, const Slice& slice) {
  const VolumeInfo& info = volume.reader->info();
  const double filled =
      static_cast<double>(info.channels[0].sites_kept) / static_cast<double>(info.lattice.sites());
  std::vector<LevelOption> options;
  for (int l = 0; l < info.level_count(); ++l) {
    LevelOption& o = options.emplace_back();
    o.per_pixel = distances_per_pixel(slice, info.level(l).lattice,
                                      fit_camera(slice, false, 20, 30, size, size), size, size);
    for (const MeasuredError& e : info.errors)
      if (static_cast<int>(e.level) == l)
        o.rmse = e.rmse / e.range / std::sqrt(filled), o.largest = e.largest / e.range;
  }
  return options;
}

} // namespace

std::unique_ptr<ImageStorage> best_picture(const WrittenSeries& series, const MomentOptions& options) {
  auto best = std::make_unique<ImageStorage>(size, size);
  Opened volume(series, options);
  (void)draw(volume.moment(moment_of(options)), Quality::best, volume.context.get(), best->image);
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
      const double drawn =
          cpu_seconds([&] { (void)draw(slice, quality, volume.context.get(), picture.image); });
      const std::vector<LevelOption> known = level_options(volume, slice);
      RenderOptions asked;
      asked.quality = quality;
      const LevelOption& own = known[static_cast<size_t>(level)];
      const ImageError error = image_error(picture.image, truth);
      Row row = head;
      row.push_back(word("quality", quality == Quality::draft ? "draft" : "normal"));
      row.push_back(figure("level", level, 0));
      row.push_back(word("unasked", enough_level(known, asked) == level ? "yes" : ""));
      row.push_back(figure("T per pixel", own.per_pixel, 2));
      row.push_back(figure("its error where filled, dB", own.rmse ? -20 * std::log10(*own.rmse) : 0, 1));
      row.push_back(figure("largest, of the range", own.largest, 4));
      row.push_back(figure("slice, CPU s", sliced, 3));
      row.push_back(figure("picture, CPU s", drawn, 3));
      row.push_back(
          figure("MB read", static_cast<double>(volume.reader->bytes_read() - volume.opening) / 1e6, 2));
      row.push_back(figure("MiB held", volume.mebibytes(), 0));
      row.push_back(figure("dB", error.psnr(), 1));
      rows.push_back(std::move(row));
    }
}

} // namespace bccsplat::bench
