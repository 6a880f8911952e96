// SPDX-License-Identifier: Apache-2.0
// Decodes an array: words of text, or behind counts plain bytes or zlib blocks. All of it may be hostile.
#include "readers/vti/vti_data.h"

#include <algorithm>
#include <cstring>

#include "readers/decoders.h"
#include "readers/vti/base64.h"

namespace bcc4 {
namespace {

uint64_t load_count(std::span<const std::byte> at, const VtiCoding& coding) {
  std::byte bytes[8]{};
  std::copy_n(at.begin(), coding.count_size, bytes);
  if (coding.swap) std::reverse(bytes, bytes + coding.count_size);
  uint64_t value = 0;
  if (coding.count_size == 4) {
    uint32_t narrow = 0;
    std::memcpy(&narrow, bytes, 4);
    value = narrow;
  } else {
    std::memcpy(&value, bytes, 8);
  }
  return value;
}

// How the bytes of an array are divided.
struct Blocks {
  uint64_t count = 0, size = 0;
  uint64_t last = 0; // size of the last one; 0: that of the others
  Bytes sizes;       // compressed ones, as the file has them

  [[nodiscard]] uint64_t decoded_size(uint64_t block) const {
    return block + 1 == count && last ? last : size;
  }
  [[nodiscard]] uint64_t stored_size(uint64_t block, const VtiCoding& coding) const {
    return load_count(std::span(sizes).subspan(block * coding.count_size), coding);
  }
};

// Takes block count, block size, size of the last block and compressed sizes.
Blocks take_head(VtiSource& source, const VtiCoding& coding, const VtiContent& content) {
  const uint64_t expected = content.bytes();
  const std::string_view rewind = source.base64;
  const Bytes head = source.take(3 * coding.count_size);
  const auto number = [&](size_t i) {
    return load_count(std::span(head).subspan(i * coding.count_size), coding);
  };
  Blocks blocks{number(0), number(1), number(2), {}};
  if (blocks.count > source.left() / coding.count_size ||
      blocks.size > largest_inflated(content.file_bytes) ||
      (blocks.count > 0 &&
       (blocks.count - 1) * blocks.size + blocks.decoded_size(blocks.count - 1) != expected) ||
      (blocks.count == 0 && expected != 0))
    content.refuse(" declares ", blocks.count, " blocks of ", blocks.size, " bytes, but ", expected,
                   " bytes are expected");
  if (expected > largest_inflated(source.left()))
    fail_input(content.path, ": ", source.left(), " compressed bytes cannot hold ", expected);
  if (source.file) {
    blocks.sizes = source.take(blocks.count * coding.count_size);
  } else { // the whole head is one base64 run
    source.base64 = rewind;
    const Bytes whole = source.take((3 + blocks.count) * coding.count_size);
    blocks.sizes.assign(whole.begin() + 3 * coding.count_size, whole.end());
  }
  return blocks;
}

Bytes decode_blocks(VtiSource& source, const VtiCoding& coding, const VtiContent& content) {
  const Blocks blocks = take_head(source, coding, content);
  const auto refuse_block = [&](uint64_t b, const char* why) {
    fail_input(content.path, ": block ", b, " of array ", content.name, why);
  };
  uint64_t compressed = 0;
  for (uint64_t b = 0; b < blocks.count; ++b) {
    const uint64_t size = blocks.stored_size(b, coding);
    if (size > source.left()) refuse_block(b, " is cut off");
    compressed += size;
  }
  const Bytes data = source.take(compressed);
  Bytes out(content.bytes());
  uint64_t from = 0, to = 0;
  for (uint64_t b = 0; b < blocks.count; ++b) {
    const uint64_t size = blocks.stored_size(b, coding), room = blocks.decoded_size(b);
    if (!inflate_block(std::span(data).subspan(from, size), std::span(out).subspan(to, room)))
      refuse_block(b, " is damaged");
    from += size;
    to += room;
  }
  return out;
}

// One count, then the bytes, in one base64 run.
Bytes decode_plain(VtiSource& source, const VtiCoding& coding, const VtiContent& content) {
  if (content.bytes() > source.left()) content.refuse_size(source.left());
  const Bytes all = source.take(coding.count_size + content.bytes());
  if (load_count(all, coding) != content.bytes()) content.refuse_size(load_count(all, coding));
  return {all.begin() + coding.count_size, all.end()};
}

} // namespace

void VtiContent::refuse_size(uint64_t held) const {
  refuse(" holds ", held, " bytes, but ", count, " values x ", type_size(type), " bytes = ", bytes(),
         " are expected");
}

uint64_t VtiSource::left() const {
  if (!file) return base64.size() / 4 * 3 + 3;
  return offset < file->size() ? file->size() - offset : 0;
}

Bytes VtiSource::take(uint64_t bytes) {
  if (bytes > left())
    fail_input(path, ": ", bytes, " bytes of data are declared where ", left(), " are left");
  if (!file) return take_base64(base64, bytes, path);
  Bytes out(bytes);
  file->read(offset, out);
  offset += bytes;
  return out;
}

Bytes decode_text(std::string_view text, const VtiContent& content) {
  const auto words = split(text);
  const size_t size = type_size(content.type);
  if (words.size() != content.count) content.refuse_size(words.size() * size);
  Bytes out(content.bytes());
  for (size_t i = 0; i < words.size(); ++i)
    if (!parse_value(words[i], content.type, out.data() + i * size))
      fail_input(content.path, ": \"", words[i].substr(0, 40), "\" in array ", content.name, " is no ",
                 type_name(content.type));
  return out;
}

Bytes decode_bytes(VtiSource source, const VtiCoding& coding, const VtiContent& content) {
  return coding.compressed ? decode_blocks(source, coding, content) : decode_plain(source, coding, content);
}

} // namespace bcc4
