// SPDX-License-Identifier: Apache-2.0
// The parts of a series that are joined to one file.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "base/files.h"
#include "formats/bcc4/part.h"

namespace bccsplat {

class Bcc4Reader;

using SeriesParts = std::vector<std::shared_ptr<const Bcc4Reader>>;

// Opens parts in any order and returns them by their frames, then by z, y and x. Throws invalid_argument,
// naming them, unless they are the parts of one series and hold each of its samples once.
[[nodiscard]] SeriesParts open_parts(std::vector<std::unique_ptr<ByteSource>> sources);

// One of the writes of all parts, which joined_writes returns in order: of a slab with all parts that have
// bricks of it.
struct JoinedWrite {
  PartWrite write;
  std::vector<size_t> parts;
};
[[nodiscard]] std::vector<JoinedWrite> joined_writes(const SeriesParts& parts);

} // namespace bccsplat
