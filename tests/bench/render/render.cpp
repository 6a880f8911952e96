// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/render/render.h"

#include <algorithm>
#include <array>

#include "base/error.h"

namespace bccsplat::bench {
namespace {

struct Part {
  const char* option;
  void (*run)(const Report&);
  bool unasked = true; // where nothing is asked for
};
constexpr std::array parts{Part{"--front", render_front},
                           Part{"--equal", render_equal},
                           Part{"--equal-series", render_equal_series},
                           Part{"--equal-large", render_equal_large, false},
                           Part{"--own", render_own},
                           Part{"--ratios", render_ratios},
                           Part{"--interactive", render_interactive},
                           Part{"--minify", render_minify},
                           Part{"--narrow", render_narrow},
                           Part{"--coast", render_coast},
                           Part{"--edges", render_edges},
                           Part{"--grain", render_grain},
                           Part{"--threads", render_threads}};

} // namespace

int run_render_suite(std::span<const std::string> args, const Report& report) {
  for (const std::string& a : args)
    if (std::none_of(parts.begin(), parts.end(), [&](const Part& p) { return a == p.option; }))
      fail(Code::invalid_argument, "render: unknown option ", a);
  for (const Part& p : parts)
    if (args.empty() ? p.unasked : std::find(args.begin(), args.end(), p.option) != args.end()) p.run(report);
  return 0;
}

const char* mode_name(RenderMode mode) {
  return mode == RenderMode::xray         ? "X-ray"
         : mode == RenderMode::maximum    ? "maximum"
         : mode == RenderMode::isosurface ? "isosurface"
                                          : "semi-transparent";
}

const char* quality_name(Quality quality) {
  static constexpr const char* names[] = {"", "draft", "normal", "fine", "best"};
  return names[static_cast<size_t>(quality)];
}

const char* gradient_name(GradientMethod gradient) {
  static constexpr const char* names[] = {"analytic", "central", "fourth order"};
  return names[static_cast<size_t>(gradient)];
}

std::vector<double> least_ms(std::span<const Method> methods, int size, int rounds) {
  ImageStorage out(size, size);
  std::vector<double> least(methods.size(), 1e300);
  for (int r = 0; r < rounds; ++r)
    for (size_t i = 0; i < methods.size(); ++i)
      least[i] = std::min(least[i], 1e3 * cpu_seconds([&] { methods[i].draw(out.image); }));
  return least;
}

ImageError method_error(const Method& method, int size, const Image& truth, int stride) {
  ImageStorage out(size, size);
  method.draw(out.image);
  return image_error(out.image, truth, stride);
}

void settle(const Method& method, int size) {
  ImageStorage out(size, size);
  // Cells of a surface are made for the first picture, and refined piece by piece by later ones.
  constexpr int pictures = 24;
  for (int n = 0; n < pictures; ++n) method.draw(out.image);
}

Method splat_method(const std::string& name, const Scene& scene, const RenderOptions& options,
                    BenchContext& context) {
  Method m;
  m.name = name;
  m.lattice = scene.slice->lattice.bcc ? "BCC" : "CC";
  m.kernel = scene.slice->kernel.name;
  m.step = options.sheet_step > 0 ? options.sheet_step : quality_settings(options.quality).sheet_step;
  m.gradient = options.gradient ? gradient_name(*options.gradient) : "by quality";
  m.draw = [&scene, options, &context](Image& image) { (void)render(scene, options, context.get(), image); };
  return m;
}

Method march_method(const MarchScene& scene, const MarchOptions& options, BenchContext& context) {
  Method m;
  const bool cubic = scene.grid->interpolation == Interpolation::tricubic;
  m.name = "ray-marcher", m.lattice = "CC", m.kernel = cubic ? "tricubic" : "trilinear";
  m.gradient = cubic ? "analytic" : "central";
  m.step = options.step;
  m.draw = [&scene, options, &context](Image& image) { ray_march(scene, options, context.get(), image); };
  return m;
}

} // namespace bccsplat::bench
