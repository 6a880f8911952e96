#include "tool/import/spectrum.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "readers/error.h"
#include "tool/interrupt.h"

namespace bcc4 {
namespace {

constexpr size_t kBlockEdge = 32, kSmallestEdge = 8; // samples; a shorter axis is not measured
constexpr size_t kMostBlocks = 8;                    // of a stretch and channel
constexpr double kReserve = 0.75;                    // of the cell: what lies in it is reconstructed well
// Parts of the energy. What lies outside the cell folds back as error: more than kMuch of it is reason to
// advise the Cartesian lattice. A coarser lattice is advised while it leaves outside, beside what is outside
// already, at most kMoreLost as much again and at most kInsideLost of what is still inside; kNegligible may
// be lost in any case.
constexpr double kMuch = 1e-2, kNegligible = 1e-4;
constexpr double kMoreLost = 0.5, kInsideLost = 0.125;
constexpr double kFineEnough = 0.25; // resolution of an axis to judge by
constexpr double kFewestSteps = 2;   // along time on a coarser lattice
constexpr double kScales[] = {1.25, 1.5, 2, 2.5, 3, 4, 6, 8};
constexpr double kRounding = 1e-9; // of sums of frequencies: the border of the cell belongs to it

using Complex = std::complex<double>;

// In place, n a power of two: radix 2, decimation in time.
void transform(Complex* v, size_t n) {
  for (size_t i = 1, j = 0; i < n; ++i) {
    size_t bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(v[i], v[j]);
  }
  for (size_t length = 2; length <= n; length <<= 1) {
    const Complex turn = std::polar(1.0, -2 * std::numbers::pi / static_cast<double>(length));
    for (size_t i = 0; i < n; i += length) {
      Complex w = 1;
      for (size_t k = 0; k < length / 2; ++k, w *= turn) {
        const Complex a = v[i + k], b = v[i + k + length / 2] * w;
        v[i + k] = a + b;
        v[i + k + length / 2] = a - b;
      }
    }
  }
}

// Along every line of an axis.
void transform_axis(std::vector<Complex>& block, const std::array<size_t, 4>& n, size_t axis) {
  if (n[axis] == 1) return;
  size_t stride = 1;
  for (size_t a = 0; a < axis; ++a) stride *= n[a];
  std::vector<Complex> line(n[axis]);
  for (size_t first = 0; first < block.size(); first += stride * n[axis])
    for (size_t s = 0; s < stride; ++s) {
      Complex* at = block.data() + first + s;
      for (size_t i = 0; i < n[axis]; ++i) line[i] = at[i * stride];
      transform(line.data(), line.size());
      for (size_t i = 0; i < n[axis]; ++i) at[i * stride] = line[i];
    }
}

size_t power_of_two_up_to(uint64_t n) {
  size_t p = 1;
  while (2 * p <= std::min<uint64_t>(n, kBlockEdge)) p *= 2;
  return p < kSmallestEdge ? 1 : p;
}

double hann(size_t i, size_t n) {
  return n == 1 ? 1
                : 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (static_cast<double>(i) + 0.5) /
                                       static_cast<double>(n));
}

std::string per_cent(double part) { return concat(short_number(100 * part, 2), " %"); }

} // namespace

Spectrum::Spectrum(const std::vector<SampleStretch>& sample, const std::vector<double>& air) {
  for (size_t a = 0; a < 3; ++a) n_[a] = power_of_two_up_to(sample.front().box.dims[a]);
  n_[3] = power_of_two_up_to(sample.front().frames);
  size_t bins = 1;
  for (const size_t n : n_) bins *= n / 2 + 1;
  energy_.assign(bins, 0);
  const size_t samples = n_[0] * n_[1] * n_[2] * n_[3];
  std::vector<Complex> block(samples);
  for (const SampleStretch& s : sample)
    for (size_t c = 0; c < s.values.size(); ++c) {
      // Blocks side by side, as many as fit.
      std::array<size_t, 4> fit{s.box.dims[0] / n_[0], s.box.dims[1] / n_[1], s.box.dims[2] / n_[2],
                                s.frames / n_[3]};
      for (size_t a = 0; a < 4; ++a) fit[a] = n_[a] == 1 ? 1 : std::max<size_t>(fit[a], 1);
      const size_t blocks = std::min(kMostBlocks, fit[0] * fit[1] * fit[2] * fit[3]);
      for (size_t b = 0; b < blocks; ++b) {
        stop_if_interrupted();
        const std::array<size_t, 4> at{b % fit[0] * n_[0], b / fit[0] % fit[1] * n_[1],
                                       b / fit[0] / fit[1] % fit[2] * n_[2],
                                       b / fit[0] / fit[1] / fit[2] % fit[3] * n_[3]};
        double mean = 0, weights = 0;
        const auto each = [&](const auto& body) {
          for (size_t i = 0; i < samples; ++i) {
            const std::array<size_t, 4> p{i % n_[0], i / n_[0] % n_[1], i / n_[0] / n_[1] % n_[2],
                                          i / n_[0] / n_[1] / n_[2]};
            const size_t source =
                (((at[3] + p[3]) * s.box.dims[2] + at[2] + p[2]) * s.box.dims[1] + at[1] + p[1]) *
                    s.box.dims[0] +
                at[0] + p[0];
            const auto v = static_cast<double>(s.values[c][source]);
            body(i, std::isfinite(v) ? v : air[c],
                 hann(p[0], n_[0]) * hann(p[1], n_[1]) * hann(p[2], n_[2]) * hann(p[3], n_[3]));
          }
        };
        each([&](size_t, double v, double w) { mean += w * v, weights += w; });
        mean /= weights;
        each([&](size_t i, double v, double w) { block[i] = w * (v - mean); });
        for (size_t a = 0; a < 4; ++a) transform_axis(block, n_, a);
        for (size_t i = 0; i < samples; ++i) {
          size_t rest = i, bin = 0, stride = 1;
          for (const size_t n : n_) {
            const size_t k = rest % n;
            bin += std::min(k, n - k) * stride;
            rest /= n, stride *= n / 2 + 1;
          }
          energy_[bin] += std::norm(block[i]);
        }
      }
    }
  for (const double e : energy_) total_ += e;
}

