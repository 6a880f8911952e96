// SPDX-License-Identifier: Apache-2.0
// What the index of a .bcc4 file says of one chunk (bcc4.md, section 4).
#pragma once

#include <cstdint>

namespace bccsplat {

struct Bcc4Chunk {
  int32_t slab = 0;
  uint32_t slot = 0;                         // (bz * ny + by) * nx + bx, brick dims of coset 0
  uint64_t offset = 0;                       // of its bytes: values, runs, zeros up to a multiple of 8
  uint32_t values_bytes = 0, runs_bytes = 0; // stored
  uint32_t runs_decoded = 0;
  uint32_t kept = 0, holes = 0;        // sites; holes are kept too
  uint32_t min_code = 0, max_code = 0; // of the samples, ordered codes
  uint32_t crc = 0;
  uint8_t coding = 0, predictor = 0;
  [[nodiscard]] uint64_t stored() const { return (uint64_t{values_bytes} + runs_bytes + 7) / 8 * 8; }
  bool operator==(const Bcc4Chunk&) const = default;
};

} // namespace bccsplat
