// SPDX-License-Identifier: Apache-2.0
// Writes and reads the record of a part.
#include "formats/bcc4/part.h"

#include "formats/bcc4/counts.h"
#include "formats/bcc4/info.h"

namespace bccsplat {
namespace {

constexpr size_t write_record_bytes = 16;

} // namespace

void write_part(ByteWriter& out, const PartInfo& part) {
  out.write(part.block.first_frame()), out.write(part.block.end_frame()), out.write(part.series);
  out.write(static_cast<uint32_t>(part.writes.size()));
  for (const PartWrite& w : part.writes) {
    out.write(w.trigger), out.write(w.channel + level_unit * w.level), out.write(w.slab);
    out.write(static_cast<uint32_t>(w.frame + 1));
  }
  out.write(static_cast<uint32_t>(part.statistics.size()));
  out.write_bytes(part.statistics);
}

PartInfo read_part(ByteReader& in, uint32_t frames, size_t channels, int levels) {
  PartInfo part;
  const auto first = in.read<uint32_t>(), end = in.read<uint32_t>();
  part.block = SeriesBlock::of_frames(first, end), part.series = in.read<uint32_t>();
  if (first >= end || end > frames) fail(Code::corrupt, "part: frames ", first, " .. ", end, " of ", frames);
  part.writes.resize(read_count(in, "writes", write_record_bytes));
  for (PartWrite& w : part.writes) {
    w.trigger = in.read<uint32_t>();
    const auto [channel, level] = unpacked(in.read<uint32_t>());
    w.channel = channel, w.level = level, w.slab = in.read<int32_t>();
    w.frame = int64_t{in.read<uint32_t>()} - 1;
    const bool exists = w.slab >= 0 || (w.slab == PartWrite::mask && w.frame != PartWrite::chunks);
    // Masks and corrections are of no level but 0.
    const bool known = w.channel < channels && level < levels && (level == 0 || w.frame == PartWrite::chunks);
    if (w.trigger > frames || !known || !exists || w.frame >= int64_t{frames})
      fail(Code::corrupt, "part: a write of channel ", w.channel, ", level ", level, ", slab ", w.slab,
           ", frame ", w.frame);
  }
  const auto bytes = in.take(in.read<uint32_t>());
  part.statistics.assign(bytes.begin(), bytes.end());
  return part;
}

void write_block(ByteWriter& out, const PartInfo& part) {
  for (size_t a = 0; a < 3; ++a) out.write(part.block.begin[a]), out.write(part.block.end[a]);
  write_part(out, part);
}

PartInfo read_block(ByteReader& in, const std::array<uint32_t, 4>& dims, size_t channels, int levels) {
  SeriesBlock box;
  for (size_t a = 0; a < 3; ++a) {
    box.begin[a] = in.read<uint32_t>(), box.end[a] = in.read<uint32_t>();
    if (box.begin[a] >= box.end[a] || box.end[a] > dims[a])
      fail(Code::corrupt, "block: samples ", box.begin[a], " .. ", box.end[a], " of ", dims[a], " along ",
           "xyz"[a]);
  }
  PartInfo part = read_part(in, dims[3], channels, levels);
  box.begin[3] = part.block.begin[3], box.end[3] = part.block.end[3];
  part.block = box;
  return part;
}

} // namespace bccsplat
