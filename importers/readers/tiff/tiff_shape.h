// SPDX-License-Identifier: Apache-2.0
// The shape of the array that the pages of a file are, as tifffile writes it in JSON.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "readers/tiff/tiff_file.h"

namespace bcc4 {

// Axes of pages, the fastest first.
struct TiffShape {
  std::vector<uint64_t> sizes;
  std::string letters; // c, z and t, as many; "" where the file does not name them so
};

// Returns what the file says; nothing where it says none.
[[nodiscard]] std::optional<TiffShape> tiff_shape(const TiffFile& file);

} // namespace bcc4
