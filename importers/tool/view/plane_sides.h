// SPDX-License-Identifier: Apache-2.0
// How planes along the samples' axes lie in a picture: which axis runs to the right, which up, and what its
// ends are called.
#pragma once

#include <array>
#include <string>

#include "tool/handles.h"

namespace bcc4 {

// A direction in a picture, along an axis of the samples.
struct PlaneAxis {
  uint32_t axis = 0;
  bool falls = false;    // whether samples with higher numbers lie to the left, or below
  std::string low, high; // names of the ends at the left or below, and at the right or on top; "": none
};

struct PlaneSides {
  PlaneAxis right, up;
  uint32_t across = 0; // the axis that the plane cuts
};

// Coronal, sagittal and axial, or x z, y z and x y of a world without sides. As radiologists have them: a
// patient's left is on the right, so that he is seen from his face and his feet, and from his left side;
// front and head are up, in the sagittal plane the front is on the left. Axes that lie aslant to the world
// have the names of the sides they are nearest to.
[[nodiscard]] std::array<PlaneSides, 3> plane_sides(const Volume& volume);

} // namespace bcc4
