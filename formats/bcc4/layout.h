// SPDX-License-Identifier: Apache-2.0
// The fixed records at the head of a .bcc4 file, and blocks (bcc4.md, sections 2 to 4).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/block_ref.h"
#include "base/bytes.h"
#include "base/progress.h"

namespace bccsplat {

inline constexpr uint16_t bcc4_version = 4;
// What a writer says that uses nothing newer.
inline constexpr uint16_t usual_version = 3;
inline constexpr uint64_t header_bytes = 64;
inline constexpr uint64_t root_bytes = 128;
inline constexpr std::array<uint64_t, 2> root_offsets{4096, 8192};
inline constexpr uint64_t preamble_bytes = 12288; // header, roots and the zeros between them

inline constexpr uint64_t block_ref_bytes = 24;

struct Root {
  uint64_t sequence = 0;
  uint64_t file_bytes = 0;
  BlockRef metadata, directory;
  uint64_t chunks = 0;
  uint64_t runs_bytes = 0, values_bytes = 0; // of the stored parts of all chunks
  uint64_t index_bytes = 0;                  // preamble, blocks, padding of chunks
  bool unfinished = false;                   // of a series that is being written, or was left
  uint32_t frames = 0;                       // of an unfinished one: those that can be looked at
};
// A record of root_bytes.
[[nodiscard]] std::vector<std::byte> write_root(const Root& root);

void write_block_ref(ByteWriter& out, const BlockRef& ref);
[[nodiscard]] BlockRef read_block_ref(ByteReader& in);
// Checks that a block lies where it may and that its sizes agree. `what` names it in error texts,
// `file_bytes` is that of the root.
void check_block_ref(const BlockRef& ref, std::string_view what, uint64_t file_bytes);

struct PackedBlock {
  BlockRef ref;                 // without its offset
  std::vector<std::byte> bytes; // ref.padded() of them
};
// Compresses a block. With progress it throws Code::cancelled soon after a cancel.
[[nodiscard]] PackedBlock pack_block(std::span<const std::byte> decoded, Progress* progress = nullptr);
// Decodes a block after checking its checksum, padding and size. `bytes` are ref.padded() of them.
[[nodiscard]] std::vector<std::byte> unpack_block(const BlockRef& ref, std::span<const std::byte> bytes,
                                                  std::string_view what);

// Returns the whole preamble; a root of a file of no bytes is unused. lowest_reader is the version that a
// reader of the file needs.
[[nodiscard]] std::vector<std::byte> write_preamble(const std::array<Root, 2>& roots,
                                                    uint16_t lowest_reader = 1);

struct Preamble {
  uint16_t lowest_reader = 1;
  std::optional<Root> root;  // the valid one of the highest sequence number
  bool root_damaged = false; // the other one is neither valid nor unused
  std::string problem;       // of the first root that is not valid
};
// Reads the preamble from its bytes, or from all bytes of a shorter file. Throws not_bcc4,
// unsupported_version, corrupt, truncated.
[[nodiscard]] Preamble read_preamble(std::span<const std::byte> bytes, std::string_view file);

} // namespace bccsplat
