// How well the samples next to the faces of a frame are foretold by those inside: what lies outside should be
// predicted no bolder than that.
#pragma once

#include <array>
#include <cstdint>

#include "fit/frame.h"
#include "lattice/lattice.h"

namespace bccsplat {

// Noise of predictions (ends.h) that are tried, over the power of the field: waves need little, computed
// tomography much (tests/bench/notes/ends.md).
inline constexpr std::array<double, 5> face_noises{1e-5, 1e-4, 1e-3, 1e-2, 1e-1};

// By axis a number of face_noises: the one that foretells the samples on both faces best of those behind
// them; 2 where nothing tells.
using FaceLevels = std::array<uint8_t, 3>;
inline constexpr FaceLevels usual_face_levels{2, 2, 2};
[[nodiscard]] FaceLevels choose_face_levels(const Frame& frame, const Lattice4& lattice);

} // namespace bccsplat
