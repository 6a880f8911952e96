// SPDX-License-Identifier: Apache-2.0
// Makes a random field by Fourier transforms along each axis, and takes series through fit and container into
// memory, measuring the PSNR at the sites and at every seventh sample of the source.
#include "tests/bench/storage/storage_series.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "base/error.h"
#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "formats/bcc4/read/samples.h"
#include "kernel/kernel.h"
#include "points/sample_source.h"
#include "store/channel_info.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {
namespace {

using Complex = std::complex<float>;

// In place, along one axis of n^4 values; conjugate on both sides for the inverse.
void transform_axis(std::vector<Complex>& values, size_t n, size_t stride) {
  std::vector<Complex> line(n), roots(n / 2);
  for (size_t k = 0; k < n / 2; ++k) {
    const double angle = -2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n);
    roots[k] = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
  }
  const int bits = std::countr_zero(n);
  for (size_t first = 0; first < values.size(); ++first) {
    if (first / stride % n != 0) continue;
    for (size_t i = 0; i < n; ++i) {
      size_t reversed = 0;
      for (int b = 0; b < bits; ++b) reversed |= (i >> b & 1) << (bits - 1 - b);
      line[reversed] = values[first + i * stride];
    }
    for (size_t half = 1; half < n; half *= 2)
      for (size_t block = 0; block < n; block += 2 * half)
        for (size_t k = 0; k < half; ++k) {
          const Complex a = line[block + k], b = line[block + k + half] * roots[k * (n / (2 * half))];
          line[block + k] = a + b, line[block + k + half] = a - b;
        }
    for (size_t i = 0; i < n; ++i) values[first + i * stride] = line[i];
  }
}

void transform(std::vector<Complex>& values, size_t n) {
  for (size_t stride = 1; stride < values.size(); stride *= n) transform_axis(values, n, stride);
}

struct Fitted {
  FitReport report;
  std::vector<BrickLayer> layers;
};

Fitted fit_series(const FitSeries& s, LatticeKind lattice, const Quantiser& quantiser,
                  const Context& context) {
  FitOptions o;
  o.dims = s.dims;
  o.lattice = lattice;
  o.channels[0].quantiser = quantiser;
  Fitted out;
  Fit fit(
      o,
      [&](int32_t, int, std::span<const BrickLayer> given) {
        out.layers.insert(out.layers.end(), given.begin(), given.end());
      },
      context);
  const size_t frame = size_t{s.dims[0]} * s.dims[1] * s.dims[2];
  for (uint32_t t = 0; t < s.dims[3]; ++t) {
    FrameBox box;
    box.dims = {s.dims[0], s.dims[1], s.dims[2]};
    box.data = s.values.data() + t * frame;
    fit.add_frame(0, {&box, 1});
  }
  out.report = fit.finish();
  return out;
}

double psnr(double peak, double squares, uint64_t count) {
  return 20 * std::log10(peak / std::sqrt(squares / static_cast<double>(count)));
}

// Of the kept samples of `a` against the same sites of `b`.
double site_psnr(const std::vector<BrickLayer>& a, const std::vector<BrickLayer>& b, double peak) {
  double squares = 0;
  uint64_t count = 0;
  for (size_t m = 0; m < a.size(); ++m)
    for (size_t s = 0; s < a[m].brick_slots(); ++s) {
      const Brick *p = a[m].brick(s), *q = b[m].brick(s);
      if (!p) continue;
      for (size_t i = 0; i < brick_sites; ++i) {
        if (!(p->kept[i / brick_edge] >> (i % brick_edge) & 1)) continue;
        const double d = p->value[i] - (q ? static_cast<double>(q->value[i]) : 0);
        squares += d * d;
        ++count;
      }
    }
  return psnr(peak, squares, count);
}

