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

inline constexpr uint16_t bcc4_version = 5;
inline constexpr uint64_t header_bytes = 64;
inline constexpr uint64_t root_offset = header_bytes;
inline constexpr uint64_t root_bytes = 128;
inline constexpr uint64_t preamble_bytes = root_offset + root_bytes;

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

// Returns header and root.
[[nodiscard]] std::vector<std::byte> write_preamble(const Root& root);

struct Preamble {
  std::optional<Root> root; // if its record is valid
  std::string problem;      // else what is wrong with it
};
// Reads the preamble from its bytes, or from all bytes of a shorter file. Throws not_bcc4,
// unsupported_version, corrupt, truncated.
[[nodiscard]] Preamble read_preamble(std::span<const std::byte> bytes, std::string_view file);
// Returns the root of a file whose own record is not valid: the copy that a writer put behind the state
// before it replaced the record, which is in the last root_bytes of the file; none if these are no root.
[[nodiscard]] std::optional<Root> read_root_copy(std::span<const std::byte> last, uint64_t file_bytes);

} // namespace bccsplat
