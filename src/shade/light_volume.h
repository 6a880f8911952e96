// SPDX-License-Identifier: Apache-2.0
// Transmittance from each light to each place of a volume, and from the surroundings.
//
// Extinction stands at the nodes of a grid, and so does what comes through. Light is followed plane by plane:
// on a grid that is sheared along its direction each beam is a column, whose optical depths are summed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/context.h"
#include "base/vec.h"
#include "lattice/lattice.h"

namespace bccsplat {

// Node (i, j, k) stands at begin + step (i, j, k).
struct LightGrid {
  Vec3 begin{}, step{1, 1, 1};
  Int3 nodes{1, 1, 1};
  [[nodiscard]] size_t size() const {
    return static_cast<size_t>(nodes[0]) * static_cast<size_t>(nodes[1]) * static_cast<size_t>(nodes[2]);
  }
  bool operator==(const LightGrid&) const = default;
};

// Where light comes from, in the grid's space: towards the light, and how long that vector is in the world.
struct LightWay {
  Vec3 direction{};
  double length = 1;
};

// Returns the share of a light that comes to each node (x fastest) through extinctions per world length.
[[nodiscard]] std::vector<float> light_through(const LightGrid& grid, std::span<const float> extinction,
                                               const LightWay& way, const Context& context);

// Fourteen directions of space, the axes and the diagonals of a cube, and the weight of each: what is a
// polynomial of degree 5 of the direction has the mean that it has over the sphere.
inline constexpr size_t ways_around = 14;
struct WayAround {
  Vec3 direction{};
  double weight = 0;
};
[[nodiscard]] std::span<const WayAround, ways_around> all_around();

// Immutable once made.
class LightVolume {
 public:
  // lights: what comes through of each, empty where they throw no shadow; ambient: of the light from all
  // around, or empty.
  LightVolume(const LightGrid& grid, std::vector<std::vector<float>> lights, std::vector<float> ambient,
              Reservation memory);

  [[nodiscard]] size_t lights() const { return lights_.size(); }
  [[nodiscard]] bool has_ambient() const { return !ambient_.empty(); }
  // Between nodes they are linear along each axis.
  [[nodiscard]] float light(size_t number, const Vec3& p) const { return at(lights_[number], p); }
  [[nodiscard]] float ambient(const Vec3& p) const { return at(ambient_, p); }
  [[nodiscard]] static uint64_t bytes_of(const LightGrid& grid, size_t planes) {
    return grid.size() * planes * sizeof(float);
  }

 private:
  [[nodiscard]] float at(const std::vector<float>& plane, const Vec3& p) const;

  LightGrid grid_;
  std::vector<std::vector<float>> lights_;
  std::vector<float> ambient_;
  Reservation memory_;
};

} // namespace bccsplat
