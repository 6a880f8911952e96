// SPDX-License-Identifier: Apache-2.0
// Writes and reads a part's report, field by field behind the number of its version, and adds reports up:
// counts are summed, ranges widened, and what is kept by frame or slab is joined to that of others.
#include "store/part_report.h"

#include <algorithm>
#include <cmath>

#include "base/bytes.h"
#include "base/error.h"

namespace bccsplat {
namespace {

constexpr uint32_t report_version = 5;

void write_range(ByteWriter& out, const Range& r) { out.write(r.low), out.write(r.high); }
Range read_range(ByteReader& in) {
  const auto low = in.read<double>();
  return {low, in.read<double>()};
}

void write_sum(ByteWriter& out, const ErrorSum& e) {
  out.write(e.largest), out.write(e.count);
  e.squares.write(out);
}
ErrorSum read_sum(ByteReader& in) {
  ErrorSum e;
  e.largest = in.read<double>(), e.count = in.read<uint64_t>();
  e.squares = ExactSum::read(in);
  return e;
}

void write_errors(ByteWriter& out, const SampleErrors& e) {
  write_sum(out, e.all), write_sum(out, e.non_air), write_sum(out, e.bare);
  out.write(e.lost), out.write(e.corrected), out.write(e.frame);
  for (const uint64_t v : e.voxel) out.write(v);
  out.write(e.expected), out.write(e.got);
}
SampleErrors read_errors(ByteReader& in) {
  SampleErrors e;
  e.all = read_sum(in), e.non_air = read_sum(in), e.bare = read_sum(in);
  e.lost = in.read<uint64_t>(), e.corrected = in.read<uint64_t>();
  e.frame = in.read<uint64_t>();
  for (uint64_t& v : e.voxel) v = in.read<uint64_t>();
  e.expected = in.read<double>(), e.got = in.read<double>();
  return e;
}

void write_counts(ByteWriter& out, const LayerCounts& counts) {
  for (const uint64_t n : {counts.sites_total, counts.sites_kept, counts.holes, counts.clamped}) out.write(n);
  counts.samples.write(out);
}
LayerCounts read_counts(ByteReader& in) {
  LayerCounts counts;
  for (uint64_t* n : {&counts.sites_total, &counts.sites_kept, &counts.holes, &counts.clamped})
    *n = in.read<uint64_t>();
  counts.samples = SampleHistogram::read(in);
  return counts;
}

uint32_t read_count(ByteReader& in, size_t bytes_each) {
  const auto n = in.read<uint32_t>();
  if (n > in.remaining() / bytes_each) fail(Code::corrupt, "part: ", n, " entries do not fit");
  return n;
}

} // namespace

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
    for (const uint64_t n : {f.source_samples, f.cc_relevant, f.nonfinite}) out.write(n);
    write_counts(out, f), write_counts(out, f.lasting);
    out.write(static_cast<uint32_t>(f.clamped_slabs.size()));
    for (const uint64_t n : f.clamped_slabs) out.write(n);
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
    for (uint64_t* n : {&f.source_samples, &f.cc_relevant, &f.nonfinite}) *n = in.read<uint64_t>();
    static_cast<LayerCounts&>(f) = read_counts(in);
    f.lasting = read_counts(in);
    f.clamped_slabs.resize(read_count(in, 8));
    for (uint64_t& n : f.clamped_slabs) n = in.read<uint64_t>();
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

namespace {

void widen(Range& range, const Range& other) {
  range = {std::min(range.low, other.low), std::max(range.high, other.high)};
}

// Adds a list that begins at `first` of the whole one.
template<class T, class Add>
void add_list(std::vector<T>& all, const std::vector<T>& part, size_t first, const T& none, const Add& add) {
  if (part.empty()) return;
  all.resize(std::max(all.size(), first + part.size()), none);
  for (size_t i = 0; i < part.size(); ++i) add(all[first + i], part[i]);
}

// Adds the errors of a frame to those that other blocks have of it.
void add_frame_errors(PartChannelReport& series, uint32_t frame, const SampleErrors& errors) {
  const auto at = std::lower_bound(series.measured.begin(), series.measured.end(), frame);
  const auto i = at - series.measured.begin();
  if (at == series.measured.end() || *at != frame) {
    series.measured.insert(at, frame);
    series.errors.insert(series.errors.begin() + i, SampleErrors());
  }
  series.errors[static_cast<size_t>(i)].add(errors);
}

void add_channel(PartChannelReport& series, PartChannelReport& next, const PartPlace& place) {
  FitChannelReport &a = series.fit, &b = next.fit;
  if (b.any_finite) {
    if (a.any_finite)
      widen(a.source_range, b.source_range);
    else
      a.source_range = b.source_range;
  }
  a.any_finite = a.any_finite || b.any_finite;
  add_list(a.frames, b.frames, place.frame, no_range, widen);
  const double squares = a.coding_rmse * a.coding_rmse * static_cast<double>(a.sites_total) +
                         b.coding_rmse * b.coding_rmse * static_cast<double>(b.sites_total);
  a.source_samples += b.source_samples, a.cc_relevant += b.cc_relevant, a.nonfinite += b.nonfinite;
  a.add(b), a.lasting.add(b.lasting);
  add_list(a.clamped_slabs, b.clamped_slabs, place.slab, uint64_t{0},
           [](uint64_t& sum, uint64_t more) { sum += more; });
  a.coding_max = std::max(a.coding_max, b.coding_max);
  if (a.sites_total > 0) a.coding_rmse = std::sqrt(squares / static_cast<double>(a.sites_total));
  for (size_t i = 0; i < next.measured.size(); ++i)
    add_frame_errors(series, next.measured[i], next.errors[i]);
}

} // namespace

void add_part_report(PartReport& series, PartReport next, const PartPlace& place) {
  if (series.channels.empty()) {
    series = std::move(next);
    return;
  }
  for (size_t i = 0; i < series.channels.size(); ++i)
    add_channel(series.channels[i], next.channels.at(i), place);
}

} // namespace bccsplat
