// SPDX-License-Identifier: Apache-2.0
// The scenes of the suites `render` and `skip`: an analytic field, how it is shown, and its samples on the
// lattices.
#pragma once

#include <memory>
#include <string>

#include "reference/reference.h"
#include "scene/picture.h"
#include "tests/bench/analytic.h"
#include "tests/bench/ray_march/ray_march.h"

namespace bccsplat::bench {

// Threads, memory and progress of one.
struct BenchContext {
  explicit BenchContext(int threads) : tasks(threads) {}
  Tasks tasks;
  MemoryBudget memory;
  Progress progress;
  [[nodiscard]] Context get() { return {tasks, memory, progress}; }
};

struct FieldScene {
  std::string name;
  int samples = 0; // per axis of the Cartesian grid; index space is world space
  AnalyticField field;
  TransferFunction function;
  double iso_value = 0.5;
};
[[nodiscard]] FieldScene marschner_lobb_scene(int samples);
[[nodiscard]] FieldScene bessel_scene(int samples); // band limited to 0.8 of Nyquist
[[nodiscard]] FieldScene smoke_scene(int samples);  // sparse
[[nodiscard]] FieldScene waves_scene(int samples);  // surfaces everywhere

// Sampled on BCC (71 % of the samples of the Cartesian grid) or on that grid, prefiltered for the kernel.
struct SampledScene {
  Slice slice;
  std::shared_ptr<const KeptPoints> points;
};
[[nodiscard]] SampledScene sample_scene(const FieldScene& scene, LatticeKind kind, const std::string& kernel);

// The whole domain from the default direction: pixels_per_t = 0 fits it into the picture.
[[nodiscard]] Camera scene_camera(const FieldScene& scene, int size, double pixels_per_t,
                                  bool perspective = false);

[[nodiscard]] Scene splat_scene(const FieldScene& scene, const SampledScene& sampled, const Camera& camera);

// Sees the pixels (stride i + stride / 2, ...) of what the camera sees, as a picture of their own: from the
// centre of a block of pixels to the pixel after it. In perspective the stride is odd.
[[nodiscard]] Camera strided_camera(const Camera& camera, int size, int stride);

// Pixels (stride i + stride / 2, ...) of the picture, in perspective of an odd stride, integrated in double.
// `own`: the field that the samples stand for; else the analytic one. step: T.
[[nodiscard]] std::unique_ptr<ImageStorage> true_image(const FieldScene& scene, const SampledScene& sampled,
                                                       const Camera& camera, const RenderOptions& options,
                                                       int size, int stride, bool own = false,
                                                       double step = 1.0 / 16);

} // namespace bccsplat::bench
