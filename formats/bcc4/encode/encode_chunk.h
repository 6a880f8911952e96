// SPDX-License-Identifier: Apache-2.0
// Codes one chunk of samples.
#pragma once

#include "formats/bcc4/coding/chunk.h"

namespace bccsplat {

// Keeps all sites of a chunk of single bytes in which air is scattered: in a field whose values pass through
// that of air now and then, the gaps between runs cost more than samples. The code of air must stand for it.
void keep_scattered_air(ChunkSites& sites, const ChunkCodes& codes);

// `level` is that of Bcc4WriterOptions.
[[nodiscard]] EncodedChunk encode_chunk(const ChunkSites& sites, const ChunkCodes& codes, int level);

} // namespace bccsplat
