// SPDX-License-Identifier: Apache-2.0
// Where rays pass a value between two samples a sheet apart, many rays at once, a lane a ray.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/vec.h"
#include "field/footprint/footprint.h"

namespace bccsplat {

// A sample on a ray: the value less the target, and the slope per sheet.
struct RootEnd {
  float value = 0, slope = 0;
};

// A ray that passes the target, and between which samples: their values differ in sign.
struct RootPair {
  Vec3 origin{}, ray{}; // sheet 0 of it, and one sheet, lattice units
  int sheet = 0;        // of the first sample
  RootEnd low, high;
  uint32_t number = 0; // by which the caller knows the ray
};

struct RayRoot {
  double k = 0; // sheet number
  Vec3 position{};
  // The last sample near it, with the gradient per lattice unit.
  struct Sample {
    Vec3 position{};
    double value = 0;
    Vec3 gradient{};
  } sample;
  uint32_t number = 0;
};

// Brackets [low, high] around the roots of many rays, in sheets from the first sample, and within them where
// the field is asked for next.
struct RootLanes {
  static constexpr size_t room = 1024; // rays
  using Floats = std::array<float, room>;
  struct End {
    alignas(64) Floats x, value, slope;
  };
  End low, high;
  alignas(64) Floats next;
  std::array<uint64_t, room / 64> near; // bits of those whose next place is the root
};

struct RootArgs {
  size_t count = 0;
  const std::array<float, 4>* ray = nullptr; // lattice units of a sheet
  float target = 0;
  float tolerance = 0; // sheets from a sample to the root
};

// Guesses roots by the cubic through values and slopes at both ends.
void guess_roots(const RootArgs& args, RootLanes& lanes);
// The field at the guesses takes the place of one end of each bracket; guesses anew.
void bracket_roots(const RootArgs& args, std::span<const float> values,
                   std::span<const std::array<float, 4>> gradients, RootLanes& lanes);

// One thread's search.
class RayRoots {
 public:
  static constexpr size_t room = RootLanes::room;
  // target: as a float that values are less than where they are below it.
  RayRoots(const FootprintPlan& field, float target);

  void clear() { count_ = 0; }
  // At most `room`.
  void add(const RootPair& pair);
  [[nodiscard]] bool empty() const { return count_ == 0; }
  // Returns the roots of all pairs, in any order; they are good until the next call.
  [[nodiscard]] std::span<const RayRoot> find();

 private:
  // Guesses that are near enough become roots; the others move up.
  void take_roots(bool last);

  const FootprintPlan& field_;
  RootArgs args_;
  size_t count_ = 0, found_ = 0;
  struct Ray {
    Vec3 origin, ray;
    int sheet;
    uint32_t number;
  };
  RootLanes lanes_{};
  std::array<Ray, room> rays_;
  std::array<Vec4, room> places_;
  std::array<std::array<float, 4>, room> steps_{}; // rays, as the lanes take them
  std::array<float, room> values_;
  std::array<std::array<float, 4>, room> gradients_{};
  std::array<RayRoot, room> roots_;
};

} // namespace bccsplat
