// SPDX-License-Identifier: Apache-2.0
// How many there can be of what a file counts. Each count is held against what holds it -- the bytes that are
// left, the file, its frames, samples and distances -- where it is read, before anything is allocated for it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/block_ref.h"
#include "base/bytes.h"
#include "base/error.h"
#include "formats/bcc4/layout.h"
#include "lattice/lattice.h"

namespace bccsplat {

// Planes and layers on either side of the source samples.
inline constexpr int32_t most_beyond = 255;
// Distances of planes in source samples, and of layers in frames.
inline constexpr double least_distance = 0x1p-16, most_distance = 0x1p16;

// What a list has an element for each of, if it has any: `all` of them.
struct OneForEach {
  uint64_t all = 0;
  std::string_view of; // in words
};

// Read a count of elements of at least `each` bytes, `what` in words: up to `most`; all or none. They fail
// where the bytes left cannot hold so many.
[[nodiscard]] size_t read_count(ByteReader& in, std::string_view what, uint64_t each,
                                uint64_t most = UINT32_MAX);
[[nodiscard]] size_t read_count(ByteReader& in, std::string_view what, uint64_t each, const OneForEach& list);

// Refuses planes and layers that source samples, frames and ends have no use for. The lattice is called
// `name`; what else it says has been checked.
void check_planes_and_layers(const Lattice4& lattice, const std::string& name, Code code);

// Refuses chunks and pages that the bytes of the file have no room for.
void check_index_counts(const Root& root);

// Deflate makes at most 1032 bytes out of one.
[[nodiscard]] inline bool can_inflate(uint64_t stored, uint64_t decoded) {
  return stored < decoded && decoded <= stored * 1032;
}

// The bytes of run lists of so many sites, `kept` of which are set and `holes` of these: in canonical form at
// most one for each site and one more.
[[nodiscard]] uint64_t most_run_bytes(uint64_t sites, uint64_t kept = 0, uint64_t holes = 0);
// The bytes of a block of corrections of so many samples, and of the table of so many bricks.
[[nodiscard]] uint64_t most_correction_bytes(uint64_t samples);
[[nodiscard]] uint64_t most_table_bytes(uint64_t bricks);
// check_block_ref() of a block that decodes to so many bytes at most.
void check_block_ref(const BlockRef& ref, std::string_view what, uint64_t file_bytes, uint64_t most);

} // namespace bccsplat
