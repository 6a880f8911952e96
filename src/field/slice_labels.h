// SPDX-License-Identifier: Apache-2.0
// The values of a slice of labels, which nothing lies between: each point has that of the sample nearest to
// it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/memory.h"
#include "base/vec.h"
#include "lattice/lattice.h"
#include "points/uneven_axes.h"

namespace bccsplat {

// Uneven axes of the volume whose even positions slice space has, and which of them each of its axes runs
// along; null: it has indices.
struct EvenPlaces {
  std::shared_ptr<const UnevenAxes> axes;
  std::array<size_t, 3> along{};
  [[nodiscard]] bool uneven(size_t axis) const {
    return axes && along[axis] < 3 && axes->uneven(along[axis]);
  }
};

// A dense grid of samples: sample (i, j, k) stands at the index origin + (i, j, k) of slice space. Immutable
// once made.
class SliceLabels {
 public:
  // values: of each sample, x fastest.
  SliceLabels(const Vec3& origin, const Int3& samples, std::vector<float> values, Reservation memory,
              EvenPlaces even = {});

  [[nodiscard]] const Int3& samples() const { return samples_; }
  // The sample nearest to a place along an axis, by indices: half way the later one.
  [[nodiscard]] int32_t nearest(size_t axis, double place) const;
  [[nodiscard]] float value(const Int3& sample) const {
    const auto nx = static_cast<size_t>(samples_[0]), ny = static_cast<size_t>(samples_[1]);
    return values_[(static_cast<size_t>(sample[2]) * ny + static_cast<size_t>(sample[1])) * nx +
                   static_cast<size_t>(sample[0])];
  }
  // The value at a point of slice space.
  [[nodiscard]] float at(const Vec3& uvw) const {
    return value({nearest(0, uvw[0]), nearest(1, uvw[1]), nearest(2, uvw[2])});
  }

 private:
  Vec3 origin_;
  Int3 samples_;
  std::vector<float> values_;
  Reservation memory_;
  EvenPlaces even_;
};

} // namespace bccsplat
