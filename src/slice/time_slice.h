// SPDX-License-Identifier: Apache-2.0
// The hyperplane t = constant. With a kernel that is a product of space and time the 3D coefficients are
// weighted sums of the layers in reach, coset by coset, and the result is exact: evaluating it is evaluating
// the 4D field.
#pragma once

#include "slice/hyperslice.h"

namespace bccsplat {

// Merges the layers of a plan in time, with which nothing is mended. The sum is the integral over the frames,
// in value times frames, exact as the mean is; its air is the integral of the air value.
[[nodiscard]] Slice merged_moment(const CutPlan& plan, const Affine3& index_to_world, const Context& context);

// Cuts what plan_moment() plans. index_to_world is the volume's spatial affine.
[[nodiscard]] inline Slice thick_time_slice(const Coefficients& coefficients, double frame,
                                            const std::array<double, 2>& interval, ThicknessKind kind,
                                            const Affine3& index_to_world, const Context& context,
                                            bool later = false) {
  HypersliceOptions options;
  options.thickness.kind = kind, options.merge_later = later;
  return make_slice(plan_moment(coefficients, frame, interval, options), index_to_world, context);
}
[[nodiscard]] inline Slice time_slice(const Coefficients& coefficients, double frame,
                                      const std::array<double, 2>& interval, const Affine3& index_to_world,
                                      const Context& context) {
  return thick_time_slice(coefficients, frame, interval, ThicknessKind::mean, index_to_world, context);
}

} // namespace bccsplat
