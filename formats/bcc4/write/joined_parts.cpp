// SPDX-License-Identifier: Apache-2.0
// Refuses parts that are not one series without gaps and overlaps, naming what is wrong, and puts the writes
// of all into one order. Copying them is left to store/join.cpp.
#include "formats/bcc4/write/joined_parts.h"

#include <algorithm>

#include "base/error.h"
#include "formats/bcc4/info.h"
#include "formats/bcc4/read/reader.h"

namespace bccsplat {
namespace {

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

// By the slowest axis first.
std::array<uint32_t, 4> reversed(const std::array<uint32_t, 4>& a) { return {a[3], a[2], a[1], a[0]}; }

std::string frames_text(uint32_t first, uint32_t end) {
  return end - first == 1 ? concat("frame ", first) : concat("frames ", first, " to ", end - 1);
}

// Names a box: of all space by its frames alone.
std::string box_text(const SeriesBlock& box, const std::array<uint32_t, 4>& dims) {
  std::string text = frames_text(box.begin[3], box.end[3]);
  const SeriesBlock whole = SeriesBlock::whole(dims);
  if (std::equal(box.begin.begin(), box.begin.begin() + 3, whole.begin.begin()) &&
      std::equal(box.end.begin(), box.end.begin() + 3, whole.end.begin()))
    return text;
  for (size_t a = 0; a < 3; ++a)
    text += concat(a == 0 ? ", x " : a == 1 ? ", y " : ", z ", box.begin[a], ":", box.end[a]);
  return text;
}

// A part of those that are joined, by its place in the list.
struct PlacedPart {
  size_t number;
  SeriesBlock box; // its ends said
};

// Takes the box of a part out of what is still missing of a series. Returns whether all of it was.
bool take_out(const SeriesBlock& box, std::vector<SeriesBlock>& missing) {
  std::vector<SeriesBlock> left;
  uint64_t found = 0;
  const auto samples = [](const SeriesBlock& b) {
    return uint64_t{b.end[0] - b.begin[0]} * (b.end[1] - b.begin[1]) * (b.end[2] - b.begin[2]) *
           (b.end[3] - b.begin[3]);
  };
  for (const SeriesBlock& m : missing) {
    const SeriesBlock both = m.cut(box);
    if (!both.empty()) found += samples(both);
    const std::vector<SeriesBlock> rest = without(m, box);
    left.insert(left.end(), rest.begin(), rest.end());
  }
  missing = std::move(left);
  return found == samples(box);
}

// Throws where boxes of the parts, in order, have something in common or leave something out.
void require_whole(std::span<const PlacedPart> parts, const std::array<uint32_t, 4>& dims,
                   std::span<const std::string> names) {
  std::vector<SeriesBlock> missing{SeriesBlock::whole(dims)};
  for (size_t i = 0; i < parts.size(); ++i) {
    if (take_out(parts[i].box, missing)) continue;
    size_t other = 0;
    while (parts[other].box.cut(parts[i].box).empty()) ++other;
    const SeriesBlock both = parts[other].box.cut(parts[i].box);
    const std::string text = box_text(both, dims);
    const bool many = text.starts_with("frames") || text.find(',') != std::string::npos;
    fail(Code::invalid_argument, text, many ? " are" : " is", " both in ", names[parts[other].number],
         " and in ", names[parts[i].number]);
  }
  if (missing.empty()) return;
  std::sort(missing.begin(), missing.end(),
            [](const SeriesBlock& a, const SeriesBlock& b) { return reversed(a.begin) < reversed(b.begin); });
  const SeriesBlock& first = missing.front();
  size_t before = 0;
  while (before < parts.size() && reversed(parts[before].box.begin) < reversed(first.begin)) ++before;
  fail(Code::invalid_argument, box_text(first, dims), " of ", dims[3], " are in none of the parts: the one ",
       before < parts.size() ? "before " : "after ", names[parts[std::min(before, parts.size() - 1)].number],
       " is missing");
}

SeriesParts order_parts(const SeriesParts& parts, std::span<const std::string> names) {
  if (parts.empty()) fail(Code::invalid_argument, "no parts to join");
  for (size_t i = 0; i < parts.size(); ++i)
    if (!parts[i]->info().part)
      fail(Code::invalid_argument, names[i], ": a whole file, not a part of a series");
  const auto dims_of = [&](size_t i) { return parts[i]->info().lattice.dims; };
  std::vector<PlacedPart> order;
  for (size_t i = 0; i < parts.size(); ++i)
    order.push_back({i, parts[i]->info().part->block.cut(SeriesBlock::whole(dims_of(i)))});
  std::stable_sort(order.begin(), order.end(), [](const PlacedPart& a, const PlacedPart& b) {
    return reversed(a.box.begin) < reversed(b.box.begin);
  });
  const size_t first = order.front().number;
  const VolumeInfo& series = parts[first]->info();
  for (const PlacedPart& p : order) {
    const VolumeInfo& info = parts[p.number]->info();
    const std::string why = difference(series, info);
    if (!why.empty() || info.part->series != series.part->series)
      fail(Code::invalid_argument, names[p.number], ": not a part of the same series as ", names[first], ": ",
           why.empty() ? "it was made with other options or by a version that resamples or codes otherwise"
                       : why);
  }
  require_whole(order, series.lattice.dims, names);
  SeriesParts sorted;
  for (const PlacedPart& p : order) sorted.push_back(parts[p.number]);
  return sorted;
}

} // namespace

SeriesParts open_parts(std::vector<std::unique_ptr<ByteSource>> sources) {
  SeriesParts parts;
  std::vector<std::string> names;
  for (std::unique_ptr<ByteSource>& source : sources) {
    names.push_back(source->name());
    parts.push_back(Bcc4Reader::open(std::move(source)));
  }
  return order_parts(parts, names);
}

std::vector<JoinedWrite> joined_writes(const SeriesParts& parts) {
  std::vector<std::pair<PartWrite, size_t>> all;
  for (size_t i = 0; i < parts.size(); ++i)
    for (const PartWrite& w : parts[i]->info().part->writes) all.emplace_back(w, i);
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<JoinedWrite> writes;
  for (const auto& [write, part] : all) {
    if (writes.empty() || !(writes.back().write == write)) writes.push_back({write, {}});
    writes.back().parts.push_back(part);
  }
  return writes;
}

} // namespace bccsplat
