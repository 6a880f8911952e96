// SPDX-License-Identifier: Apache-2.0
// What lies beyond the faces of a field and the ends of a series, as a writer does it: mirrored, or predicted
// on planes and layers of the file's own, which are sites, too.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "choose/lattice_shape.h"

namespace bccsplat::series {

// Returns the flag that says PREDICT for the faces across axis 0, 1 or 2.
[[nodiscard]] constexpr int32_t face_bit(size_t axis) { return BCCSPLAT_FACES_PREDICT_X << axis; }
static_assert(face_bit(1) == BCCSPLAT_FACES_PREDICT_Y && face_bit(2) == BCCSPLAT_FACES_PREDICT_Z);

// Returns what a writer does at the faces of a series of `dims`, in words that fit a part of it, too.
[[nodiscard]] int32_t faces_of_part(const LatticeShape& shape, const std::array<uint64_t, 4>& dims);
// Does a writer of a series of `dims` predict what lies beyond its ends?
[[nodiscard]] bool predicts_ends(const LatticeShape& shape, const std::array<uint64_t, 4>& dims);
// What may be done beyond the ends: as a writer does unasked, or as given; faces predicted; the ends of time,
// too.
enum class Beyond : uint8_t { plain, faces, all };
inline constexpr std::array kBeyond{Beyond::plain, Beyond::faces, Beyond::all};
// Adds what is not given; samples of the source need nothing outside.
[[nodiscard]] LatticeShape with_beyond(LatticeShape shape, Beyond beyond);
// Do writers of a series do the same for both?
[[nodiscard]] bool goes_on_alike(const LatticeShape& a, const LatticeShape& b,
                                 const std::array<uint64_t, 4>& dims);
// Sites outside the faces and the ends of time, over those inside, where faces are predicted `across`
// (faces_of_part) and ends or not.
[[nodiscard]] double outside_share(const LatticeShape& shape, const std::array<uint64_t, 4>& dims,
                                   int32_t across, bool ends);
[[nodiscard]] double outside_share(const LatticeShape& shape, const std::array<uint64_t, 4>& dims);
// Sites per source sample, all of them.
[[nodiscard]] double whole_density(const LatticeShape& shape, const std::array<uint64_t, 4>& dims);
// Decibels, less what more sites than `density` per source sample make of them: errors fall with their
// square.
[[nodiscard]] double merit(double psnr, const LatticeShape& shape, const std::array<uint64_t, 4>& dims,
                           double density);

} // namespace bccsplat::series
