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

// Scales the integrals of a picture in place, to 0 for the background and 1 for white. Without an exposure it
// is measured, and kept for the pictures that follow.
void expose_xray(const Image& image, const bccsplat_camera& camera, const bccsplat_slice_info& slice,
                 std::optional<XrayExposure>& exposure);

} // namespace bcc4
