// SPDX-License-Identifier: Apache-2.0
// Any hyperplane a x + b y + c z + d t + e = 0, by the best way there is for it: merged layers for
// hyperplanes normal to an axis, resampling for all others and wherever a lattice of its own is asked for.
#pragma once

#include <memory>
#include <optional>

#include "field/coefficients/coefficients.h"
#include "field/slice.h"
#include "points/uneven_axes.h"
#include "slice/part.h"
#include "slice/plane_geometry.h"
#include "slice/thickness.h"

namespace bccsplat {

enum class SliceMethod : uint8_t { best, merged, resampled };

struct HypersliceOptions {
  SliceMethod method = SliceMethod::best;
  std::array<double, 2> interval{0, 0}; // mean over these frames around a time slice; excludes a thickness
  Thickness thickness;
  double spacing = 0;                // of the target lattice, as PlaneOptions has it
  std::optional<Vec4> bandwidth;     // of a resampled slice under the paper's kernel, likewise
  std::optional<LatticeKind> target; // bcc or cc; none: the volume's own where it fits, else BCC
  double time_length = 1;            // world units that one frame is drawn as
  // Slice space, lying in the hyperplane: resampled on a lattice along its axes.
  std::optional<PlaneAxes> axes;
  // Only this box of a time slice is made; the coefficients may be of `reads` alone.
  std::optional<IndexBox> box;
  // Slice space, box and hyperplane are of even positions along these axes, and so is the slice
  // (even_slice.h); null: all are indices.
  std::shared_ptr<const UnevenAxes> even;
  // A moment of a series is merged when its bricks are first looked at (time_slice.h).
  bool merge_later = false;
  [[nodiscard]] BrickBox reads(const Lattice4& lattice) const;

  [[nodiscard]] bool has_interval() const { return interval[0] != 0 || interval[1] != 0; }
};

// A hyperplane that misses the domain gives an empty slice; a time slice outside the series throws
// out_of_domain, a method that the hyperplane or the options do not allow unsupported. Corrections and
// masks that the coefficients know of are in every slice (corrected_slice.h, masked_slice.h).
[[nodiscard]] Slice hyperslice(const Coefficients& coefficients, const Hyperplane& hyperplane,
                               const HypersliceOptions& options, const Affine3& index_to_world,
                               const Context& context);

// Makes what hyperslice would ask the coefficients for, and leaves it in their cache. Only for slices that
// are merged in time: unsupported for others.
void prepare_hyperslice(const Coefficients& coefficients, const Hyperplane& hyperplane,
                        const HypersliceOptions& options, const Context& context);

// The first and the last moment (frames) that a slice looks at.
struct SliceMoments {
  std::array<double, 2> masks{}, corrections{};
};
// Asks the samples behind the coefficients for all that hyperslice would ask them for, and makes nothing of
// it. Returns what masks and corrections it would look at, without reading them; nothing for an empty slice.
[[nodiscard]] std::optional<SliceMoments> rehearse_hyperslice(const Coefficients& coefficients,
                                                              const Hyperplane& hyperplane,
                                                              const HypersliceOptions& options,
                                                              const Context& context);

} // namespace bccsplat
