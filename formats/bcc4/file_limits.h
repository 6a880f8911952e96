// SPDX-License-Identifier: Apache-2.0
// How many bytes of a .bcc4 file are what, and how much it may have of each thing at most.
#pragma once

#include <cstdint>

namespace bccsplat {

struct Bcc4Bytes {
  uint64_t file = 0;
  uint64_t runs = 0;   // which sites are kept, and holes
  uint64_t values = 0; // samples
  uint64_t index = 0;  // tables, metadata, roots and padding; file = runs + values + index + unused
  uint64_t unused = 0; // referenced by nothing
};

// A file that exceeds one of them is refused before anything is allocated: Code::limit_exceeded. A writer
// makes no file whose layers, metadata or directory exceed them.
struct Bcc4Limits {
  uint64_t metadata_bytes = 64 << 20; // decoded
  uint64_t directory_bytes = 256 << 20;
  uint64_t bricks_per_layer = 16 << 20; // a layer holds 16 bytes for each
  int32_t planes = 16 << 20; // along an axis of space, and layers: some tables have a number for each
  uint32_t channels = 1024;
  uint32_t cached_pages = 64; // decoded index pages kept, each up to 3 MiB
  // Damaged chunks, and all chunks that a damaged index page may have listed, read as holes instead of
  // failing.
  bool salvage = false;
  // What cannot be read counts as holes, too.
  bool salvage_unreadable = false;
};

} // namespace bccsplat
