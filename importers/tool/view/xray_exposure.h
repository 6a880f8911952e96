// SPDX-License-Identifier: Apache-2.0
// X-rays as pictures: line integrals between what the background's rays have and the most of any.
#pragma once

#include <optional>

#include "bccsplat.h"
#include "tool/handles.h"

namespace bcc4 {

struct XrayExposure {
  double background = 0; // of a ray, per world length
  double white = 0;      // what a ray has beyond that
};

// Returns the least that the background has: air, where its look says that nothing is to be seen below it.
// What a field rings below air beside an edge is no darker background.
[[nodiscard]] double least_background(const bccsplat_look& look, double air);

// Scales the integrals of a picture in place, to 0 for the background and 1 for white; what has a thousandth
// of white is black, too, since fields ring above air as well. Without an exposure it is measured, and kept
// for the pictures that follow; its background is not below `least`. film: what no ray of the volume reaches
// is black, too, not transparent.
void expose_xray(const bccsplat_frame* image, const bccsplat_camera& camera, const bccsplat_slice_info& slice,
                 double least, bool film, std::optional<XrayExposure>& exposure);

} // namespace bcc4
