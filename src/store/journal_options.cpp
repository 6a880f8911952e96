// SPDX-License-Identifier: Apache-2.0
#include "store/journal_options.h"

#include <optional>

#include "base/text.h"
#include "formats/bcc4/coding/deflate.h"
#include "store/fingerprint.h"

namespace bccsplat {
namespace {

template<class List> std::string list_of(const List& values) {
  std::string out;
  for (const auto& v : values) out += concat(out.empty() ? "" : " ", v);
  return out;
}

const char* name_of(NonFinite rule) {
  return rule == NonFinite::error ? "refused" : rule == NonFinite::hole ? "holes" : "clamped";
}

// Journals take texts of limited length, and lists of coordinates are long: these count by their checksum.
void shorten(std::string& value) {
  constexpr size_t longest = 1000;
  if (value.size() > longest)
    value = concat(value.size(), " characters, checksum ", crc32_of(std::as_bytes(std::span(value))));
}

// Names an option that is not given "none".
std::string or_none(std::string text) { return text.empty() ? "none" : std::move(text); }

template<class Enum> std::string number_of(const std::optional<Enum>& type) {
  return type ? concat(static_cast<int>(*type)) : std::string(); // else the first box tells
}

void add_channel(const ChannelSettings& channel, const std::string& of, JournalOptions& out) {
  out.emplace_back(of + ", name", channel.name);
  out.emplace_back(of + ", unit", or_none(channel.unit));
  out.emplace_back(of + ", source_type", number_of(channel.source_type));
  out.emplace_back(of + ", value_type", number_of(channel.value_type));
  out.emplace_back(of + ", air", concat(channel.air));
  out.emplace_back(of + ", air_threshold", concat(channel.threshold));
  out.emplace_back(of + ", range",
                   channel.range ? concat(channel.range->low, " ", channel.range->high) : "none");
  out.emplace_back(of + ", value_step", concat(channel.value_step));
}

std::string part_text(const SeriesBlock& block) {
  std::string frames = concat(block.first_frame(), " to ", block.end_frame());
  if (block.all_space()) return frames;
  return concat(frames, ", samples ", list_of(block.begin), " to ", list_of(block.end));
}

void add_part(const WriterSettings& s, JournalOptions& out) {
  out.emplace_back("part", s.part ? part_text(s.part->block) : "none");
  if (!s.part) return;
  out.emplace_back("part, lead", concat(s.part->early_frames));
  out.emplace_back("part, checksum of the times", concat(crc32_of(std::as_bytes(std::span(s.part->times)))));
  out.emplace_back("psnr", concat(s.psnr)); // a series without parts is checked at its end
}

} // namespace

const char* name_of(LatticeKind kind) {
  return kind == LatticeKind::d4star ? "D4*" : kind == LatticeKind::bcc ? "BCC" : "CC";
}

JournalOptions journal_options(const WriterSettings& s, const std::string& kernel, int32_t lead,
                               const Int3& planes) {
  JournalOptions out{{"dims", list_of(s.dims)},
                     {"lattice", name_of(s.lattice)},
                     {"lattice distances", list_of(s.scales)},
                     {"lowpass", concat(static_cast<int>(s.lowpass))},
                     {"nonfinite", name_of(s.nonfinite)},
                     {"ends", s.ends == Ends::periodic ? "periodic" : concat(lead, " layers predicted")},
                     {"faces", concat(list_of(planes), " planes predicted")},
                     {"store", s.wavelets ? "wavelets" : "samples"},
                     {"levels", concat(s.levels)},
                     {"abs_error", bounds_text(s)}, // sets the kernel, too
                     {"recommended_kernel", or_none(kernel)},
                     {"live", concat(s.live_slabs)},
                     {"spatial_unit", or_none(s.spatial_unit)},
                     {"time_unit", or_none(s.time_unit)}};
  std::string axes, affine;
  for (size_t a = 0; a < 3; ++a)
    if (s.turning[a]) axes += "xyz"[a];
  out.emplace_back("periodic_axes", or_none(axes));
  for (size_t a = 0; a < 3; ++a) affine += concat(list_of(s.affine.linear[a]), " ", s.affine.offset[a], " ");
  out.emplace_back("affine", affine);
  for (size_t a = 0; a < 3; ++a)
    if (!s.axes[a].coordinates.empty())
      out.emplace_back(concat("coordinates along ", "xyz"[a]), list_of(s.axes[a].coordinates));
  add_part(s, out);
  out.emplace_back("channels", concat(s.channels.size()));
  for (size_t c = 0; c < s.channels.size(); ++c) add_channel(s.channels[c], concat("channel ", c), out);
  for (auto& option : out) shorten(option.second);
  return out;
}

} // namespace bccsplat
