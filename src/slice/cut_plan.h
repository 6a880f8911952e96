// SPDX-License-Identifier: Apache-2.0
// A cut of the 4D field as the file's index alone tells it: by which way it is made, of what, and which masks
// and corrections are part of it. What it reads, what is read ahead and what is made of it follow this plan.
#pragma once

#include <array>
#include <vector>

#include "base/context.h"
#include "field/coefficients/coefficients.h"
#include "field/corrections.h"
#include "slice/layer_weights.h"
#include "slice/slice_options.h"

namespace bccsplat {

struct CutPlan {
  enum class Way : uint8_t {
    time,  // layers are merged (time_slice.h)
    axis,  // planes of sites are merged (axis_slice.h)
    plane, // the field is resampled (plane_slice.h)
    points // the paper's points (extraction.h)
  };

  const Coefficients* coefficients = nullptr; // outlive the plan
  Hyperplane hyperplane;
  HypersliceOptions options;
  Way way = Way::plane;
  bool empty = false;  // the hyperplane misses the domain
  size_t axis = 3;     // that a merged slice lies across
  double position = 0; // along it: a frame, or index units

  // The first and the last frame of a time slice, and the layers that their mean is merged of. A slice that
  // holds the largest value of some instants has these instead.
  std::array<double, 2> frames{};
  std::vector<LayerWeight> layers{};
  bool still = false; // the layer that stands at the instant is enough (Coefficients::compact_layers())
  std::vector<double> instants{};

  // The first and the last moment (frames) whose masks and whose corrections are looked at.
  std::array<double, 2> masks{}, corrections{};
  // The source samples whose corrections a time slice needs: of its box, if it is one.
  Corrections::Box corrected{};

  // Returns the plan of one of the instants, without what the whole is mended with.
  [[nodiscard]] CutPlan instant(double frame) const;
};

// Throws out_of_domain where a time slice is outside the series, unsupported for a method that the hyperplane
// or the options do not allow.
[[nodiscard]] CutPlan plan_cut(const Coefficients& coefficients, const Hyperplane& hyperplane,
                               const HypersliceOptions& options);
// The time slice at `frame`, or over [frame + interval[0], frame + interval[1]] clipped to time_span when the
// interval is not empty, by options.thickness.kind. Frames of a periodic series may lie a turn beyond. Throws
// out_of_domain.
[[nodiscard]] CutPlan plan_moment(const Coefficients& coefficients, double frame,
                                  const std::array<double, 2>& interval, const HypersliceOptions& options);

// Returns what a time slice is merged of, layer by layer.
[[nodiscard]] std::vector<CoefficientLayer> layers_of(const CutPlan& plan, const Context& context);
// Makes what a time slice is merged of, and leaves it in the cache of the coefficients; unsupported for other
// cuts, of which nothing is kept.
void fetch(const CutPlan& plan, const Context& context);
// Tells which bricks of the file the cut asks for; missing: beside what the coefficients hold.
void list_layers(const CutPlan& plan, bool missing, LayerReads& out);

} // namespace bccsplat
