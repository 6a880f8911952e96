// Parts of a series: written by several processes, joined by one.
#include <algorithm>
#include <cmath>

#include "api/writer.h"
#include "base/bytes.h"
#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/metadata.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

// Of everything that must be equal for the parts of a series to fit together.
uint32_t checksum_of(VolumeInfo info, uint32_t samples) {
  info.part.reset();
  for (ChannelInfo& c : info.channels) {
    ChannelInfo fixed;
    fixed.name = c.name, fixed.quantity = c.quantity, fixed.unit = c.unit, fixed.type = c.type;
    fixed.scale = c.scale, fixed.offset = c.offset, fixed.air = c.air, fixed.threshold = c.threshold;
    fixed.source_type = c.source_type;
    c = std::move(fixed);
  }
  tidy(info);
  const std::array<uint32_t, 2> sums{crc32_of(write_metadata(info)), samples};
  return crc32_of(std::as_bytes(std::span(sums)));
}

} // namespace

void bccsplat_writer::read_times(const bccsplat_series_part& o) {
  require(o.times, "part.times");
  times.assign(o.times, o.times + fit_options.dims[3]);
  for (size_t i = 0; i < times.size(); ++i)
    if (!std::isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1])))
      fail(Code::invalid_argument, "part.times: time ", times[i], " of frame ", i, " does not rise");
}

void bccsplat_writer::begin_part(const bccsplat_series_part& o) {
  require_zero(o.reserved, "bccsplat_series_part.reserved");
  const uint32_t frames = fit_options.dims[3];
  if (frames == 0) fail(Code::invalid_argument, "a part needs the number of frames of the series in dims[3]");
  if (o.first >= o.end || o.end > frames)
    fail(Code::invalid_argument, "a part of frames ", o.first, " to ", o.end, " (excluded): the series has ",
         frames, ", and a part has at least one");
  if (fit_options.nonfinite == NonFinite::clamp)
    for (size_t c = 0; c < channels.size(); ++c)
      if (!(channels[c].set_mask & BCCSPLAT_CHANNEL_SET_RANGE))
        fail(Code::invalid_argument, "channel ", initial.channels[c].name,
             ": what a part clamps to is the range of the series, which it must be told");
  read_times(o);
  fit_options.lead = lead();
  initial.lattice = Lattice4::fit(fit_options.lattice, fit_options.dims, fit_options.scale,
                                  fit_options.time_scale, fit_options.lead);
  const auto first = static_cast<uint32_t>(o.first), end = static_cast<uint32_t>(o.end);
  const std::vector<uint32_t> measured = measured_frames();
  measuring([&] {
    part = part_of_series(initial.lattice, fit_options, {coefficients, initial.recommended_kernel, measured},
                          first, end);
  });
  if (!part)
    part = part_of_series(initial.lattice, fit_options, {coefficients, initial.recommended_kernel, {}}, first,
                          end);
  if (o.lead > part->fit.first_given)
    fail(Code::invalid_argument, "part.lead ", o.lead, ": only ", part->fit.first_given,
         " frames come before the first one needed");
  part->fit.first_given -= static_cast<uint32_t>(o.lead);
  fit_options.part = part->fit;
  added.assign(channels.size(), part->fit.first_given);
}

// Turns what is finished into a part's info.
void bccsplat_writer::describe_part(const FitReport& result) {
  VolumeInfo& info = container->info();
  PartInfo out;
  out.first = part->fit.first_counted, out.end = part->fit.end_counted;
  out.series = checksum_of(info, series_fingerprint());
  out.writes = std::move(writes);
  PartReport report;
  report.psnr = psnr;
  report.lasting = lasting_slabs(result.lattice, fit_options, result.lattice.dims[3]);
  for (size_t c = 0; c < info.channels.size(); ++c) {
    PartChannelReport& channel = report.channels.emplace_back();
    channel.fit = result.channels[c];
    channel.bound = info.channels[c].residuals.bound;
    for (size_t i = 0; round_trip && i < round_trip->frames().size(); ++i) {
      channel.measured.push_back(round_trip->frames()[i]);
      channel.errors.push_back(round_trip->frame_errors(static_cast<int>(c), i));
    }
    // Nothing is said about frames of other parts.
    info.channels[c].residuals.bound = 0;
    info.channels[c].frames.clear();
  }
  out.statistics = write_part_report(report);
  info.part = std::move(out);
}

