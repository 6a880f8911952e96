// SPDX-License-Identifier: Apache-2.0
// The bytes of one array of a .vti file: from the file or from base64 text, in one piece or in zlib blocks.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "readers/byte_stream.h"
#include "readers/error.h"
#include "readers/frame_reader.h"

namespace bcc4 {

// How a file writes counts and blocks.
struct VtiCoding {
  bool swap = false;
  bool compressed = false; // by zlib
  size_t count_size = 4;   // bytes of a block count or size
};

// What an array is expected to hold; refusals name it.
struct VtiContent {
  const std::string& path;
  std::string_view name;
  Type type = Type::f32;
  uint64_t count = 0;      // of values
  uint64_t file_bytes = 0; // of the whole file, which bounds what can be in it

  [[nodiscard]] uint64_t bytes() const { return count * type_size(type); }
  template<class... Why> [[noreturn]] void refuse(const Why&... why) const {
    fail_input(path, ": array ", name, why...);
  }
  [[noreturn]] void refuse_size(uint64_t held) const;
};

// The place that the bytes of an array come from.
struct VtiSource {
  const std::string& path;
  InputFile* file = nullptr; // null: base64 text
  uint64_t offset = 0;
  std::string_view base64{};

  [[nodiscard]] uint64_t left() const;
  Bytes take(uint64_t bytes);
};

// Return an array's values; those of bytes in the byte order of the file.
[[nodiscard]] Bytes decode_text(std::string_view text, const VtiContent& content);
[[nodiscard]] Bytes decode_bytes(VtiSource source, const VtiCoding& coding, const VtiContent& content);

} // namespace bcc4
