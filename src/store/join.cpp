// SPDX-License-Identifier: Apache-2.0
// Adds up what parts counted, and copies their chunks, masks and corrections in the order of one writer.
#include "store/join.h"

#include <algorithm>

#include "formats/bcc4/read/reader.h"
#include "store/channel_info.h"
#include "store/compared_levels.h"
#include "store/part_report.h"
#include "store/series_part.h"

namespace bccsplat {
namespace {

// Returns the first of the slabs that a part has.
size_t first_slab_of(const PartInfo& part) {
  int32_t first = INT32_MAX;
  for (const PartWrite& w : part.writes)
    if (w.frame == PartWrite::chunks) first = std::min(first, w.slab);
  return first == INT32_MAX ? 0 : first;
}

// Blocks fill a frame from its own samples, without a look at others in time: of a frame that has no value,
// some samples are missing, and not clamped.
void require_not_missing(const SeriesParts& parts, size_t channel, size_t frame) {
  for (const auto& part : parts) {
    const ChannelInfo& c = part->info().channels.at(channel);
    if (frame < c.masks.size() && c.masks[frame].stored > 0)
      fail(Code::nonfinite_value, "channel '", c.name, "', frame ", frame,
           ": none of its values is finite in ",
           "any block, and blocks do not fill a frame from those beside it; leave it out of the series");
  }
}

PartReport add_reports(const SeriesParts& parts) {
  PartReport sum;
  for (const auto& part : parts) {
    const VolumeInfo& info = part->info();
    add_part_report(sum, read_part_report(info.part->statistics, info.channels.size() * info.level_count()),
                    {info.part->block.first_frame(), first_slab_of(*info.part)});
  }
  for (size_t c = 0; c < sum.channels.size(); ++c)
    for (size_t f = 0; f < sum.channels[c].fit.frames.size(); ++f)
      if (Range& r = sum.channels[c].fit.frames[f]; r == no_range) {
        require_not_missing(parts, c, f);
        r = {};
      }
  return sum;
}

std::vector<const Bcc4Reader*> files_of(const std::vector<size_t>& numbers, const SeriesParts& parts) {
  std::vector<const Bcc4Reader*> files;
  for (const size_t i : numbers) files.push_back(parts[i].get());
  return files;
}

// Returns what the whole series says about itself; fits: what its channels counted. Throws bound_not_met.
VolumeInfo joined_info(const SeriesParts& parts, const PartReport& sum,
                       std::span<const FitChannelReport> fits) {
  VolumeInfo info = parts.front()->info();
  info.part.reset();
  for (size_t c = 0; c < info.channels.size(); ++c) {
    ChannelInfo& channel = info.channels[c];
    const PartChannelReport& r = sum.channels.at(c);
    describe_channel(fits[c], channel);
    channel.clamped = 0;
    for (const auto& part : parts) channel.clamped += part->info().channels[c].clamped;
    channel.residuals.frames.clear(), channel.residuals.tables.clear();
    channel.masks.clear();
    channel.residuals.bound = r.bound;
    SampleErrors errors;
    for (const SampleErrors& e : r.errors) errors.add(e);
    if (r.bound > 0)
      add_measured(errors, fits[c].source_range, c, r.errors.size(), info.errors);
    else if (!info.levels.empty() && !r.errors.empty())
      add_measured_level(errors, fits[c].source_range, c, 0, r.errors.size(), info.errors);
    if (sum.psnr > 0) require_psnr(channel.name, errors, fits[c].source_range, sum.psnr);
  }
  for (size_t l = 0; l < info.levels.size(); ++l)
    for (size_t c = 0; c < info.channels.size(); ++c) {
      LevelChannel& channel = info.levels[l].channels[c];
      channel = {};
      for (const auto& part : parts) channel.clamped += part->info().levels[l].channels[c].clamped;
      const PartChannelReport& r = sum.channels.at((l + 1) * info.channels.size() + c);
      SampleErrors errors;
      for (const SampleErrors& e : r.errors) errors.add(e);
      if (!r.errors.empty())
        add_measured_level(errors, fits[c].source_range, c, l + 1, r.errors.size(), info.errors);
    }
  sort_errors(info.errors);
  describe_tail(sum.lasting, fits, info);
  return info;
}

} // namespace

SeriesParts open_parts(const std::vector<std::string>& paths) {
  constexpr size_t open_at_once = 16; // opening one again costs little beside the chunks that are read
  return open_parts(open_file_sources(paths, open_at_once));
}

WriteReport join_parts(const SeriesParts& parts, const std::string& path, bool overwrite, bool with_levels,
                       const Context& context) {
  return join_parts(parts, create_file_sink(path, overwrite), with_levels, context);
}

WriteReport join_parts(const SeriesParts& parts, std::unique_ptr<ByteSink> sink, bool with_levels,
                       const Context& context) {
  PartReport sum = add_reports(parts);
  std::vector<FitChannelReport> fits;
  for (PartChannelReport& channel : sum.channels) fits.push_back(std::move(channel.fit));
  VolumeInfo joined = joined_info(parts, sum, fits);
  if (with_levels) compare_levels(parts, fits, joined, context);
  Bcc4Writer writer(std::move(sink), joined);
  const std::vector<JoinedWrite> writes = joined_writes(parts);
  WriteReport report;
  uint64_t done = 0;
  for (const auto& [write, from] : writes) {
    const int channel = write.channel;
    if (write.frame == PartWrite::chunks) {
      writer.copy_slab(write.slab, {channel, write.level}, files_of(from, parts));
      ++report.slabs_reused;
    } else if (write.slab == PartWrite::mask) {
      writer.copy_mask(channel, static_cast<uint32_t>(write.frame), files_of(from, parts), context);
    } else {
      writer.copy_residuals(channel, static_cast<uint32_t>(write.frame), files_of(from, parts), context);
    }
    context.progress.report(0.99 * static_cast<double>(++done) / static_cast<double>(writes.size()));
    context.progress.check();
  }
  const Bcc4Report written = writer.finish(context);
  const VolumeInfo& info = writer.info();
  report.frames = info.lattice.dims[3];
  for (size_t c = 0; c < info.channels.size(); ++c) {
    report.add(fits[c], info.cc_samples(), info.channels[c].source_type);
    for (const SampleErrors& e : sum.channels[c].errors) report.corrected += e.corrected;
    report.frames_measured = std::max<uint64_t>(report.frames_measured, sum.channels[c].errors.size());
  }
  report.take_outside(info.lattice, 0, info.lattice.layers(), info.channels.size());
  report.coding_rmse = coding_rmse(std::span(fits).first(info.channels.size()));
  report.set_file(written);
  return report;
}

} // namespace bccsplat
