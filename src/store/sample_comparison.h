// SPDX-License-Identifier: Apache-2.0
// Source samples of a frame against the slice that a reader would make.
#pragma once

#include <cstdint>
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
  bool whole = true;      // it is given all layers of the series
  double sample_step = 0; // of what is stored, as readers know it (formats/bcc4/sample_step.h)
};

// Value of one step of the corrections.
[[nodiscard]] constexpr double correction_step(double bound) { return bound; }

// Samples that are held, and what they are samples of.
struct ComparedPart {
  const HeldFrame& samples;
  uint32_t frame = 0;
};

// Adds the corrections that a bound asks for to residuals; of a channel with a bound a part is all of a
// frame. Throws bound_not_met where even they cannot keep it.
[[nodiscard]] SampleErrors compare_samples(const Slice& slice, const RoundTripChannel& channel,
                                           const ComparedPart& part, FrameResiduals& residuals,
                                           const Context& context);

} // namespace bccsplat
