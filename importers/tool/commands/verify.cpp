// bcc4 verify: checksums of a file, and its field against the source it was made from.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>

#include "readers/open_series.h"
#include "readers/read_ahead.h"
#include "readers/scan.h"
#include "tool/commands/commands.h"
#include "tool/import/reader_arguments.h"
#include "tool/interrupt.h"
#include "tool/json.h"
#include "tool/progress.h"
#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

struct VerifyArguments {
  std::string file, kernel;
  ReaderArguments reader;
  CommonOptions common;
};

// Differences over one set of samples.
struct Difference {
  double max = 0;
  double sum_of_squares = 0;
  uint64_t count = 0;
  void add(double d) {
    max = std::max(max, std::abs(d));
    sum_of_squares += d * d;
    ++count;
  }
  void add(const Difference& other) {
    max = std::max(max, other.max);
    sum_of_squares += other.sum_of_squares;
    count += other.count;
  }
  [[nodiscard]] double rmse() const {
    return count ? std::sqrt(sum_of_squares / static_cast<double>(count)) : 0;
  }
  // Infinite for no difference at all.
  [[nodiscard]] double psnr(double peak) const {
    return sum_of_squares == 0 ? std::numeric_limits<double>::infinity() : 20 * std::log10(peak / rmse());
  }
};

struct Worst {
  uint64_t frame = 0;
  std::array<uint64_t, 3> voxel{};
  double expected = 0, got = 0;
};

struct Comparison {
  Difference all, relevant; // relevant: source samples further than the threshold from air
  Worst worst;
  std::vector<Comparison> frames; // of a series: frame by frame
  ChannelScan scan;
  uint64_t holes_expected = 0; // source values that are not finite
  uint64_t holes_got = 0;      // of the finite ones, those the file has as missing data
  void add(const Comparison& other) {
    if (other.all.count > 0 && (all.count == 0 || other.all.max > all.max)) worst = other.worst;
    all.add(other.all), relevant.add(other.relevant);
    holes_expected += other.holes_expected, holes_got += other.holes_got;
  }
};

void compare_frame(const Slice& slice, const Frame& frame, uint64_t number, const SeriesDescription& s,
                   const bccsplat_channel_info& channel, double uncovered, Comparison& out,
                   ChannelScan& scan) {
  const uint64_t nx = s.dims[0], ny = s.dims[1];
  std::vector<double> expected(nx * ny);
  sample_planes(slice, [&](uint64_t first, std::span<const float> values) {
    for (uint64_t z = first; z < first + values.size() / (nx * ny); ++z) {
      gather_plane(frame, s.dims, z, uncovered, expected.data());
      const float* got = values.data() + (z - first) * nx * ny;
      for (uint64_t i = 0; i < nx * ny; ++i) {
        if (!std::isfinite(expected[i])) {
          ++out.holes_expected;
          continue;
        }
        if (std::isnan(got[i])) {
          ++out.holes_got;
          continue;
        }
        const double difference = static_cast<double>(got[i]) - expected[i];
        if (std::abs(difference) > out.all.max || out.all.count == 0)
          out.worst = {number, {i % nx, i / nx, z}, expected[i], static_cast<double>(got[i])};
        out.all.add(difference);
        if (std::abs(expected[i] - channel.air) > channel.air_threshold) out.relevant.add(difference);
      }
    }
  });
  scan_frame(frame, number, s.dims, uncovered, channel.air_threshold, scan);
}

