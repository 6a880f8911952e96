// SPDX-License-Identifier: Apache-2.0
// The parts of a series that are joined to one file.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/bcc4/part.h"

namespace bccsplat {

class Bcc4Reader;

// Sorts parts by their frames, then by z, y and x. Throws invalid_argument unless all are of one series and
// hold each of its samples once; `names` are for the text.
[[nodiscard]] std::vector<std::shared_ptr<const Bcc4Reader>>
order_parts(std::vector<std::shared_ptr<const Bcc4Reader>> parts, std::span<const std::string> names);

// One of the writes of all parts, which joined_writes returns in order: of a slab with all parts that have
// bricks of it.
struct JoinedWrite {
  PartWrite write;
  std::vector<size_t> parts;
};
[[nodiscard]] std::vector<JoinedWrite>
joined_writes(std::span<const std::shared_ptr<const Bcc4Reader>> parts);

} // namespace bccsplat