// Every 7th sample in the order of the array, but for the borders.
double field_psnr(const FitSeries& s, const SampleSource& samples, const StoreOptions& o, double peak,
                  const Context& context) {
  const Coefficients coefficients(samples, 0, make_kernel(o.kernel), 0, uint64_t{1} << 31);
  const uint64_t border = o.border;
  double squares = 0;
  uint64_t count = 0;
  const uint64_t frame = uint64_t{s.dims[0]} * s.dims[1] * s.dims[2];
  for (uint64_t t = border; t + border < s.dims[3]; ++t) {
    std::vector<Vec4> points;
    std::vector<float> truth;
    for (uint64_t i = t % 7; i < frame; i += 7) {
      const uint64_t x = i % s.dims[0], y = i / s.dims[0] % s.dims[1], z = i / s.dims[0] / s.dims[1];
      if (x < border || y < border || z < border || x + border >= s.dims[0] || y + border >= s.dims[1] ||
          z + border >= s.dims[2])
        continue;
      points.push_back({double(x), double(y), double(z), double(t)});
      truth.push_back(s.values[t * frame + i]);
    }
    std::vector<float> values(points.size());
    (void)evaluate4(coefficients, points, values, {}, context);
    for (size_t i = 0; i < values.size(); ++i) {
      const double d = static_cast<double>(values[i]) - truth[i];
      squares += d * d;
    }
    count += values.size();
  }
  return psnr(peak, squares, count);
}

} // namespace

FitSeries gaussian_field(uint32_t n, double sigma, double cut, uint32_t seed) {
  if (!std::has_single_bit(n)) fail(Code::invalid_argument, "gaussian_field: ", n, " is no power of 2");
  std::mt19937 random(seed);
  std::normal_distribution<float> noise;
  std::vector<Complex> values(size_t{n} * n * n * n);
  for (Complex& v : values) v = noise(random);
  transform(values, n);
  for (size_t i = 0; i < values.size(); ++i) {
    double square = 0; // of |w| in Nyquist frequencies
    for (size_t rest = i, a = 0; a < 4; ++a, rest /= n) {
      const auto k = static_cast<double>(rest % n);
      const double w = std::min(k, n - k) / (n / 2.0);
      square += w * w;
    }
    // The power is the square of the amplitude.
    values[i] *= square > cut * cut ? 0.0f : static_cast<float>(std::exp(-square / (4 * sigma * sigma)));
    values[i] = std::conj(values[i]);
  }
  transform(values, n);
  float largest = 0;
  for (const Complex& v : values) largest = std::max(largest, std::fabs(v.real()));
  FitSeries s{{n, n, n, n}, {}};
  s.values.reserve(values.size());
  for (const Complex& v : values) s.values.push_back(v.real() / largest);
  return s;
}

StoredSeries store(const FitSeries& series, const StoreOptions& o) {
  Tasks tasks;
  MemoryBudget memory;
  Progress progress;
  const Context context{tasks, memory, progress};
  StoredSeries out;
  const auto [low, high] = std::minmax_element(series.values.begin(), series.values.end());
  out.peak = static_cast<double>(*high) - *low;

  Fitted fitted = fit_series(series, o.lattice, o.quantiser, context);
  VolumeInfo info;
  info.lattice = fitted.report.lattice;
  info.channels.resize(1);
  ChannelInfo& c = info.channels[0];
  c.type = o.quantiser.type, c.scale = o.quantiser.scale, c.offset = o.quantiser.offset,
  c.air = o.quantiser.air;
  Bcc4Writer writer(create_memory_sink(out.file), info, {.level = o.level});
  const size_t slab = info.slab_layers;
  out.write_seconds = cpu_seconds([&] {
    for (size_t m = 0; m < fitted.layers.size(); m += slab)
      writer.write_slab(static_cast<int32_t>(m / slab), 0,
                        std::span(fitted.layers).subspan(m, std::min(slab, fitted.layers.size() - m)),
                        context);
  });
  describe_channel(fitted.report.channels[0], writer.info().channels[0]);
  out.report = writer.finish(context);
  if (!o.kernel.empty()) {
    Quantiser exact;
    exact.air = o.quantiser.air;
    out.site_psnr = site_psnr(fitted.layers, fit_series(series, o.lattice, exact, context).layers, out.peak);
    const Bcc4Samples samples(Bcc4Reader::open(open_memory_source(out.file)), memory);
    out.field_psnr = field_psnr(series, samples, o, out.peak, context);
  }
  out.fit = std::move(fitted.report);
  return out;
}

} // namespace bccsplat::bench
