// SPDX-License-Identifier: Apache-2.0
// Cuts the volume at each frame of the source and compares plane by plane: all samples, those outside air,
// and those that an export would round; the worst one, and missing data on either side. Prints the result or
// makes JSON of it.
#include "tool/import/comparison.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "series/read_series.h"
#include "tool/json.h"
#include "tool/output/export_type.h"
#include "tool/run_watch.h"
#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

void compare_frame(const Slice& slice, const Frame& frame, uint64_t number, const SeriesDescription& s,
                   const bccsplat_channel_info& channel, double uncovered, Comparison& out,
                   ChannelScan& scan) {
  const uint64_t nx = s.dims[0], ny = s.dims[1];
  const Type written = out.export_type = export_type(channel);
  std::vector<double> expected(nx * ny);
  // The file has the nearest float of the source's air.
  const double near_air = std::max(channel.air_threshold, 0x1p-24 * std::abs(channel.air));
  const auto compare = [&](uint64_t first, std::span<const float> values) {
    for (uint64_t z = first; z < first + values.size() / (nx * ny); ++z) {
      gather_plane(frame, s.dims, z, uncovered, expected.data());
      const float* got = values.data() + (z - first) * nx * ny;
      for (uint64_t i = 0; i < nx * ny; ++i) {
        if (!std::isfinite(static_cast<float>(expected[i]))) {
          ++out.holes_expected;
          continue;
        }
        if (std::isnan(got[i])) {
          ++out.holes_got;
          continue;
        }
        const double difference = got[i] - expected[i];
        if (std::abs(difference) > out.all.max || out.all.count == 0)
          out.worst = {number, {i % nx, i / nx, z}, expected[i], got[i]};
        out.all.add(difference);
        if (!is_float(written)) out.exported.add(exported_value(written, got[i]) - expected[i]);
        if (std::abs(expected[i] - channel.air) > near_air) out.relevant.add(difference);
      }
    }
  };
  // A slice of a periodic axis has sample 0 once more.
  sample_planes(slice, compare, SampleBox{{0, 0, 0}, {nx, ny, s.dims[2]}});
  scan_frame(frame, number, s.dims, uncovered, channel.air_threshold, scan);
}

Json difference_json(const Difference& d, double peak) {
  return {{"max_abs", d.max},
          {"rmse", d.rmse()},
          {"psnr", d.count ? Json(d.psnr(peak)) : Json()},
          {"samples_compared", d.count}};
}

std::string psnr_text(const Difference& d, double peak) {
  if (d.count == 0) return "nothing to compare";
  if (d.sum_of_squares == 0) return "exact";
  return peak > 0 ? concat("PSNR ", short_number(d.psnr(peak), 4), " dB (peak ", short_number(peak), ")")
                  : "no PSNR of a constant";
}

} // namespace

void Difference::add(double difference) {
  max = std::max(max, std::abs(difference));
  sum_of_squares += difference * difference;
  ++count;
}

void Difference::add(const Difference& other) {
  max = std::max(max, other.max);
  sum_of_squares += other.sum_of_squares;
  count += other.count;
}

double Difference::rmse() const { return count ? std::sqrt(sum_of_squares / static_cast<double>(count)) : 0; }

double Difference::psnr(double peak) const {
  return sum_of_squares == 0 ? std::numeric_limits<double>::infinity() : 20 * std::log10(peak / rmse());
}

void Comparison::add(const Comparison& other) {
  if (other.all.count > 0 && (all.count == 0 || other.all.max > all.max)) worst = other.worst;
  all.add(other.all), relevant.add(other.relevant), exported.add(other.exported);
  export_type = other.export_type;
  holes_expected += other.holes_expected, holes_got += other.holes_got;
}

std::vector<Comparison> compare_series(const Volume& volume, FrameReader& source, bool progress) {
  const SeriesDescription& s = source.description();
  std::vector<Comparison> out(s.channels.size());
  RunWatch watch(progress);
  read_series(source, {0, s.dims[3]}, "verify", watch, [&](uint64_t f, uint32_t c, const Frame& values) {
    const Slice slice = cut_frame(volume, static_cast<double>(f), c);
    const bccsplat_channel_info info = channel_info(volume, c);
    Comparison& one = out[c].frames.emplace_back();
    one.worst.frame = f;
    compare_frame(slice, values, f, s, info, s.sparse ? s.channels[c].air : info.air, one, out[c].scan);
    out[c].add(one);
  });
  return out;
}

Json comparison_json(const Comparison& c, double bound) {
  const double peak = c.scan.empty() ? 0 : c.scan.max - c.scan.min;
  Json j = difference_json(c.all, peak);
  j["peak"] = peak;
  j["worst"] = {{"frame", c.worst.frame},
                {"voxel", c.worst.voxel},
                {"expected", c.worst.expected},
                {"got", c.worst.got}};
  j["non_air"] = difference_json(c.relevant, peak);
  j["exported"] = difference_json(is_float(c.export_type) ? c.all : c.exported, peak);
  j["exported"]["type"] = type_name(c.export_type);
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

void print_comparison(const std::string& name, const Comparison& c) {
  const double peak = c.scan.empty() ? 0 : c.scan.max - c.scan.min;
  std::printf("%s: %llu samples, max %s, RMSE %s, %s\n", name.c_str(),
              static_cast<unsigned long long>(c.all.count), short_number(c.all.max).c_str(),
              short_number(c.all.rmse()).c_str(), psnr_text(c.all, peak).c_str());
  if (c.relevant.count > 0 && c.relevant.count < c.all.count)
    std::printf("  outside air: %llu samples, max %s, RMSE %s, %s\n",
                static_cast<unsigned long long>(c.relevant.count), short_number(c.relevant.max).c_str(),
                short_number(c.relevant.rmse()).c_str(), psnr_text(c.relevant, peak).c_str());
  if (c.exported.count > 0)
    std::printf("  as export rounds them to %s: max %s, RMSE %s, %s\n", type_name(c.export_type),
                short_number(c.exported.max).c_str(), short_number(c.exported.rmse()).c_str(),
                psnr_text(c.exported, peak).c_str());
  const int digits = digits_apart(c.worst.expected, c.worst.got - c.worst.expected, 6);
  if (c.all.count > 0)
    std::printf(
        "  worst: frame %llu, voxel (%llu, %llu, %llu): %s, source %s\n",
        static_cast<unsigned long long>(c.worst.frame), static_cast<unsigned long long>(c.worst.voxel[0]),
        static_cast<unsigned long long>(c.worst.voxel[1]), static_cast<unsigned long long>(c.worst.voxel[2]),
        short_number(c.worst.got, digits).c_str(), short_number(c.worst.expected, digits).c_str());
  if (c.holes_expected > 0 || c.holes_got > 0)
    std::printf("  missing data: %llu source samples are not finite%s, %llu others are missing in the file\n",
                static_cast<unsigned long long>(c.holes_expected),
                c.scan.beyond > 0 ? " or beyond 32-bit floats" : "",
                static_cast<unsigned long long>(c.holes_got));
}

} // namespace bcc4