std::vector<Comparison> compare(const Volume& volume, VerifyArguments& a) {
  recall_reader_options(volume, a.reader);
  a.reader.options.max_memory = a.common.max_memory / 4;
  const std::unique_ptr<FrameReader> reader = open_series(a.reader.options);
  const SeriesDescription& s = reader->description();
  const bccsplat_volume_info v = volume_info(volume);
  if (!std::equal(s.dims.begin(), s.dims.end(), v.dims) || s.channels.size() != v.channel_count)
    fail_input("the source has ", s.dims[0], " x ", s.dims[1], " x ", s.dims[2], " x ", s.dims[3],
               " samples in ", s.channels.size(), " channel(s), but ", a.file, " was made from ", v.dims[0],
               " x ", v.dims[1], " x ", v.dims[2], " x ", v.dims[3], " in ", v.channel_count);
  std::vector<Comparison> out(s.channels.size());
  uint64_t total = 0, done = 0;
  for (size_t c = 0; c < s.channels.size(); ++c) total += frame_bytes(s, c) * s.dims[3];
  Progress progress("verify", total, true, a.common.quiet || a.common.json);
  ReadAhead frames(*reader);
  for (uint64_t f = 0; f < s.dims[3]; ++f)
    for (uint32_t c = 0; c < s.channels.size(); ++c) {
      stop_if_interrupted();
      const Slice slice = cut_frame(volume, static_cast<double>(f), {.channel = c});
      const bccsplat_channel_info info = channel_info(volume, c);
      Comparison& one = out[c].frames.emplace_back();
      one.worst.frame = f;
      compare_frame(slice, frames.next(), f, s, info, s.sparse ? s.channels[c].air : info.air, one,
                    out[c].scan);
      out[c].add(one);
      progress.update(done += frame_bytes(s, c), concat("frame ", f + 1, "/", s.dims[3]));
    }
  return out;
}

Json difference_json(const Difference& d, double peak) {
  return {{"max_abs", d.max},
          {"rmse", d.rmse()},
          {"psnr", d.count ? Json(d.psnr(peak)) : Json()},
          {"samples_compared", d.count}};
}

// bound: the one the file promises with this kernel; 0: none.
Json comparison_json(const Comparison& c, double bound) {
  const double peak = c.scan.empty() ? 0 : c.scan.max - c.scan.min;
  Json j = difference_json(c.all, peak);
  j["peak"] = peak;
  j["worst"] = {{"frame", c.worst.frame},
                {"voxel", c.worst.voxel},
                {"expected", c.worst.expected},
                {"got", c.worst.got}};
  j["non_air"] = difference_json(c.relevant, peak);
  if (bound > 0) j["bound"] = {{"abs", bound}, {"held", c.all.max <= bound}};
  j["holes"] = {{"source", c.holes_expected}, {"file", c.holes_got}};
  j["frames"] = Json::array();
  for (const Comparison& f : c.frames) {
    Json frame{{"frame", f.worst.frame}};
    frame.update(difference_json(f.all, peak));
    frame["voxel"] = f.worst.voxel;
    frame["non_air"] = difference_json(f.relevant, peak);
    j["frames"].push_back(std::move(frame));
  }
  return j;
}

std::string psnr_text(const Difference& d, double peak) {
  if (d.count == 0) return "nothing to compare";
  if (d.sum_of_squares == 0) return "exact";
  return peak > 0 ? concat("PSNR ", short_number(d.psnr(peak), 4), " dB") : "no PSNR of a constant";
}

void print_comparison(const std::string& name, const Comparison& c) {
  const double peak = c.scan.empty() ? 0 : c.scan.max - c.scan.min;
  std::printf("%s: %llu samples, max %s, RMSE %s, %s (peak %s)\n", name.c_str(),
              static_cast<unsigned long long>(c.all.count), short_number(c.all.max).c_str(),
              short_number(c.all.rmse()).c_str(), psnr_text(c.all, peak).c_str(), short_number(peak).c_str());
  if (c.relevant.count > 0 && c.relevant.count < c.all.count)
    std::printf("  outside air: %llu samples, max %s, RMSE %s, %s\n",
                static_cast<unsigned long long>(c.relevant.count), short_number(c.relevant.max).c_str(),
                short_number(c.relevant.rmse()).c_str(), psnr_text(c.relevant, peak).c_str());
  if (c.all.count > 0)
    std::printf(
        "  worst: frame %llu, voxel (%llu, %llu, %llu): %s, source %s\n",
        static_cast<unsigned long long>(c.worst.frame), static_cast<unsigned long long>(c.worst.voxel[0]),
        static_cast<unsigned long long>(c.worst.voxel[1]), static_cast<unsigned long long>(c.worst.voxel[2]),
        short_number(c.worst.got, 6).c_str(), short_number(c.worst.expected, 6).c_str());
  if (c.holes_expected > 0 || c.holes_got > 0)
    std::printf("  missing data: %llu source samples are not finite, %llu others are missing in the file\n",
                static_cast<unsigned long long>(c.holes_expected),
                static_cast<unsigned long long>(c.holes_got));
}

