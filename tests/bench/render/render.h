// SPDX-License-Identifier: Apache-2.0
// Suite `render`: time against error of the renderer, the ray-marcher and the paper's method on the same
// pictures.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tests/bench/image_error.h"
#include "tests/bench/report.h"
#include "tests/bench/scene.h"

namespace bccsplat::bench {

//   render [--front] [--equal] [--equal-series] [--equal-large] [--own] [--ratios] [--interactive] [--minify]
//   [--narrow]
//          [--coast] [--edges] [--grain] [--threads]
//   all of them but --equal-large without an option
int run_render_suite(std::span<const std::string> args, const Report& report);

// One way of drawing a picture.
struct Method {
  std::string name, lattice, kernel, gradient;
  double step = 0; // T
  std::function<void(Image&)> draw;
};

// CPU time of one frame of each, milliseconds: the least of `rounds`, the methods taking turns, so that all
// see the same machine.
[[nodiscard]] std::vector<double> least_ms(std::span<const Method> methods, int size, int rounds);
[[nodiscard]] ImageError method_error(const Method& method, int size, const Image& truth, int stride);

// Draws until what a renderer keeps from picture to picture is there.
void settle(const Method& method, int size);

// The splatter as a method. The scene and the context must outlive it.
[[nodiscard]] Method splat_method(const std::string& name, const Scene& scene, const RenderOptions& options,
                                  BenchContext& context);
[[nodiscard]] Method march_method(const MarchScene& scene, const MarchOptions& options,
                                  BenchContext& context);
[[nodiscard]] const char* quality_name(Quality quality);
[[nodiscard]] const char* mode_name(RenderMode mode);
[[nodiscard]] const char* gradient_name(GradientMethod gradient);

void render_front(const Report& report);        // error against the analytic field, and the plot
void render_equal(const Report& report);        // time at equal error, error at equal time; and plots
void render_equal_series(const Report& report); // the same of a moment of a series of 256^3
void render_equal_large(const Report& report);  // of 512^3, which takes minutes and 4 GiB
void render_own(const Report& report);          // against the samples' own field: order, gradients
void render_ratios(const Report& report);       // two methods in turn
void render_interactive(const Report& report);  // turn the camera, play, jump
void render_minify(const Report& report);       // pictures smaller than the data
void render_narrow(const Report& report);       // transfer functions narrower than a step
void render_coast(const Report& report);        // data with missing samples
void render_edges(const Report& report);        // smooth edges of isosurfaces
void render_grain(const Report& report);        // contours of the sheets on dense fields
void render_threads(const Report& report);      // what dividing a frame adds to it

} // namespace bccsplat::bench
