// SPDX-License-Identifier: Apache-2.0
// What comes through of the lights of a picture, kept for the next one while slice, function and lights stay.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "base/context.h"
#include "draw/shot.h"
#include "shade/light_volume.h"

namespace bccsplat {

class KeptLight {
 public:
  // Returns the light of a settled shot that casts shadows. The grid has half as many nodes along each axis
  // as the slice has samples. Throws memory_budget, cancelled.
  [[nodiscard]] std::shared_ptr<const LightVolume> of(const Shot& shot, const Context& context);
  void forget() { kept_.reset(), key_ = {}; }

 private:
  // What the light depends on.
  struct Key {
    const Slice* slice = nullptr;
    Affine3 lattice_to_world;
    std::vector<std::array<float, 4>> classes;
    float low = 0, scale = 0;
    std::vector<HalfSpace> clip;
    std::vector<Vec3> towards; // each light that throws shadows, lattice units
    bool occlusion = false;
    bool operator==(const Key&) const = default;
  };
  [[nodiscard]] static Key key_of(const Shot& shot);

  Key key_;
  std::shared_ptr<const LightVolume> kept_;
};

} // namespace bccsplat