// A file too damaged to be opened has failed the check like any other; one that is no .bcc4 file is bad
// input.
Volume open_checked(const Device& device, const VerifyArguments& a) {
  try {
    return open_volume(device, a.file, a.kernel);
  } catch (const StatusError& e) {
    if (e.status() != BCCSPLAT_ERROR_CORRUPT && e.status() != BCCSPLAT_ERROR_TRUNCATED &&
        e.status() != BCCSPLAT_ERROR_CHECKSUM_MISMATCH)
      throw;
    if (a.common.json) print_json({{"ok", false}, {"error", e.what()}});
    fail(Exit::check_failed, e.what());
  }
}

Exit run_verify(VerifyArguments& a) {
  require(a.file, "FILE", "bcc4 verify smoke.bcc4");
  const Device device = create_device(a.common.threads, a.common.max_memory - a.common.max_memory / 4);
  const Volume volume = open_checked(device, a);
  if (volume_info(volume).part_end > 0 && !a.reader.options.inputs.empty())
    fail_usage(a.file, ": a part of a series; bcc4 concat joins all parts to what can be compared");
  auto report = sized<bccsplat_verify_report>();
  check(bccsplat_volume_verify(volume.get(), Progress::cancel_only, nullptr, &report), a.file);
  const bool ok = report.damages == 0;
  std::vector<Comparison> comparisons;
  if (ok && !a.reader.options.inputs.empty()) comparisons = compare(volume, a);

  if (a.common.json) {
    Json j{{"ok", ok},
           {"chunks", report.chunks},
           {"chunks_damaged", report.chunks_damaged},
           {"damages", report.damages},
           {"bytes_checked", report.bytes_checked}};
    j["first_damaged_offset"] = ok ? Json() : Json(report.first_damaged_offset);
    if (!comparisons.empty()) {
      const auto bound = [&](uint32_t c) {
        return a.kernel.empty() ? channel_info(volume, c).error_bound : 0;
      };
      j.update(comparison_json(comparisons[0], bound(0)));
      j["channels"] = Json::array();
      for (uint32_t c = 0; c < comparisons.size(); ++c) {
        Json entry{{"name", channel_info(volume, c).name}};
        entry.update(comparison_json(comparisons[c], bound(c)));
        j["channels"].push_back(std::move(entry));
      }
    }
    print_json(j);
  } else if (!a.common.quiet) {
    std::printf(
        "%s: %llu chunks, %s checked, %s\n", a.file.c_str(), static_cast<unsigned long long>(report.chunks),
        byte_text(static_cast<double>(report.bytes_checked)).c_str(),
        ok ? "no damage"
           : concat(report.damages, " damages, the first at offset ", report.first_damaged_offset).c_str());
    for (uint32_t c = 0; c < comparisons.size(); ++c)
      print_comparison(channel_info(volume, c).name, comparisons[c]);
  }
  if (!ok)
    fail(Exit::check_failed, a.file, ": ", report.damages, " damages (", report.chunks_damaged, " of ",
         report.chunks, " chunks), the first at offset ", report.first_damaged_offset,
         ": make the file again from its source");
  for (uint32_t c = 0; c < comparisons.size() && a.kernel.empty(); ++c) {
    const bccsplat_channel_info info = channel_info(volume, c);
    if (info.error_bound > 0 && comparisons[c].all.max > info.error_bound)
      fail(Exit::check_failed, a.file, ": channel ", info.name, " promises an error of at most ",
           info.error_bound, ", but differs by ", comparisons[c].all.max, " from this source");
  }
  return Exit::ok;
}

} // namespace

Run add_verify(CLI::App& app) {
  auto a = std::make_shared<VerifyArguments>();
  CLI::App& verify = *app.add_subcommand("verify", "Check a .bcc4 file, by itself or against its source");
  verify.add_option("FILE", a->file, "A .bcc4 file");
  verify
      .add_option("--against", a->reader.options.inputs,
                  "The source, read as it was at import: every sample is compared")
      ->type_name("INPUT...")
      ->expected(1, -1);
  add_reader_options(verify, a->reader);
  verify.add_option("--kernel", a->kernel, "Kernel to reconstruct with (default: the file's)")
      ->type_name("NAME");
  add_threads(verify, a->common);
  add_max_memory(verify, a->common);
  verify.add_flag("--json", a->common.json, "Report as JSON");
  verify.add_flag("--quiet", a->common.quiet, "Print errors only");
  return [a] { return run_verify(*a); };
}

} // namespace bcc4
