// SPDX-License-Identifier: Apache-2.0
// A TIFF file: pages of one size and type, and what the first one says in words.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "readers/value_type.h"

struct tiff;

namespace bcc4 {

// What all pages have in common.
struct TiffKind {
  uint32_t width = 0, height = 0;
  Type type = Type::u8;
  uint16_t samples = 1; // of a pixel, side by side
  uint16_t photometric = 0;
  bool operator==(const TiffKind&) const = default;
  [[nodiscard]] uint64_t page_bytes() const { return uint64_t{width} * height * samples * type_size(type); }
};

class TiffFile {
 public:
  // Looks at every page. Smaller copies of pages (pyramids, thumbnails) are left out.
  explicit TiffFile(const std::string& path);

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] const TiffKind& kind() const { return kind_; }
  [[nodiscard]] uint64_t pages() const { return offsets_.size(); }
  [[nodiscard]] const std::string& description() const { return description_; }
  // Bytes of a tile, held to read a page of tiles; the most of any page, 0 where none has tiles.
  [[nodiscard]] uint64_t tile_bytes() const { return tile_bytes_; }
  // Pixels in a unit of length along x (0) and y (1), where the file has them.
  [[nodiscard]] std::optional<double> resolution(size_t axis) const { return resolution_[axis]; }
  // Reads a page into kind().page_bytes() bytes, in native order, rows from the top.
  void read(uint64_t page, std::span<std::byte> values);

 private:
  void read_strips(uint64_t page, std::span<std::byte> values);
  void read_tiles(uint64_t page, std::span<std::byte> values);
  void describe_first_page();
  [[noreturn]] void fail_page(uint64_t page) const;

  std::string path_;
  std::unique_ptr<tiff, void (*)(tiff*)> file_;
  TiffKind kind_;
  uint64_t tile_bytes_ = 0;
  std::vector<uint64_t> offsets_; // of the pages' directories
  std::string description_;
  std::optional<double> resolution_[2];
};

} // namespace bcc4
