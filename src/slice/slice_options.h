// SPDX-License-Identifier: Apache-2.0
// What a slice may be asked for beside its hyperplane.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "points/uneven_axes.h"
#include "slice/part.h"
#include "slice/plane_geometry.h"
#include "slice/thickness.h"

namespace bccsplat {

enum class SliceMethod : uint8_t { best, merged, resampled, extracted };

struct HypersliceOptions {
  SliceMethod method = SliceMethod::best;
  std::array<double, 2> interval{0, 0}; // mean over these frames around a time slice; excludes a thickness
  Thickness thickness;
  // The distance of the target lattice, in index units; 0: along each of its axes that of the source's
  // samples, or less where the volume's lattice is finer. What is coarser than that is low-passed
  // (lowpass_slice.h).
  double spacing = 0;
  // Bandwidths of the paper's equation (6), which then gives a resampled slice its values (gaussian_mean.h);
  // under the paper's kernel, without a thickness. None: values are the field's.
  std::optional<Vec4> bandwidth;
  std::optional<LatticeKind> target; // bcc or cc; none: the volume's own where it fits, else BCC
  double time_length = 1;            // world units that one frame is drawn as
  // Slice space, lying in the hyperplane: resampled on a lattice along its axes.
  std::optional<PlaneAxes> axes;
  // Only this box of a time slice is made; the coefficients may be of `reads` alone.
  std::optional<IndexBox> box;
  // Slice space, box and hyperplane are of even positions along these axes, and so is the slice
  // (even_slice.h); null: all are indices.
  std::shared_ptr<const UnevenAxes> even;
  // A moment of a series is merged when its bricks are first looked at, where it has no holes; until then its
  // bounds are those of all moments between the same layers.
  bool merge_later = false;
  // No moment near it follows: where layers add up it is made as one sum, and none of them is kept.
  bool once = false;
  // The moment follows what moves between frames (motion/moving_series.h): a whole one, an instant.
  bool motion = false;
  // kernel: in any lattice's form.
  [[nodiscard]] BrickBox reads(const Lattice4& lattice, const Kernel& kernel) const;

  [[nodiscard]] bool has_interval() const { return interval[0] != 0 || interval[1] != 0; }
};

} // namespace bccsplat
