// SPDX-License-Identifier: Apache-2.0
// Writes and reads the record of a part, refuses parts that are not one series without gaps and overlaps,
// naming what is wrong, and puts the writes of all into one order. Copying them is left to store/join.cpp.
#include "formats/bcc4/part.h"

#include <algorithm>
#include <numeric>

#include "formats/bcc4/bcc4.h"

namespace bccsplat {
namespace {

constexpr size_t write_record_bytes = 16;

// Names the first thing in which two series differ; empty when none has a name.
std::string difference(const VolumeInfo& a, const VolumeInfo& b) {
  if (a.lattice.dims != b.lattice.dims) return "the numbers of samples or frames differ";
  if (a.lattice != b.lattice || a.slab_layers != b.slab_layers) return "the lattices differ";
  if (!std::equal(a.levels.begin(), a.levels.end(), b.levels.begin(), b.levels.end(),
                  [](const StoredLattice& x, const StoredLattice& y) { return x == y; }))
    return "the levels differ";
  if (a.channels.size() != b.channels.size()) return "the channels differ";
  for (size_t c = 0; c < a.channels.size(); ++c) {
    const ChannelInfo &x = a.channels[c], &y = b.channels[c];
    if (x.name != y.name) return "the channels differ";
    if (x.type != y.type || x.scale != y.scale || x.offset != y.offset || x.air != y.air ||
        x.threshold != y.threshold)
      return "air, or how channel " + x.name + " is rounded, differs";
  }
  if (a.axes != b.axes) return "the coordinates along the axes differ";
  if (a.time != b.time) return "the times differ";
  if (a.sources != b.sources) return "the source files differ";
  if (a.attributes != b.attributes) return "the attributes differ";
  return "";
}

std::string frames_text(uint32_t first, uint32_t end) {
  return end - first == 1 ? concat("frame ", first) : concat("frames ", first, " to ", end - 1);
}

} // namespace

void write_part(ByteWriter& out, const PartInfo& part) {
  out.write(part.first), out.write(part.end), out.write(part.series);
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
  part.first = in.read<uint32_t>(), part.end = in.read<uint32_t>(), part.series = in.read<uint32_t>();
  if (part.first >= part.end || part.end > frames)
    fail(Code::corrupt, "part: frames ", part.first, " .. ", part.end, " of ", frames);
  const auto count = in.read<uint32_t>();
  if (count > in.remaining() / write_record_bytes)
    fail(Code::corrupt, "part: ", count, " writes do not fit their record");
  part.writes.resize(count);
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

std::vector<std::shared_ptr<const Bcc4Reader>>
order_parts(std::vector<std::shared_ptr<const Bcc4Reader>> parts, std::span<const std::string> names) {
  if (parts.empty()) fail(Code::invalid_argument, "no parts to join");
  for (size_t i = 0; i < parts.size(); ++i)
    if (!parts[i]->info().part)
      fail(Code::invalid_argument, names[i], ": a whole file, not a part of a series");
  std::vector<size_t> order(parts.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto part = [&](size_t i) -> const PartInfo& { return *parts[i]->info().part; };
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return part(a).first < part(b).first; });
  const VolumeInfo& series = parts[order[0]]->info();
  uint32_t end = 0;
  size_t before = order[0];
  for (const size_t i : order) {
    const std::string why = difference(series, parts[i]->info());
    if (!why.empty() || part(i).series != series.part->series)
      fail(Code::invalid_argument, names[i], ": not a part of the same series as ", names[order[0]], ": ",
           why.empty() ? "it was made with other options or by a version that resamples otherwise" : why);
    if (part(i).first > end)
      fail(Code::invalid_argument, frames_text(end, part(i).first), " of ", series.lattice.dims[3],
           " are in none of the parts: the one before ", names[i], " is missing");
    if (part(i).first < end)
      fail(Code::invalid_argument, frames_text(part(i).first, std::min(end, part(i).end)),
           part(i).end - part(i).first == 1 ? " is" : " are", " both in ", names[before], " and in ",
           names[i]);
    end = part(i).end;
    before = i;
  }
  if (end < series.lattice.dims[3])
    fail(Code::invalid_argument, frames_text(end, series.lattice.dims[3]), " of ", series.lattice.dims[3],
         " are in none of the parts: the one after ", names[before], " is missing");
  std::vector<std::shared_ptr<const Bcc4Reader>> sorted;
  for (const size_t i : order) sorted.push_back(parts[i]);
  return sorted;
}

std::vector<JoinedWrite> joined_writes(std::span<const std::shared_ptr<const Bcc4Reader>> parts) {
  std::vector<JoinedWrite> writes;
  for (size_t i = 0; i < parts.size(); ++i)
    for (const PartWrite& w : parts[i]->info().part->writes) writes.push_back({w, i});
  std::stable_sort(writes.begin(), writes.end(),
                   [](const JoinedWrite& a, const JoinedWrite& b) { return a.write < b.write; });
  return writes;
}

} // namespace bccsplat
