// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/moments/moments_series.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <zlib.h>

#include "base/error.h"
#include "store/volume_writer.h"
#include "tests/bench/report.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

struct Wave {
  double x, y, z, t, phase; // radians a voxel or frame
};

std::vector<Wave> make_waves() {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Wave> made;
  for (int i = 0; i < 12; ++i) {
    Wave w{unit(random), unit(random), unit(random), unit(random), 3 * unit(random)};
    const double length = std::sqrt(w.x * w.x + w.y * w.y + w.z * w.z + w.t * w.t);
    const double scale = 2 * std::numbers::pi / (8 + 52 * std::fabs(unit(random))) / length;
    w.x *= scale, w.y *= scale, w.z *= scale, w.t *= scale;
    made.push_back(w);
  }
  return made;
}

// Adds a wave at time t to n^3 values: a product of turns along the axes, two multiplications a voxel.
void add_wave(const Wave& w, double t, size_t n, std::vector<float>& sum) {
  const double c = std::cos(w.x), s = std::sin(w.x);
  for (size_t z = 0; z < n; ++z)
    for (size_t y = 0; y < n; ++y) {
      const double start = w.y * static_cast<double>(y) + w.z * static_cast<double>(z) + w.t * t + w.phase;
      double re = std::cos(start), im = std::sin(start);
      float* row = sum.data() + (z * n + y) * n;
      for (size_t x = 0; x < n; ++x) {
        row[x] += static_cast<float>(re);
        const double next = re * c - im * s;
        im = re * s + im * c, re = next;
      }
    }
}

} // namespace

double MomentSeries::voxels() const { return std::pow(edge, 3) * frames; }

std::vector<uint8_t> MomentSeries::frame(uint32_t t) const {
  static const std::vector<Wave> waves = make_waves();
  const size_t n = edge;
  std::vector<float> sum(n * n * n);
  for (const Wave& w : waves) add_wave(w, t, n, sum);
  std::vector<uint8_t> values(sum.size());
  const double radius = 0.31 * edge, middle = 0.5 * edge + 0.2 * t;
  for (size_t i = 0; i < values.size(); ++i) {
    const double dx = static_cast<double>(i % n) - middle, dy = static_cast<double>(i / n % n) - 0.5 * edge,
                 dz = static_cast<double>(i / n / n) - 0.5 * edge;
    const bool empty = sparse && dx * dx + dy * dy + dz * dz > radius * radius;
    values[i] = empty ? 0 : static_cast<uint8_t>(std::clamp(128.5f + 14 * sum[i], 1.0f, 255.0f));
  }
  return values;
}

WrittenSeries write_series(const MomentSeries& series) {
  test::TestContext context(1);
  WrittenSeries out;
  WriterSettings settings;
  settings.dims = {series.edge, series.edge, series.edge, series.frames};
  settings.coefficients = series.coefficients, settings.levels = series.levels;
  if (series.measured) settings.measure = Measure::some;
  VolumeWriter writer(settings, create_memory_sink(out.file), context.get());
  for (uint32_t t = 0; t < series.frames; ++t) {
    const std::vector<uint8_t> values = series.frame(t);
    FrameBox box;
    box.type = SourceType::u8;
    for (int64_t& n : box.dims) n = series.edge;
    box.data = values.data();
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
