// SPDX-License-Identifier: Apache-2.0
// Source samples of a frame against the slice that a reader would make.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "base/context.h"
#include "field/slice.h"
#include "formats/bcc4/coding/residuals.h"
#include "store/held_frame.h"
#include "store/sample_errors.h"

namespace bccsplat {

struct RoundTripChannel {
  std::string name; // for error texts
  double air = 0;   // of the source; readers have the nearest float
  float threshold = 0;
  double bound = 0;       // 0: measured only
  bool whole = true;      // its field may get a base of its own: all layers of the series are given
  double sample_step = 0; // of what is stored, as readers know it (formats/bcc4/sample_step.h)
  double read_off = 0;    // how far layers may be from what readers get of them
  // Layers whose sites are the samples hold boxes of this type as they are.
  SourceType as_given = SourceType::unknown;
};

// Value of one step of the corrections.
[[nodiscard]] constexpr double correction_step(double bound) { return bound; }

// Source samples, and what they are samples of.
struct ComparedPart {
  // Fills a plane, x fastest, with absolute values; NaN and infinities as they are.
  using Plane = std::function<void(int64_t z, double* to)>;
  Plane plane;
  HeldGrid grid;
  uint32_t frame = 0;
  std::array<uint32_t, 4> dims{}; // samples of the series, which number the voxels of corrections
  double doubt = 0; // how far what a reader gets may be from what is compared, beside rounding of values
};

// Adds the corrections that a bound asks for to residuals, by voxels of the frame; of a channel with a bound
// a part has every sample of its box, and what it adds comes behind what is there. Throws bound_not_met where
// even they cannot keep it.
[[nodiscard]] SampleErrors compare_samples(const Slice& slice, const RoundTripChannel& channel,
                                           const ComparedPart& part, FrameResiduals& residuals,
                                           const Context& context);

// Fills planes z .. z + count - 1 of the grid with what a reader gets; NaN where there is no value.
using ReadPlanes = std::function<void(int64_t z, int64_t count, float* to)>;
[[nodiscard]] SampleErrors compare_samples(const ReadPlanes& read, const RoundTripChannel& channel,
                                           const ComparedPart& part, FrameResiduals& residuals,
                                           const Context& context);

} // namespace bccsplat