namespace {

using Parts = std::vector<std::shared_ptr<const Bcc4Reader>>;

Parts open_parts(uint64_t count, const char* const* paths) {
  std::vector<std::string> names;
  Parts parts;
  for (uint64_t i = 0; i < count; ++i) {
    require(paths[i], "parts[i]");
    names.emplace_back(paths[i]);
    parts.push_back(Bcc4Reader::open(open_file_source(names.back())));
  }
  return order_parts(std::move(parts), names);
}

PartReport add_reports(const Parts& parts) {
  PartReport sum;
  for (const auto& part : parts)
    add_part_report(sum, read_part_report(part->info().part->statistics, part->info().channels.size()));
  return sum;
}

bccsplat_writer_report report_of(const VolumeInfo& info, const PartReport& sum, const Bcc4Report& written) {
  bccsplat_writer_report out{};
  out.frames = info.lattice.dims[3];
  double squares = 0;
  for (size_t c = 0; c < sum.channels.size(); ++c) {
    const FitChannelReport& f = sum.channels[c].fit;
    add_counts(f, info.cc_samples(), info.channels[c].source_type, out);
    squares += f.coding_rmse * f.coding_rmse * static_cast<double>(f.sites_total);
    for (const SampleErrors& e : sum.channels[c].errors) out.corrected += e.corrected;
    out.frames_measured = std::max<uint64_t>(out.frames_measured, sum.channels[c].errors.size());
  }
  if (out.sites_total > 0) out.coding_rmse = std::sqrt(squares / static_cast<double>(out.sites_total));
  add_bytes(info, written, out);
  return out;
}

void join(bccsplat_device* device, const Parts& parts, const char* path, const bccsplat_join_options& options,
          bccsplat_writer_report* report) {
  const PartReport sum = add_reports(parts);
  VolumeInfo info = parts.front()->info();
  info.part.reset();
  for (size_t c = 0; c < info.channels.size(); ++c) {
    ChannelInfo& channel = info.channels[c];
    const PartChannelReport& r = sum.channels.at(c);
    describe(r.fit, channel);
    channel.clamped = 0;
    for (const auto& part : parts) channel.clamped += part->info().channels[c].clamped;
    channel.residuals.frames.clear();
    channel.residuals.bound = r.bound;
    SampleErrors errors;
    for (const SampleErrors& e : r.errors) errors.add(e);
    if (sum.psnr > 0) require_psnr(channel.name, errors, r.fit.source_range, sum.psnr);
  }
  if (info.coefficient_kernel.empty()) {
    std::vector<FitChannelReport> reports;
    for (const PartChannelReport& r : sum.channels) reports.push_back(r.fit);
    info.tail = tail_of_series(sum.lasting, reports);
  }
  Progress progress(progress_callback(options.progress, options.progress_user));
  const Context context = device->context(progress);
  Bcc4Writer writer(create_file_sink(path, options.overwrite != 0), info);
  const std::vector<JoinedWrite> writes = joined_writes(parts);
  uint64_t slabs = 0, done = 0;
  for (const auto& [write, part] : writes) {
    const auto channel = static_cast<int>(write.channel);
    if (write.frame == PartWrite::chunks) {
      writer.copy_slab(write.slab, channel, *parts[part]);
      ++slabs;
    } else {
      writer.copy_residuals(channel, static_cast<uint32_t>(write.frame), *parts[part]);
    }
    progress.report(0.99 * static_cast<double>(++done) / static_cast<double>(writes.size()));
    progress.check();
  }
  const Bcc4Report written = writer.finish(context);
  if (!report) return;
  bccsplat_writer_report out = report_of(writer.info(), sum, written);
  out.slabs_reused = static_cast<uint32_t>(std::min<uint64_t>(slabs, UINT32_MAX));
  write_struct(report, out, "report");
}

} // namespace

extern "C" {

bccsplat_status bccsplat_writer_get_part_frames(const bccsplat_writer* writer, uint64_t* begin,
                                                uint64_t* end) {
  return guard([&] {
    require(writer, "writer"), require(begin, "begin"), require(end, "end");
    const FitOptions& o = writer->fit_options;
    *begin = o.part ? o.part->first_given : 0;
    *end = o.part ? o.part->end_given : o.dims[3];
  });
}

bccsplat_status bccsplat_join_parts(bccsplat_device* device, uint64_t count, const char* const* parts,
                                    const char* path, const bccsplat_join_options* options,
                                    bccsplat_writer_report* report) {
  return guard([&] {
    require(device, "device"), require(path, "path");
    if (count > 0) require(parts, "parts");
    check_output(report, "report");
    const auto o = read_struct(options, "bccsplat_join_options");
    join(device, open_parts(count, parts), path, o, report);
  });
}

} // extern "C"
