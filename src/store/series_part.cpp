#include "store/series_part.h"

#include <algorithm>
#include <cmath>

#include "base/bytes.h"
#include "base/error.h"
#include "fit/ends.h"
#include "fit/lowpass.h"

namespace bccsplat {
namespace {

constexpr uint32_t report_version = 2;

void include(LayerSpan& all, const LayerSpan& more) {
  if (more.begin >= more.end) return;
  all = all.begin < all.end ? LayerSpan{std::min(all.begin, more.begin), std::max(all.end, more.end)} : more;
}

LayerSpan whole_slabs(const LayerSpan& span, int32_t slab_layers, int32_t layers) {
  if (span.begin >= span.end) return {};
  return {span.begin / slab_layers * slab_layers,
          std::min(layers, (span.end + slab_layers - 1) / slab_layers * slab_layers)};
}

// Frames on either side that a layer is resampled from.
int frame_reach(const Lattice4& lattice, const FitOptions& options, double widening) {
  return filter_reach(options.filter, widening) + 1 + (options.lowpass ? lowpass_time_reach(lattice) : 0);
}

// Frames that layers are resampled from; frames beyond the ends hang on those next to them.
std::array<int64_t, 2> frames_of(const LayerSpan& layers, const Lattice4& lattice,
                                 const FitOptions& options) {
  const double widening = std::max(1.0, lattice.time_step / lattice.layer_distance());
  const int64_t frames = options.dims[3];
  const int reach = frame_reach(lattice, options, widening);
  int64_t first = static_cast<int64_t>(std::floor(lattice.layer_frame(layers.begin))) - reach;
  int64_t end = static_cast<int64_t>(std::ceil(lattice.layer_frame(layers.end - 1))) + reach + 1;
  if (end > frames)
    first = std::min(first, frames - 2 - reach - static_cast<int64_t>(std::ceil(lattice.time_step)));
  if (lattice.lead > 0) {
    const int64_t predicting =
        EndFrames(widening).used() + (options.lowpass ? lowpass_time_reach(lattice) : 0);
    if (end > frames) first = std::min(first, frames - predicting);
    if (first < 0) end = std::max(end, predicting);
  }
  return {std::clamp<int64_t>(first, 0, frames), std::clamp<int64_t>(end, 0, frames)};
}

void write_range(ByteWriter& out, const Range& r) { out.write(r.low), out.write(r.high); }
Range read_range(ByteReader& in) {
  const auto low = in.read<double>();
  return {low, in.read<double>()};
}

void write_sum(ByteWriter& out, const ErrorSum& e) {
  out.write(e.largest), out.write(e.squares), out.write(e.count);
}
ErrorSum read_sum(ByteReader& in) {
  ErrorSum e;
  e.largest = in.read<double>(), e.squares = in.read<double>(), e.count = in.read<uint64_t>();
  return e;
}

void write_errors(ByteWriter& out, const SampleErrors& e) {
  write_sum(out, e.all), write_sum(out, e.non_air);
  out.write(e.lost), out.write(e.corrected), out.write(e.uncorrected), out.write(e.frame);
  for (const uint64_t v : e.voxel) out.write(v);
  out.write(e.expected), out.write(e.got);
}
SampleErrors read_errors(ByteReader& in) {
  SampleErrors e;
  e.all = read_sum(in), e.non_air = read_sum(in);
  e.lost = in.read<uint64_t>(), e.corrected = in.read<uint64_t>();
  e.uncorrected = in.read<double>(), e.frame = in.read<uint64_t>();
  for (uint64_t& v : e.voxel) v = in.read<uint64_t>();
  e.expected = in.read<double>(), e.got = in.read<double>();
  return e;
}

uint32_t read_count(ByteReader& in, size_t bytes_each) {
  const auto n = in.read<uint32_t>();
  if (n > in.remaining() / bytes_each) fail(Code::corrupt, "part: ", n, " entries do not fit");
  return n;
}

} // namespace

SeriesPart part_of_series(const Lattice4& lattice, const FitOptions& options, const LayerUse& use,
                          uint32_t first, uint32_t end) {
  const uint32_t frames = options.dims[3];
  if (lattice.is_static()) fail(Code::invalid_argument, "a part: the series has one frame only");
  if (first >= end || end > frames)
    fail(Code::invalid_argument, "a part of frames ", first, " to ", end, " (excluded): the series has ",
         frames, ", and a part has at least one");
  const int32_t layers = lattice.layers(), slab = options.slab_layers;
  // The first slab at or after a frame.
  const auto slab_at = [&](uint32_t frame) {
    const int32_t slabs = (layers + slab - 1) / slab;
    if (frame == 0) return 0; // layers before it as well
    if (frame == frames) return slabs;
    auto s = static_cast<int32_t>(std::ceil(frame / (lattice.time_step * slab)));
    while (s > 0 && lattice.layer_frame((s - 1) * slab) >= frame) --s;
    while (s < slabs && lattice.layer_frame(s * slab) < frame) ++s;
    return s;
  };
  SeriesPart part;
  part.first_slab = slab_at(first), part.end_slab = slab_at(end);
  const LayerSpan own{std::min(part.first_slab * slab, layers), std::min(part.end_slab * slab, layers)};
  LayerSpan stored = own;
  for (const uint32_t frame : use.measured)
    if (frame >= first && frame < end)
      include(stored, layers_to_measure(lattice, use.kernel, use.coefficients, frame));
  stored = whole_slabs(stored, slab, layers);
  LayerSpan samples = stored;
  if (use.coefficients && stored.begin < stored.end) {
    const int32_t reach = prefilter_layers(lattice, use.kernel) + 1;
    samples =
        whole_slabs({std::max(0, stored.begin - reach), std::min(layers, stored.end + reach)}, slab, layers);
  }
  part.first_layer = stored.begin, part.end_layer = stored.end;
  part.fit.first_counted = part.fit.first_given = first, part.fit.end_counted = part.fit.end_given = end;
  if (samples.begin < samples.end) {
    const auto [from, to] = frames_of(samples, lattice, options);
    part.fit.first_given = std::min(first, static_cast<uint32_t>(from));
    part.fit.end_given = std::max(end, static_cast<uint32_t>(to));
  }
  part.fit.first_layer = samples.begin, part.fit.end_layer = samples.end;
  part.fit.first_own = own.begin, part.fit.end_own = own.end;
  return part;
}

int32_t lasting_slabs(const Lattice4& lattice, const FitOptions& options, uint32_t frames) {
  if (lattice.is_static()) return 0;
  const double widening = std::max(1.0, lattice.time_step / lattice.layer_distance());
  // With fewer, what stands before the first frame changes as well.
  if (lattice.lead > 0 &&
      frames < EndFrames(widening).used() + (options.lowpass ? lowpass_time_reach(lattice) : 0))
    return 0;
  const double last = frames - 1.0 - frame_reach(lattice, options, widening);
  int32_t slabs = 0;
  while (lattice.layer_frame((slabs + 1) * options.slab_layers - 1) <= last) ++slabs;
  return slabs;
}

FitPart rest_of_series(const Lattice4& lattice, const FitOptions& options, uint32_t done) {
  const uint32_t frames = options.dims[3];
  FitPart part;
  part.first_counted = done, part.end_counted = part.end_given = frames;
  part.first_layer = part.first_own = lasting_slabs(lattice, options, done) * options.slab_layers;
  part.end_layer = part.end_own = lattice.layers();
  if (part.first_layer > 0)
    part.first_given =
        static_cast<uint32_t>(frames_of({part.first_layer, part.end_layer}, lattice, options)[0]);
  part.first_given = std::min(part.first_given, done);
  return part;
}

std::optional<TailInfo> tail_of_series(int32_t lasting, std::span<const FitChannelReport> channels) {
  TailInfo tail{lasting, {}};
  uint64_t all = 0;
  for (const FitChannelReport& c : channels) {
    const size_t n = std::min(static_cast<size_t>(lasting), c.clamped_slabs.size());
    uint64_t sum = 0;
    for (const uint64_t slab : std::span(c.clamped_slabs).first(n)) sum += slab;
    tail.clamped.push_back(sum);
    all += c.clamped;
  }
  if (all == 0) return std::nullopt;
  return tail;
}

std::vector<std::byte> write_part_report(const PartReport& report) {
  ByteWriter out;
  out.write(report_version);
  out.write(report.psnr), out.write(report.lasting);
  for (const PartChannelReport& c : report.channels) {
    const FitChannelReport& f = c.fit;
    write_range(out, f.source_range);
    out.write(static_cast<uint32_t>(f.any_finite));
    out.write(static_cast<uint32_t>(f.frames.size()));
    for (const Range& r : f.frames) write_range(out, r);
    for (const uint64_t n :
         {f.source_samples, f.cc_relevant, f.nonfinite, f.sites_total, f.sites_kept, f.holes, f.clamped})
      out.write(n);
    out.write(static_cast<uint32_t>(f.clamped_slabs.size()));
    for (const uint64_t n : f.clamped_slabs) out.write(n);
    f.samples.write(out);
    out.write(f.coding_max), out.write(f.coding_rmse), out.write(c.bound);
    out.write(static_cast<uint32_t>(c.measured.size()));
    for (size_t i = 0; i < c.measured.size(); ++i) {
      out.write(c.measured[i]);
      write_errors(out, c.errors[i]);
    }
  }
  return out.release();
}

PartReport read_part_report(std::span<const std::byte> bytes, size_t channels) {
  ByteReader in(bytes, "part");
  if (in.read<uint32_t>() != report_version)
    fail(Code::unsupported_version,
         "a part written by another version of bccsplat; write all parts with one");
  PartReport report;
  report.psnr = in.read<double>(), report.lasting = in.read<int32_t>();
  report.channels.resize(channels);
  for (PartChannelReport& c : report.channels) {
    FitChannelReport& f = c.fit;
    f.source_range = read_range(in);
    f.any_finite = in.read<uint32_t>() != 0;
    f.frames.resize(read_count(in, 16));
    for (Range& r : f.frames) r = read_range(in);
    for (uint64_t* n : {&f.source_samples, &f.cc_relevant, &f.nonfinite, &f.sites_total, &f.sites_kept,
                        &f.holes, &f.clamped})
      *n = in.read<uint64_t>();
    f.clamped_slabs.resize(read_count(in, 8));
    for (uint64_t& n : f.clamped_slabs) n = in.read<uint64_t>();
    f.samples = SampleHistogram::read(in);
    f.coding_max = in.read<double>(), f.coding_rmse = in.read<double>(), c.bound = in.read<double>();
    c.measured.resize(read_count(in, 4));
    for (uint32_t& frame : c.measured) {
      frame = in.read<uint32_t>();
      c.errors.push_back(read_errors(in));
    }
  }
  in.expect_end();
  return report;
}

void add_part_report(PartReport& series, PartReport next) {
  if (series.channels.empty()) {
    series = std::move(next);
    return;
  }
  for (size_t i = 0; i < series.channels.size(); ++i) {
    PartChannelReport &s = series.channels[i], &n = next.channels.at(i);
    FitChannelReport &a = s.fit, &b = n.fit;
    if (b.any_finite)
      a.source_range = a.any_finite ? Range{std::min(a.source_range.low, b.source_range.low),
                                            std::max(a.source_range.high, b.source_range.high)}
                                    : b.source_range;
    a.any_finite = a.any_finite || b.any_finite;
    a.frames.insert(a.frames.end(), b.frames.begin(), b.frames.end());
    const double squares = a.coding_rmse * a.coding_rmse * static_cast<double>(a.sites_total) +
                           b.coding_rmse * b.coding_rmse * static_cast<double>(b.sites_total);
    a.source_samples += b.source_samples, a.cc_relevant += b.cc_relevant, a.nonfinite += b.nonfinite;
    a.sites_total += b.sites_total, a.sites_kept += b.sites_kept;
    a.holes += b.holes, a.clamped += b.clamped;
    a.clamped_slabs.insert(a.clamped_slabs.end(), b.clamped_slabs.begin(), b.clamped_slabs.end());
    a.samples.merge(b.samples);
    a.coding_max = std::max(a.coding_max, b.coding_max);
    if (a.sites_total > 0) a.coding_rmse = std::sqrt(squares / static_cast<double>(a.sites_total));
    s.measured.insert(s.measured.end(), n.measured.begin(), n.measured.end());
    s.errors.insert(s.errors.end(), n.errors.begin(), n.errors.end());
  }
}

} // namespace bccsplat