double Spectrum::resolution(size_t axis) const {
  return n_[axis] == 1 ? 0 : 4.0 / static_cast<double>(n_[axis]);
}

double Spectrum::percentile(size_t axis, double part) const {
  if (n_[axis] == 1 || empty()) return 0;
  const size_t count = n_[axis] / 2 + 1;
  size_t stride = 1;
  for (size_t a = 0; a < axis; ++a) stride *= n_[a] / 2 + 1;
  std::vector<double> sum(count);
  for (size_t i = 0; i < energy_.size(); ++i) sum[i / stride % count] += energy_[i];
  double below = 0;
  for (size_t k = 0; k < count; ++k)
    if ((below += sum[k]) >= part * total_) return static_cast<double>(k) / static_cast<double>(count - 1);
  return 1;
}

double Spectrum::outside(double scale, double time_scale) const {
  if (empty()) return 0;
  double sum = 0;
  for (size_t i = 0; i < energy_.size(); ++i) {
    std::array<double, 4> f{};
    size_t rest = i;
    for (size_t a = 0; a < 4; ++a) {
      const size_t count = n_[a] / 2 + 1;
      f[a] = n_[a] == 1 ? 0
                        : static_cast<double>(rest % count) / static_cast<double>(count - 1) *
                              (a == 3 ? time_scale : scale);
      rest /= count;
    }
    std::sort(f.begin(), f.end());
    if (f[2] + f[3] > std::numbers::sqrt2 + kRounding) sum += energy_[i];
  }
  return sum / total_;
}

SpectrumAdvice advise_lattice(const Spectrum& spectrum, uint64_t frames) {
  SpectrumAdvice advice;
  if (spectrum.empty()) return advice;
  advice.cartesian = spectrum.outside(1, 1) > kMuch;
  const double lost = spectrum.outside(1 / kReserve, 1 / kReserve);
  const double allowed = std::max(kNegligible, lost + std::min(kMoreLost * lost, kInsideLost * (1 - lost)));
  for (const double x : kScales) {
    if (spectrum.resolution(3) > 0 && spectrum.resolution(3) <= kFineEnough &&
        (static_cast<double>(frames) - 1) / x >= kFewestSteps &&
        spectrum.outside(1 / kReserve, x / kReserve) <= allowed)
      advice.time_scale = x;
    const bool fine = spectrum.resolution(0) <= kFineEnough && spectrum.resolution(1) <= kFineEnough &&
                      spectrum.resolution(2) <= kFineEnough;
    if (fine && !advice.cartesian && spectrum.outside(x / kReserve, 1 / kReserve) <= allowed)
      advice.scale = x;
  }
  return advice;
}

std::vector<std::string> spectrum_lines(const Spectrum& spectrum, uint64_t frames) {
  if (spectrum.empty()) return {"constant"};
  std::vector<std::string> lines;
  std::string text;
  constexpr const char* names[] = {"x", "y", "z", "t"};
  for (size_t a = 0; a < 4; ++a) {
    if (spectrum.resolution(a) == 0) continue;
    text += concat(text.empty() ? "" : ", ", names[a], " ", short_number(spectrum.percentile(a, 0.9), 2),
                   " / ", short_number(spectrum.percentile(a, 0.99), 2), " / ",
                   short_number(spectrum.percentile(a, 0.999), 2));
  }
  lines.push_back(concat(text, " of Nyquist hold 90 / 99 / 99.9 % of the energy"));
  lines.push_back(
      concat(per_cent(spectrum.outside(1, 1)), " of the energy lies outside the cell of the lattice"));
  const SpectrumAdvice advice = advise_lattice(spectrum, frames);
  if (advice.cartesian) lines.push_back("advice: --lattice cc keeps it; else it folds back as error");
  if (advice.time_scale > 1)
    lines.push_back(concat("advice: the spectrum has room for --time-scale ", advice.time_scale,
                           "; auto tries what the series bears"));
  if (advice.scale > 1)
    lines.push_back(
        concat("advice: the spectrum has room for --scale ", advice.scale, "; --abs or --psnr try it"));
  return lines;
}

Json spectrum_json(const Spectrum& spectrum, uint64_t frames) {
  Json j;
  constexpr const char* names[] = {"x", "y", "z", "t"};
  for (size_t a = 0; a < 4; ++a)
    if (spectrum.resolution(a) > 0)
      j["bandwidth"][names[a]] = {{"p50", spectrum.percentile(a, 0.5)},
                                  {"p90", spectrum.percentile(a, 0.9)},
                                  {"p99", spectrum.percentile(a, 0.99)},
                                  {"p999", spectrum.percentile(a, 0.999)},
                                  {"resolution", spectrum.resolution(a)}};
  const SpectrumAdvice advice = advise_lattice(spectrum, frames);
  j["outside_cell"] = spectrum.outside(1, 1);
  j["advice"] = {{"scale", advice.scale},
                 {"time_scale", advice.time_scale},
                 {"lattice", advice.cartesian ? "cc" : "d4star"}};
  return j;
}

} // namespace bcc4
