// SPDX-License-Identifier: Apache-2.0
// Whether the affines that files tell make sense, and agree within a sequence.
#pragma once

#include <string>

#include "readers/affine.h"
#include "readers/frame_reader.h"
#include "readers/reader_options.h"

namespace bcc4 {

// Returns how far a sample can lie from where the other affine has it, in voxels of the first one.
[[nodiscard]] double shift_of(const Affine& a, const Affine& b, const std::array<uint64_t, 3>& samples,
                              bool with_origin = true);
// What single precision makes of one place, in voxels.
inline constexpr double same_place = .01;

// Throws when an affine is not finite or spans no volume, unless --spacing replaces it. `what` names the
// fields that it comes from.
void require_volume(const Affine& affine, const ReaderOptions& options, const std::string& path,
                    const std::string& what);

// Throws when the samples of `path`, a file of the sequence that `first` begins, lie elsewhere in the world
// than those of the first file, unless --spacing (and --origin) say where all of them lie.
void require_same_place(const SeriesDescription& first, const SeriesDescription& next,
                        const std::array<uint64_t, 3>& samples, const ReaderOptions& options,
                        const std::string& path);

} // namespace bcc4
