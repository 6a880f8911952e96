// SPDX-License-Identifier: Apache-2.0
// Marks the points of a slice where the volume has no data.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/vec.h"
#include "field/masks.h"
#include "lattice/lattice.h"
#include "points/uneven_axes.h"

namespace bccsplat {

// The masks of the frames that a slice meets.
class SliceMask {
 public:
  // origin, basis: as of Slice. frames: `first` and those behind it, as counted, null where nothing is
  // missing.
  SliceMask(const std::array<int64_t, 4>& samples, const TurningAxes& turning, const Vec4& origin,
            const std::array<Vec4, 3>& basis, int64_t first, std::vector<FrameMaskPtr> frames);
  SliceMask(const Masks& masks, const Vec4& origin, const std::array<Vec4, 3>& basis, int64_t first,
            std::vector<FrameMaskPtr> frames);

  [[nodiscard]] bool missing(const Vec3& uvw) const;
  // Returns whether any sample of its frames is.
  [[nodiscard]] bool any() const;
  // Its samples as those of a grid in slice space: the nearest one along each axis decides.
  struct Grid {
    Int3 samples{};
    AxisFlags turning{};    // behind the last sample comes the first
    Vec3 scale{}, offset{}; // sample = offset + scale * uvw
    [[nodiscard]] Vec3 uvw(const Int3& sample) const {
      Vec3 p;
      for (size_t a = 0; a < 3; ++a) p[a] = (sample[a] - offset[a]) / scale[a];
      return p;
    }
    bool operator==(const Grid&) const = default;
  };
  // None where slice space is aslant to the samples, or they are unevenly spaced in it.
  [[nodiscard]] std::optional<Grid> grid() const;
  // Returns the same seen from even positions along uneven axes, with slice space at `origin` in them.
  [[nodiscard]] SliceMask from_even(const std::shared_ptr<const UnevenAxes>& axes, const Vec4& origin) const;
  // Returns what is missing here and in all the others.
  [[nodiscard]] SliceMask also(std::vector<std::shared_ptr<const SliceMask>> others) const;

 private:
  friend class MaskPlane;
  // Returns which of the frames decides at a moment.
  [[nodiscard]] size_t frame_at(double moment) const {
    const int64_t f = turning_[3] ? counted_sample(moment) : nearest_sample(moment, n_[3]);
    const auto last = first_ + static_cast<int64_t>(frames_.size()) - 1;
    return std::clamp(f, first_, last) - first_;
  }

  // Which axis of index space an axis of slice space runs along; none: along none of them.
  [[nodiscard]] std::optional<size_t> axis_along(size_t axis) const;

  // The sample that decides about a position along an axis of space.
  [[nodiscard]] int64_t sample_at(size_t axis, double position) const {
    if (even_ && even_->uneven(axis)) return even_->nearest_sample(axis, position);
    return turning_[axis] ? turned_sample(position, n_[axis]) : nearest_sample(position, n_[axis]);
  }

  std::array<int64_t, 4> n_;
  TurningAxes turning_;
  Vec4 origin_;
  std::array<Vec4, 3> basis_;
  int64_t first_;
  std::vector<FrameMaskPtr> frames_;
  std::vector<std::shared_ptr<const SliceMask>> others_;
  std::shared_ptr<const UnevenAxes> even_; // positions along its axes are even; null: all are indices
};

// The same for the points o + i u + j v of a plane of slice space, for many of them at once.
class MaskPlane {
 public:
  // mask: outlives it.
  MaskPlane(const SliceMask& mask, const Vec3& o, const Vec3& u, const Vec3& v);

  [[nodiscard]] bool missing(double i, double j) const;
  // Tells of the points i[0] <= i <= i[1], j[0] <= j <= j[1].
  [[nodiscard]] Missing within(const std::array<double, 2>& i, const std::array<double, 2>& j) const;

 private:
  // Place in the volume: at + i along_i + j along_j.
  struct Layer {
    const SliceMask* mask;
    Vec4 at, along_i, along_j;
    [[nodiscard]] double position(size_t axis, double i, double j) const {
      return at[axis] + (i * along_i[axis] + j * along_j[axis]);
    }
    // Between which positions along an axis the points are.
    [[nodiscard]] std::array<double, 2> between(size_t axis, const std::array<double, 2>& i,
                                                const std::array<double, 2>& j) const;
    [[nodiscard]] bool missing(double i, double j) const;
    [[nodiscard]] Missing within(const std::array<double, 2>& i, const std::array<double, 2>& j) const;
  };
  void add(const SliceMask& mask, const Vec3& o, const Vec3& u, const Vec3& v);

  std::vector<Layer> layers_; // a point is missing that is missing in all of them
};

} // namespace bccsplat
