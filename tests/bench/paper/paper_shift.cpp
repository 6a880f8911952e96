// SPDX-License-Identifier: Apache-2.0
// The paper's section 6: smoothing shifts values, so that a transfer function shows less, or something else.
// Pictures of a volume on BCC, resampled by its spline and by ours and drawn by its kernel and ours, beside
// that of the volume's own samples.
#include <algorithm>
#include <cmath>

#include "field/coefficients/coefficients.h"
#include "scene/picture.h"
#include "slice/time_slice.h"
#include "tests/bench/paper/paper.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using test::TestContext;

struct Picture {
  std::vector<float> rgba;
  double opacity = 0; // in the mean
  double largest = 0; // value of the field at the sites of its kernel
};

struct Way {
  const char *name, *kernel;
  LatticeKind lattice;
};
constexpr Way ways[] = {{"CC, default kernel", "default", LatticeKind::cc},
                        {"BCC, default kernel", "default", LatticeKind::d4star},
                        {"CC, paper's Gaussian", "paper", LatticeKind::cc},
                        {"BCC, paper's Gaussian", "paper", LatticeKind::d4star}};

Picture draw(const FitSource& source, const Way& way, float top, const Slice* seen_by, Slice& slice,
             int size) {
  TestContext context(1);
  FitOptions options;
  options.lattice = way.lattice;
  std::vector<BrickLayer> layers;
  const FitReport fit = fit_source(source, options, 0, &layers);
  const MemorySamples samples(fit.lattice, {0.0f}, {layers});
  const Coefficients coefficients(samples, 0, make_kernel(way.kernel), 0, test::large_cache);
  slice = time_slice(coefficients, 0, {0, 0}, {}, context.get());
  Scene scene;
  scene.slice = &slice;
  scene.camera = fit_camera(seen_by ? *seen_by : slice, false, 20, 30, size, size);
  // The upper values alone, which smoothing lowers.
  scene.function.colors = {{0, {0.2, 0.4, 0.9}}, {top, {0.9, 0.5, 0.2}}};
  scene.function.opacities = {{0.5 * top, 0}, {0.7 * top, 0.3}};
  RenderOptions fine;
  fine.quality = Quality::fine;
  ImageStorage image(size, size);
  (void)render(scene, fine, context.get(), image.image);
  Picture p;
  p.rgba = image.rgba;
  for (size_t i = 3; i < p.rgba.size(); i += 4) p.opacity += p.rgba[i];
  p.opacity /= static_cast<double>(p.rgba.size()) / 4;
  return p;
}

double psnr(const Picture& a, const Picture& b) {
  double error = 0;
  for (size_t i = 0; i < a.rgba.size(); ++i) error += std::pow(a.rgba[i] - b.rgba[i], 2);
  return -10 * std::log10(error / static_cast<double>(a.rgba.size()));
}

} // namespace

void report_shift(const Report& report, const std::vector<FitSource>& volumes) {
  std::vector<Row> rows;
  const int size = report.quick ? 96 : 300;
  for (const FitSource& source : volumes) {
    const std::vector<float> frame = source.frame(0);
    const float top = *std::max_element(frame.begin(), frame.end());
    Slice own, slice;
    const Picture reference = draw(source, ways[0], top, nullptr, own, size);
    for (const Way& way : ways) {
      const Picture p = draw(source, way, top, &own, slice, size);
      rows.push_back({word("set", source.name), word("drawn from", way.name),
                      figure("mean opacity, % of CC's", 100 * p.opacity / reference.opacity, 1),
                      figure("PSNR dB", std::min(psnr(p, reference), 99.0), 1)});
    }
  }
  report.table("What smoothing does to a picture (values above half of the largest are seen)", rows);
}

} // namespace bccsplat::bench
