// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/coding/mask_runs.h"

namespace bccsplat {

void MaskRunWriter::write_run() {
  if (begin_ == end_) return;
  out_.write_varint(begin_ - written_);
  out_.write_varint(end_ - begin_);
  written_ = end_;
}

void MaskRunWriter::add(uint64_t begin, uint64_t end) {
  if (begin == end) return;
  if (begin != end_ || begin_ == end_) {
    write_run();
    begin_ = begin;
  }
  end_ = end;
}

std::vector<std::byte> MaskRunWriter::finish() {
  write_run();
  begin_ = end_ = written_ = 0;
  return out_.release();
}

void read_mask_runs(std::span<const std::byte> decoded, uint64_t voxels, uint64_t offset,
                    const MaskRunBody& body) {
  ByteReader in(decoded, "mask", offset);
  uint64_t at = 0;
  for (bool first = true; in.remaining() > 0; first = false) {
    const uint64_t skip = in.read_varint(), run = in.read_varint();
    if (run == 0 || (skip == 0 && !first))
      fail(Code::corrupt, "mask at offset ", offset, ": pair (", skip, ", ", run,
           ") is empty or not canonical");
    if (skip > voxels - at || run > voxels - at - skip)
      fail(Code::corrupt, "mask at offset ", offset, ": pair (", skip, ", ", run, ") goes beyond the ",
           voxels - at, " samples that are left of a frame");
    at += skip + run;
    body(at - run, at);
  }
  if (at == 0) fail(Code::corrupt, "mask at offset ", offset, ": it is empty");
}

} // namespace bccsplat
