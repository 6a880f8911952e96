// SPDX-License-Identifier: Apache-2.0
// Takes a .bcc4 file apart and puts it together again with changes, every checksum right: what a damaged or
// hostile writer could have made. New parts go behind the old file; the old ones stay, unused.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include <cstring>

#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/metadata.h"
#include "formats/bcc4/page.h"

namespace bccsplat::test {

using Bytes = std::vector<std::byte>;

struct Edit {
  std::function<void(Bytes&)> metadata = {};                 // decoded
  std::function<void(Bcc4Chunk&, Bytes&)> chunk = {};        // of every chunk, with its stored bytes
  std::function<void(std::vector<Bcc4Chunk>&)> entries = {}; // of every page
  std::function<void(Bytes&)> page = {};                     // decoded, of every page
  std::function<void(std::vector<PageRef>&)> pages = {};
  std::function<void(Bytes&)> directory = {}; // decoded
  std::function<void(Root&)> root = {};
  bool raw_blocks = false; // not deflated
};

inline Edit with_info(const std::function<void(VolumeInfo&)>& change) {
  return {.metadata = [change](Bytes& m) {
    VolumeInfo v = read_metadata(m, 0, {});
    change(v);
    m = write_metadata(v);
  }};
}
inline Edit with_pages(const std::function<void(std::vector<PageRef>&)>& change) { return {.pages = change}; }

class Rebuild {
 public:
  Rebuild(const Bytes& file, const Edit& edit) : file_(file), edit_(edit) {
    const Preamble preamble = read_preamble(std::span(file).first(preamble_bytes), "file");
    if (!preamble.root) fail(Code::checksum_mismatch, preamble.problem);
    old_ = *preamble.root;
    Bytes metadata = block(old_.metadata);
    const VolumeInfo info = read_metadata(metadata, 0, {});
    std::vector<PageRef> pages = read_directory(block(old_.directory), info, old_, 0);
    Root root = old_;
    root.runs_bytes = root.values_bytes = 0;
    uint64_t padding = 0;
    for (PageRef& p : pages) {
      std::vector<Bcc4Chunk> entries = read_page(block(p.block), p, info, old_.file_bytes);
      for (Bcc4Chunk& c : entries) {
        if (edit.chunk) add_chunk(c);
        root.runs_bytes += c.runs_bytes, root.values_bytes += c.values_bytes;
        padding += c.stored() - c.runs_bytes - c.values_bytes;
      }
      if (edit.entries) edit.entries(entries);
      p = describe_page(p.at(), entries);
      Bytes decoded = write_page(entries);
      if (edit.page) edit.page(decoded);
      p.block = add_block(decoded);
    }
    if (edit.pages) edit.pages(pages);
    Bytes directory = write_directory(pages);
    if (edit.directory) edit.directory(directory);
    if (edit.metadata) edit.metadata(metadata);
    root.directory = add_block(directory);
    root.metadata = add_block(metadata);
    root.file_bytes = file_.size();
    root.index_bytes = preamble_bytes + padding + root.directory.padded() + root.metadata.padded();
    for (const PageRef& p : pages) root.index_bytes += p.block.padded();
    if (edit.root) edit.root(root);
    const Bytes head = write_preamble(root);
    std::copy(head.begin(), head.end(), file_.begin());
  }
  [[nodiscard]] const Bytes& file() const { return file_; }

 private:
  [[nodiscard]] Bytes block(const BlockRef& ref) const {
    return unpack_block(ref, std::span(file_).subspan(ref.offset, ref.padded()), "block");
  }
  void add_chunk(Bcc4Chunk& c) {
    const auto first = file_.begin() + c.offset;
    Bytes bytes(first, first + c.stored());
    edit_.chunk(c, bytes);
    bytes.resize((bytes.size() + 7) / 8 * 8);
    c.crc = crc32_of(bytes);
    c.offset = file_.size();
    file_.insert(file_.end(), bytes.begin(), bytes.end());
  }
  [[nodiscard]] BlockRef add_block(const Bytes& decoded) {
    PackedBlock packed = pack_block(decoded);
    if (edit_.raw_blocks) {
      packed.bytes = decoded;
      packed.ref.coding = 0, packed.ref.stored = packed.ref.decoded;
      packed.bytes.resize(packed.ref.padded());
      packed.ref.crc = crc32_of(packed.bytes);
    }
    packed.ref.offset = file_.size();
    file_.insert(file_.end(), packed.bytes.begin(), packed.bytes.end());
    return packed.ref;
  }

  Bytes file_;
  const Edit& edit_;
  Root old_;
};

[[nodiscard]] inline Bytes rebuild(const Bytes& file, const Edit& edit) { return Rebuild(file, edit).file(); }

// Overwrites a number inside bytes.
template<class T> void poke(Bytes& bytes, size_t at, T value) {
  ASSERT_LE(at + sizeof(T), bytes.size());
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}
template<class T> [[nodiscard]] T peek(const Bytes& bytes, size_t at) {
  T value{};
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

} // namespace bccsplat::test
