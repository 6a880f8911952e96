// SPDX-License-Identifier: Apache-2.0
// How well the samples next to the faces of a frame are predicted by those inside: what lies outside should
// be predicted no bolder than that.
#pragma once

#include <array>
#include <cstdint>

#include "fit/beyond/noise_trial.h"
#include "fit/frame/frame.h"
#include "lattice/lattice.h"

namespace bccsplat {

// One of end_noises for each axis: the one that predicts the samples on both faces best of those behind
// them.
using FaceLevels = std::array<uint8_t, 3>;
inline constexpr FaceLevels usual_face_levels{usual_noise_level, usual_noise_level, usual_noise_level};
[[nodiscard]] FaceLevels choose_face_levels(const Frame& frame, const Lattice4& lattice);

} // namespace bccsplat
