// SPDX-License-Identifier: Apache-2.0
// Reads the options of the suite and makes the tables of speed, accuracy, kept samples and round trips; each
// of the others has a file of its own.
#include "tests/bench/fit/fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.h"
#include "base/text.h"
#include "fit/resample/resample.h"
#include "tests/bench/fit/fit_ends.h"
#include "tests/bench/fit/fit_faces.h"
#include "tests/bench/fit/fit_fields.h"
#include "tests/bench/fit/fit_held_out.h"
#include "tests/bench/fit/fit_lowpass.h"
#include "tests/bench/fit/fit_rate.h"
#include "tests/bench/fit/fit_real.h"
#include "tests/bench/fit/fit_source.h"
#include "tests/bench/fit/fit_turns.h"

namespace bccsplat::bench {
namespace {

// One thread; frames in memory, layers thrown away.
Row speed_row(const FitSource& s) {
  FitOptions options;
  FitReport report;
  const double time = median_cpu_seconds([&] { report = fit_source(s, options, 1, nullptr); });
  std::vector<std::byte> copy(s.bytes.size());
  const double copy_time = median_cpu_seconds([&] { std::memcpy(copy.data(), s.bytes.data(), copy.size()); });
  const auto bytes = static_cast<double>(s.bytes.size());

  // Scan and spatial resampling of one frame alone.
  Tasks tasks(1);
  MemoryBudget memory;
  Progress progress;
  const Context context{tasks, memory, progress};
  const SpatialResampler resampler(report.lattice);
  SiteBlockPool pool(memory);
  const FrameBox box = s.box(s.dims[3] / 2);
  const Frame frame({&box, 1}, box.dims, 0, s.name);
  FrameScan scan;
  const double scan_time = median_cpu_seconds([&] { scan = scan_frame(frame, 0, context); });
  const double spatial_time =
      median_cpu_seconds([&] { (void)resampler.resample(frame, scan.cells, 0, pool, context); });
  const auto sites = static_cast<double>(report.lattice.space.sites(0) + report.lattice.space.sites(1));

  const FitChannelReport& c = report.channels[0];
  return {word("series", s.name),
          figure("fit MB/s", bytes / time / 1e6, 0),
          figure("fit Msamples/s", static_cast<double>(c.source_samples) / time / 1e6, 0),
          figure("memcpy MB/s", bytes / copy_time / 1e6, 0),
          figure("fit / memcpy time", time / copy_time, 1),
          figure("scan Msamples/s",
                 static_cast<double>(s.frame_bytes() / source_bytes(s.type)) / scan_time / 1e6, 0),
          figure("spatial Msites/s", sites / spatial_time / 1e6, 0)};
}

Row kept_row(const FitSource& s, float threshold, float ringing) {
  FitOptions options;
  options.channels[0].threshold = threshold;
  options.channels[0].ringing = ringing;
  const FitChannelReport c = fit_source(s, options, 0, nullptr).channels[0];
  const auto percent = [](uint64_t part, uint64_t whole) {
    return 100 * static_cast<double>(part) / static_cast<double>(whole);
  };
  return {word("series", s.name),
          figure("threshold", threshold, 4),
          figure("ringing", ringing, 5),
          figure("sites % of samples", percent(c.sites_total, c.source_samples), 2),
          figure("relevant % of samples", percent(c.cc_relevant, c.source_samples), 2),
          figure("kept % of sites", percent(c.sites_kept, c.sites_total), 2),
          figure("kept % of relevant", percent(c.sites_kept, std::max<uint64_t>(c.cc_relevant, 1)), 2),
          figure("clamped", static_cast<double>(c.clamped), 0)};
}

Row round_trip_row(const FitSource& s, double scale, float ringing, const char* kernel) {
  FitOptions options;
  options.scales = {scale, scale, scale, scale};
  options.channels[0].ringing = ringing;
  const RoundTrip r = round_trip(s, options, kernel);
  const FitChannelReport& c = r.report.channels[0];
  return {word("series", s.name),
          word("kernel", kernel),
          figure("scale", scale, 2),
          figure("ringing", ringing, 5),
          figure("kept % of relevant",
                 100 * static_cast<double>(c.sites_kept) / static_cast<double>(c.cc_relevant), 2),
          figure("PSNR dB", r.psnr, 2),
          figure("PSNR inside dB", r.psnr_solid, 2),
          figure("inside rms/255", r.solid.rms, 4),
          figure("max", r.solid.largest, 2),
          figure("border air rms/255", r.border.rms, 4),
          figure("max", r.border.largest, 2),
          figure("far air rms/255", r.far.rms, 5),
          figure("max", r.far.largest, 3)};
}

} // namespace

int run_fit_suite(std::span<const std::string> args, const Report& report) {
  std::vector<std::string> tables;
  std::string raw, dims, type, folder, axis;
  std::vector<Row> rows;
  for (size_t i = 0; i < args.size(); ++i) {
    const auto value = [&]() -> const std::string& {
      if (i + 1 == args.size()) fail(Code::invalid_argument, args[i], " needs a value");
      return args[++i];
    };
    if (args[i] == "--raw")
      raw = value();
    else if (args[i] == "--data")
      folder = value();
    else if (args[i] == "--dims")
      dims = value();
    else if (args[i] == "--dtype")
      type = value();
    else if (args[i] == "--axis")
      axis = value();
    else if (args[i] == "--speed" || args[i] == "--accuracy" || args[i] == "--kept" ||
             args[i] == "--round-trip" || args[i] == "--rate" || args[i] == "--lowpass" ||
             args[i] == "--ends" || args[i] == "--held-out" || args[i] == "--real")
      tables.push_back(args[i]);
    else
      fail(Code::invalid_argument, "fit: unknown option ", args[i]);
  }
  if (!axis.empty()) {
    const size_t along = std::string("xyzt").find(axis);
    if (axis.size() != 1 || along == std::string::npos || tables != std::vector<std::string>{"--ends"})
      fail(Code::invalid_argument, "fit --ends --axis x, y, z or t");
    report_turns(along, report);
    return 0;
  }
  if (!raw.empty() && !folder.empty()) fail(Code::invalid_argument, "fit: --raw or --data, not both");
  if (!raw.empty()) {
    const FitSource s = raw_source(raw, dims, type);
    const auto asked = [&](const char* table) {
      return tables.empty() || std::find(tables.begin(), tables.end(), table) != tables.end();
    };
    if (asked("--rate")) report_rates(s, report);
    if (asked("--ends")) report_ends(s, report);
    if (!asked("--round-trip")) return 0;
    for (const float ringing : {0.0f, 1.0f / 2048, 1.0f / 512, 1.0f / 256, 1.0f / 64, 1.0f})
      rows.push_back(round_trip_row(s, 1, ringing, "default"));
    report.table("round trip: source -> D4* -> source samples", rows);
    report.table("samples kept", {kept_row(s, 0, 0), kept_row(s, 0, FitChannel{}.ringing)});
    report.table("speed, one thread", {speed_row(s)});
    return 0;
  }
  const auto wanted = [&](const char* table) {
    return tables.empty() || std::find(tables.begin(), tables.end(), table) != tables.end();
  };
  const float ringing = FitChannel{}.ringing;
  if (wanted("--speed")) {
    const std::array<uint32_t, 4> n =
        report.quick ? std::array<uint32_t, 4>{32, 32, 32, 8} : std::array<uint32_t, 4>{128, 128, 128, 16};
    FitSeries full{n, {}};
    for (size_t i = 0; i < size_t{n[0]} * n[1] * n[2] * n[3]; ++i)
      full.values.push_back(static_cast<float>(0.5 + 0.4 * std::sin(0.013 * static_cast<double>(i))));
    rows.push_back(speed_row(source_of<float>(full, SourceType::f32, 1, "full f32")));
    rows.push_back(speed_row(source_of<uint16_t>(full, SourceType::u16, 60000, "full u16")));
    rows.push_back(speed_row(source_of<uint8_t>(full, SourceType::u8, 255, "full u8")));
    rows.push_back(speed_row(source_of<float>(smoke_like(n), SourceType::f32, 1, "smoke-like f32")));
    report.table("speed, one thread", rows);
  }
  if (wanted("--accuracy")) {
    Row row;
    for (const double rho : {0.3, 0.5, 0.7, 0.9})
      row.push_back(figure("PSNR dB at rho " + concat(rho),
                           report.quick ? sample_psnr(rho, {24, 24, 24, 24}, 20, 11)
                                        : sample_psnr(rho, {40, 40, 40, 40}, 200, 11),
                           1));
    report.table("accuracy of the samples on D4*", {row});
  }
  if (folder.empty() && std::find(tables.begin(), tables.end(), "--held-out") != tables.end())
    fail(Code::invalid_argument, "fit --held-out looks at the real sets of --data DIR");
  if (!folder.empty() && wanted("--held-out")) report_held_out(folder, report);
  // It takes minutes: asked for by name only.
  if (std::find(tables.begin(), tables.end(), "--real") != tables.end()) report_real(folder, report);
  if (wanted("--lowpass")) report_lowpass(report);
  if (wanted("--ends")) {
    report_ends(report);
    report_faces(report);
    if (!folder.empty()) {
      report_ends(folder, report);
      report_faces(folder, report);
    }
  }
  FitSeries smoke;
  if (wanted("--kept") || wanted("--round-trip") || wanted("--rate"))
    smoke = report.quick ? smoke_like({32, 32, 32, 12}) : smoke_like({96, 96, 96, 24});
  if (wanted("--rate")) report_rates(source_of<float>(smoke, SourceType::f32, 1, "smoke-like f32"), report);
  if (wanted("--kept")) {
    rows.clear();
    for (const float r : {0.0f, ringing}) {
      rows.push_back(kept_row(source_of<float>(smoke, SourceType::f32, 1, "smoke-like f32"), 0, r));
      rows.push_back(kept_row(source_of<float>(smoke, SourceType::f32, 1, "smoke-like f32"), 1e-3f, r));
      rows.push_back(kept_row(source_of<uint16_t>(smoke, SourceType::u16, 40000, "smoke-like u16"), 0, r));
      rows.push_back(kept_row(source_of<uint8_t>(smoke, SourceType::u8, 160, "smoke-like u8"), 0, r));
    }
    report.table("samples kept", rows);
  }
  if (wanted("--round-trip")) {
    rows.clear();
    const FitSource source = source_of<float>(smoke, SourceType::f32, 1, "smoke-like f32");
    for (const float r : {0.0f, ringing, 1.0f}) rows.push_back(round_trip_row(source, 1, r, "default"));
    for (const double scale : {1.0, 1.25, 1.5, 2.0})
      if (!report.quick || scale != 1.25) rows.push_back(round_trip_row(source, scale, ringing, "default"));
    rows.push_back(round_trip_row(source, 1, ringing, "fine"));
    report.table("round trip: source -> D4* -> source samples", rows);
  }
  return 0;
}

} // namespace bccsplat::bench
