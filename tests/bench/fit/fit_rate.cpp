// SPDX-License-Identifier: Apache-2.0
// Takes a series through fit, container and round trip, at several scales and steps, and beside it every
// second frame with those between interpolated; makes tables and plots of error against bytes.
#include "tests/bench/fit/fit_rate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/files.h"
#include "base/text.h"
#include "formats/bcc4/write/writer.h"
#include "store/round_trip.h"

namespace bccsplat::bench {
namespace {

Range range_of(const FitSource& s) {
  Range r{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (uint32_t t = 0; t < s.dims[3]; ++t)
    for (const float v : s.frame(t))
      r = {std::min(r.low, static_cast<double>(v)), std::max(r.high, static_cast<double>(v))};
  return r;
}

Quantiser quantiser_for(const FitSource& s, double step) {
  if (step == 0) return quantiser_of_source(s.type, 0);
  const Range r = range_of(s);
  const double room = (r.high - r.low) / 8;
  const double below = std::ceil((std::max(0.0, -r.low) + room) / step);
  const double codes = below + std::ceil((std::max(0.0, r.high) + room) / step) + 1;
  return {codes <= 256 ? ValueType::u8 : ValueType::u16, step, -below * step, 0};
}

double psnr_of(double squares, double count, double peak) {
  return 20 * std::log10(peak / std::sqrt(squares / count));
}

std::string whole_kib(uint64_t bytes) { return number(static_cast<double>(bytes) / 1024, 1); }

// PSNR of a curve at some number of bytes, straight between its points in log bytes; NaN outside.
double at_bytes(const std::vector<RatePoint>& curve, uint64_t bytes) {
  for (size_t i = 0; i + 1 < curve.size(); ++i) {
    const RatePoint &a = curve[i], &b = curve[i + 1];
    if ((a.bytes > bytes) == (b.bytes > bytes)) continue;
    const auto log_of = [](uint64_t n) { return std::log(static_cast<double>(n)); };
    const double part = (log_of(bytes) - log_of(a.bytes)) / (log_of(b.bytes) - log_of(a.bytes));
    return a.psnr + part * (b.psnr - a.psnr);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

} // namespace

RatePoint through_lattice(const FitSource& source, LatticeKind kind, double scale, double time_scale,
                          double step, double bound) {
  Tasks tasks;
  MemoryBudget memory;
  Progress progress;
  const Context context{tasks, memory, progress};
  FitOptions options;
  options.lattice = kind, options.scales = {scale, scale, scale, time_scale};
  options.dims = source.dims;
  options.channels[0].quantiser = quantiser_for(source, step);

  VolumeInfo info;
  info.lattice = Lattice4::fit(kind, source.dims, options.scales);
  info.scale = scale, info.time_scale = time_scale;
  info.channels.resize(1);
  ChannelInfo& channel = info.channels[0];
  const Quantiser& q = options.channels[0].quantiser;
  channel.type = q.type, channel.scale = q.scale, channel.offset = q.offset,
  channel.source_type = source.type;
  if (bound > 0) channel.residuals.step = bccsplat::RoundTrip::step(bound), channel.residuals.bound = bound;
  std::vector<std::byte> bytes;
  Bcc4Writer writer(create_memory_sink(bytes), info);
  std::vector<uint32_t> frames;
  for (uint32_t t = 0; t < source.dims[3]; ++t) frames.push_back(t);
  bccsplat::RoundTrip back(
      info.lattice, {{"value", 0, 0, bound}}, "default", frames,
      [&](int c, uint32_t frame, const FrameResiduals& r) { writer.write_residuals(c, frame, r, context); },
      context);
  Fit fit(
      options,
      [&](int32_t slab, int c, std::span<const BrickLayer> layers) {
        writer.write_slab(slab, c, layers, context);
        back.add_layers(c, slab * info.slab_layers, layers);
      },
      context);
  for (uint32_t t = 0; t < source.dims[3]; ++t) {
    const FrameBox box = source.box(t);
    back.add_frame(0, t, {&box, 1});
    fit.add_frame(0, {&box, 1});
  }
  const FitReport report = fit.finish();
  const FitChannelReport& c = report.channels[0];
  RatePoint point;
  point.bytes = writer.finish(context).bytes.file;
  const SampleErrors& errors = back.errors(0);
  point.psnr = errors.all.psnr(c.source_range.high - c.source_range.low);
  point.largest = errors.all.largest;
  point.kept_percent =
      100 * static_cast<double>(c.sites_kept) / static_cast<double>(std::max<uint64_t>(c.cc_relevant, 1));
  return point;
}

RatePoint through_half_the_frames(const FitSource& source, double step, bool cubic) {
  FitSource half = source;
  half.dims[3] = (source.dims[3] + 1) / 2;
  half.bytes.clear();
  for (uint32_t t = 0; t < source.dims[3]; t += 2) {
    const auto first = source.bytes.begin() + (t * source.frame_bytes());
    half.bytes.insert(half.bytes.end(), first, first + source.frame_bytes());
  }
  RatePoint point = through_lattice(half, LatticeKind::cc, 1, 1, step, 0);

  // What a reader gets: the stored samples themselves, and blends of them.
  std::vector<std::vector<float>> stored;
  for (uint32_t t = 0; t < half.dims[3]; ++t) {
    stored.push_back(half.frame(t));
    if (step > 0)
      for (float& v : stored.back()) v = static_cast<float>(std::floor(v / step + 0.5) * step);
  }
  const Range range = range_of(source);
  double squares = 0;
  point.largest = 0;
  const auto at = [&](int64_t t) -> const std::vector<float>& {
    return stored[std::clamp<int64_t>(t, 0, half.dims[3] - 1)];
  };
  for (uint32_t t = 0; t < source.dims[3]; ++t) {
    const std::vector<float> truth = source.frame(t);
    const int64_t k = t / 2;
    for (size_t i = 0; i < truth.size(); ++i) {
      double v = at(k)[i];
      if (t % 2 == 1)
        v = cubic ? (9 * (v + at(k + 1)[i]) - (static_cast<double>(at(k - 1)[i]) + at(k + 2)[i])) / 16
                  : 0.5 * (v + at(k + 1)[i]);
      const double d = std::clamp(v, range.low, range.high) - truth[i];
      squares += d * d;
      point.largest = std::max(point.largest, std::fabs(d));
    }
  }
  point.psnr =
      psnr_of(squares, static_cast<double>(source.frame_samples()) * source.dims[3], range.high - range.low);
  return point;
}

void report_rates(const FitSource& source, const Report& report) {
  const Range range = range_of(source);
  const double peak = range.high - range.low;
  std::vector<double> steps;
  for (const double part : {1.0 / 4096, 1.0 / 1024, 1.0 / 256, 1.0 / 64, 1.0 / 24})
    steps.push_back(part * peak);
  if (report.quick) steps = {steps[1], steps[3]};

  struct Curve {
    std::string name;
    std::vector<RatePoint> points;
  };
  std::vector<Curve> curves;
  for (const bool cubic : {false, true}) {
    Curve& c = curves.emplace_back(Curve{cubic ? "every 2nd frame, cubic" : "every 2nd frame, linear", {}});
    for (const double step : steps) c.points.push_back(through_half_the_frames(source, step, cubic));
  }
  curves.push_back({"CC, all frames", {}});
  for (const double step : steps)
    curves.back().points.push_back(through_lattice(source, LatticeKind::cc, 1, 1, step, 0));
  for (const double scale : {1.0, 1.3, 1.6, 2.0}) {
    if (report.quick && scale != 1 && scale != 1.6) continue;
    Curve& c = curves.emplace_back(Curve{"D4*, scale " + concat(scale), {}});
    for (const double step : steps)
      c.points.push_back(through_lattice(source, LatticeKind::d4star, scale, scale, step, 0));
  }
  std::vector<Row> rows;
  Plot plot{"error against bytes, " + source.name, "KiB", "PSNR, dB", true, false, {}};
  for (const Curve& c : curves) {
    Series series{c.name, {}, true, {}};
    for (size_t i = 0; i < c.points.size(); ++i) {
      const RatePoint& p = c.points[i];
      series.points.push_back({static_cast<double>(p.bytes) / 1024, p.psnr});
      const bool lattice = c.name.starts_with("D4*");
      const auto ahead = [&](size_t baseline) {
        const double other = at_bytes(curves[baseline].points, p.bytes);
        return lattice && std::isfinite(other) ? number(p.psnr - other, 1) : std::string("-");
      };
      rows.push_back(
          {word("stored", c.name), figure("step / range", steps[i] / peak, 5),
           word("KiB", whole_kib(p.bytes)),
           figure("ratio", static_cast<double>(source.bytes.size()) / static_cast<double>(p.bytes), 1),
           figure("PSNR dB", p.psnr, 1), figure("largest / range", p.largest / peak, 4),
           figure("kept % of relevant", p.kept_percent, 1), word("dB over dropping, linear", ahead(0)),
           word("cubic", ahead(1))});
    }
    plot.series.push_back(std::move(series));
  }
  report.table("error against bytes: " + source.name, rows);
  report.plot("rate", plot);

  // Files that keep a bound, by the scale that gives the smallest.
  rows.clear();
  Plot bounds{"bytes of an accepted error, " + source.name,
              "largest error / range",
              "ratio to the source",
              true,
              true,
              {}};
  for (const double scale : {1.0, 1.6, 2.5}) {
    if (report.quick && scale == 2.5) continue;
    Series series{"D4*, scale " + concat(scale), {}, true, {}};
    for (const double part : {0.1, 0.03, 0.01, 0.003, 0.001}) {
      if (report.quick && part != 0.03 && part != 0.003) continue;
      const double bound = part * peak;
      const RatePoint p = through_lattice(source, LatticeKind::d4star, scale, scale, bound / 2, bound);
      const double ratio = static_cast<double>(source.bytes.size()) / static_cast<double>(p.bytes);
      series.points.push_back({part, ratio});
      rows.push_back({figure("bound / range", part, 3), word("lattice", series.title),
                      word("KiB", whole_kib(p.bytes)), figure("ratio", ratio, 1),
                      figure("largest / bound", p.largest / bound, 3), figure("PSNR dB", p.psnr, 1)});
    }
    bounds.series.push_back(std::move(series));
  }
  report.table("bytes of an accepted error: " + source.name, rows);
  report.plot("bound", bounds);
}

} // namespace bccsplat::bench
