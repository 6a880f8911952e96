// SPDX-License-Identifier: Apache-2.0
// Collects the entries of chunks in pages, and sums them up for the metadata.
#include "formats/bcc4/write/writer_index.h"

#include <algorithm>
#include <utility>

#include "base/error.h"

namespace bccsplat {

WriterIndex::WriterIndex(const VolumeInfo& info, AppendBlock append)
    : append_(std::move(append)), levels_(info.level_count()) {
  for (int c = 0; c < static_cast<int>(info.channels.size()); ++c)
    for (int l = 0; l < levels_; ++l) streams_.emplace_back(ChannelLevel{c, l}, info.channels.at(c));
}

void WriterIndex::check_slab(int32_t slab, const ChannelLevel& at, const VolumeInfo& info) const {
  const auto bad = [&](const auto&... why) {
    fail(Code::invalid_argument, "writer: slab ", slab, " of channel ", at.channel, ", level ", at.level,
         ": ", why...);
  };
  if (at.channel < 0 || static_cast<size_t>(at.channel) >= info.channels.size()) bad("no such channel");
  if (at.level < 0 || at.level >= levels_) bad("no such level");
  const Stream& s = stream(at);
  const int32_t slab_layers = info.level(at.level).slab_layers;
  if (slab < 0 || slab >= INT32_MAX / slab_layers) bad("no such slab");
  const bool turns = info.lattice.periodic && !s.turned && slab < s.first_slab;
  if (slab <= s.last_slab && !turns) bad("slabs must rise");
  if (s.turned && slab >= s.first_slab) bad("it is there already");
  if (turns) return; // check_ends sees whether the last slab is full
  if (s.last_slab >= 0 && s.last_slab_layers < slab_layers) bad("the one before was not full");
}

PageRef WriterIndex::append_page(const Stream& s, size_t first) {
  const auto entries = std::span(s.pending).subspan(first);
  PageRef ref = describe_page(s.at, entries);
  ref.block = append_(write_page(entries));
  return ref;
}

void WriterIndex::drop_shown(Stream& s) {
  for (const PageRef& page : s.shown) replaced_bytes_ += page.block.padded();
  s.shown.clear();
}

// Pages rise: what follows goes before all that is there.
void WriterIndex::turn(Stream& s) {
  if (!s.pending.empty()) s.pages.push_back(append_page(s, 0)), s.pending.clear();
  s.turned = true;
  s.turned_pages = s.pages.size();
}

void WriterIndex::enter_chunk(const ChannelLevel& at, const Bcc4Chunk& entry) {
  Stream& s = stream(at);
  if (entry.slab < s.first_slab && !s.turned) turn(s);
  s.kept += entry.kept, s.holes += entry.holes;
  s.min_code = std::min(s.min_code, entry.min_code), s.max_code = std::max(s.max_code, entry.max_code);
  ++chunks_, runs_bytes_ += entry.runs_bytes, values_bytes_ += entry.values_bytes;
  s.pending.push_back(entry);
  if (s.pending.size() < page_entries) return;
  drop_shown(s);
  s.pages.push_back(append_page(s, 0));
  s.pending.clear();
}

void WriterIndex::enter_slab(int32_t slab, const ChannelLevel& at, int32_t layers, uint64_t clamped) {
  Stream& s = stream(at);
  s.clamped += clamped;
  if (s.first_slab < 0) s.first_slab = slab;
  if (slab < s.first_slab && !s.turned) turn(s);
  s.last_slab = slab;
  s.last_slab_layers = layers;
  if (slab >= s.end_slab) s.end_slab = slab, s.end_slab_layers = layers;
}

void WriterIndex::check_ends(const VolumeInfo& info) const {
  for (const Stream& s : streams_) {
    const StoredLattice& level = info.level(s.at.level);
    if (s.end_slab >= 0 && s.end_slab_layers != level.layers_of(s.end_slab))
      fail(Code::wrong_state, "writer: channel ", s.at.channel, ", level ", s.at.level, " ends after ",
           s.end_slab_layers, " layers of slab ", s.end_slab, ", the lattice has ", level.lattice.layers(),
           " layers");
  }
}

std::vector<PageRef> WriterIndex::finish_pages() {
  std::vector<PageRef> pages;
  for (Stream& s : streams_) {
    if (s.shown.size() == 1 && s.shown[0].entries == s.pending.size()) {
      s.pages.push_back(s.shown[0]);
    } else if (!s.pending.empty()) {
      drop_shown(s);
      s.pages.push_back(append_page(s, 0));
    }
    if (s.turned) std::rotate(s.pages.begin(), s.pages.begin() + s.turned_pages, s.pages.end());
    pages.insert(pages.end(), s.pages.begin(), s.pages.end());
  }
  return pages;
}

std::vector<PageRef> WriterIndex::show_pages() {
  std::vector<PageRef> pages;
  for (Stream& s : streams_) {
    size_t first = 0; // of those on no page
    for (const PageRef& page : s.shown) first += page.entries;
    if (first < s.pending.size()) {
      while (!s.shown.empty() && s.shown.back().entries <= s.pending.size() - first) {
        first -= s.shown.back().entries;
        replaced_bytes_ += s.shown.back().block.padded();
        s.shown.pop_back();
      }
      s.shown.push_back(append_page(s, first));
    }
    pages.insert(pages.end(), s.pages.begin(), s.pages.end());
    pages.insert(pages.end(), s.shown.begin(), s.shown.end());
  }
  return pages;
}

int32_t WriterIndex::common_slabs(const VolumeInfo& info) const {
  const int32_t last = streams_.front().last_slab;
  for (const Stream& s : streams_)
    if (s.last_slab != last || s.last_slab_layers != info.level(s.at.level).slab_layers) return 0;
  return last + 1;
}

template<class Counts> void WriterIndex::add_counts(const Stream& s, Counts& out) {
  out.sites_kept = s.kept, out.holes = s.holes, out.clamped += s.clamped;
  out.kept_range = s.kept ? Range{s.coder.value(s.min_code), s.coder.value(s.max_code)} : Range{};
}

void WriterIndex::describe(VolumeInfo& info, Bcc4Report& report) const {
  for (const Stream& s : streams_) {
    const size_t c = s.at.channel;
    if (s.at.level > 0) {
      add_counts(s, info.levels[static_cast<size_t>(s.at.level) - 1].channels[c]);
      continue;
    }
    add_counts(s, info.channels[c]);
    report.sites_total += info.lattice.sites();
    report.sites_kept += s.kept, report.holes += s.holes, report.clamped += s.clamped;
  }
}

} // namespace bccsplat
