// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/moments/moments_series.h"

#include <algorithm>
#include <cmath>

#include <zlib.h>

#include "base/error.h"
#include "store/volume_writer.h"
#include "tests/bench/report.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
double MomentSeries::voxels() const { return std::pow(edge, 3) * frames; }

std::vector<float> MomentSeries::unrounded(uint32_t t) const {
  const size_t n = edge;
  std::vector<float> values = content_values(fill, n, t);
  const double radius = 0.31 * edge, middle = 0.5 * edge + 0.2 * t;
  for (size_t i = 0; i < values.size(); ++i) {
    const double dx = static_cast<double>(i % n) - middle, dy = static_cast<double>(i / n % n) - 0.5 * edge,
                 dz = static_cast<double>(i / n / n) - 0.5 * edge;
    const bool empty = sparse && dx * dx + dy * dy + dz * dz > radius * radius;
    values[i] = empty ? 0 : std::clamp(values[i], 1.0f, 255.0f);
  }
  return values;
}

std::vector<uint8_t> MomentSeries::frame(uint32_t t) const {
  const std::vector<float> given = unrounded(t);
  std::vector<uint8_t> values(given.size());
  for (size_t i = 0; i < values.size(); ++i)
    values[i] = static_cast<uint8_t>(std::min(given[i] + 0.5f, 255.0f));
  return values;
}

WrittenSeries write_series(const MomentSeries& series) {
  test::TestContext context(1);
  WrittenSeries out;
  WriterSettings settings;
  settings.dims = {series.edge, series.edge, series.edge, series.frames};
  settings.levels = series.levels;
  if (series.measured) settings.measure = Measure::some;
  VolumeWriter writer(settings, create_memory_sink(out.file), context.get());
  for (uint32_t t = 0; t < series.frames; ++t) {
    const std::vector<uint8_t> codes = series.exact ? std::vector<uint8_t>{} : series.frame(t);
    const std::vector<float> values = series.exact ? series.unrounded(t) : std::vector<float>{};
    FrameBox box;
    box.type = series.exact ? SourceType::f32 : SourceType::u8;
    for (int64_t& n : box.dims) n = series.edge;
    box.data = series.exact ? static_cast<const void*>(values.data()) : codes.data();
    out.seconds += cpu_seconds([&] { writer.add_frame(0, t, {&box, 1}); });
  }
  out.seconds += cpu_seconds([&] { (void)writer.finish(); });
  out.peak = context.memory.peak();
  return out;
}

double blend_seconds(const MomentSeries& series) {
  const std::vector<uint8_t> a = series.frame(3), b = series.frame(4);
  std::vector<float> out(a.size());
  return median_cpu_seconds([&] {
    for (size_t i = 0; i < a.size(); ++i)
      out[i] = static_cast<float>(a[i]) + 0.37f * static_cast<float>(static_cast<int>(b[i]) - a[i]);
  });
}

double gzip_seconds(const MomentSeries& series) {
  const std::vector<uint8_t> raw = series.frame(3);
  uLongf size = compressBound(static_cast<uLong>(raw.size()));
  std::vector<Bytef> out(size);
  return cpu_seconds([&] {
    if (compress2(out.data(), &size, raw.data(), static_cast<uLong>(raw.size()), 6) != Z_OK)
      fail(Code::internal, "zlib: no room");
  });
}

} // namespace bccsplat::bench
