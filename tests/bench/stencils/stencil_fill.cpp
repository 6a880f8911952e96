// SPDX-License-Identifier: Apache-2.0
// The taps of a row are those of its two phases; taps that both have come first, so that coefficients are
// read once for two samples. The sums themselves are stencil_fill_simd.cpp.
#include "tests/bench/stencils/stencil_fill.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace bccsplat::bench {
namespace {

// Places along an axis, in planes: sites 2 m + coset within `reach` of `place` are m = first .. last.
struct Near {
  int first, last;
  Near(double place, int coset, double reach)
      : first(static_cast<int>(std::ceil(0.5 * (place - reach - coset)))),
        last(static_cast<int>(std::floor(0.5 * (place + reach - coset)))) {}
};

double value(const KernelPolynomial& kernel, double u) {
  double sum = 0;
  for (int j = kernel.terms; j-- > 0;) sum = sum * u + kernel.a[j];
  return sum;
}

// The stencil of a row whose sample 0 stands at `place`, planes, that of sample 1 a plane further along u.
RowStencil make_row_stencil(const Slice& slice, const KernelPolynomial& kernel, const SiteArray& sites,
                            const Vec3& place) {
  const double plane = slice.lattice.plane_distance(), square = plane * plane;
  const double radius = slice.kernel.space.radius, reach = radius / plane;
  struct Tap {
    std::ptrdiff_t site;
    std::array<double, 2> weight;
  };
  std::vector<Tap> taps;
  std::array<double, 2> sum{};
  for (int c = 0; c < 2; ++c) {
    const Near u(place[0] + 0.5, c, reach + 0.5), v(place[1], c, reach), w(place[2], c, reach);
    for (int z = w.first; z <= w.last; ++z)
      for (int y = v.first; y <= v.last; ++y) {
        const double dz = 2 * z + c - place[2], dy = 2 * y + c - place[1];
        for (int x = u.first; x <= u.last; ++x) {
          Tap t{sites.at(c, x, y, z), {}};
          for (size_t phase = 0; phase < 2; ++phase) {
            const double dx = 2 * x + c - place[0] - static_cast<double>(phase);
            const double r2 = square * (dx * dx + dy * dy + dz * dz);
            if (r2 < radius * radius) t.weight[phase] = value(kernel, 1 - r2 / (radius * radius));
            sum[phase] += t.weight[phase];
          }
          if (t.weight[0] != 0 || t.weight[1] != 0) taps.push_back(t);
        }
      }
  }
  RowStencil s;
  s.sum = sum;
  const auto add = [&](bool even, bool odd) {
    for (const Tap& t : taps)
      if ((t.weight[0] != 0) == even && (t.weight[1] != 0) == odd)
        s.taps.push_back(
            {t.site, {static_cast<float>(t.weight[0] / sum[0]), static_cast<float>(t.weight[1] / sum[1])}});
    return s.taps.size();
  };
  s.both = add(true, true);
  s.even = add(true, false) - s.both;
  add(false, true);
  return s;
}

} // namespace

void fill_row_reference(const RowArgs& a) {
  for (int n = 0; n < a.count; ++n) {
    float sum = 0;
    for (const StencilTap& t : a.stencil->taps) sum += t.weight[n & 1] * a.sites[t.site + n / 2];
    a.row[n] = sum;
  }
}

void SampleSheets::begin(const Slice& slice, const StencilView& view, const SiteArray& sites, KernelForm form,
                         int64_t first, int64_t last, double margin) {
  const double plane = slice.lattice.plane_distance();
  const auto extent = [&](size_t n, double pitch) {
    const double planes = (slice.domain_end[view.axes[n]] - slice.domain_begin[view.axes[n]]) / plane;
    return static_cast<int>(std::ceil((planes + 2 * margin) / pitch)) + 1;
  };
  width_ = extent(0, 1), height_ = extent(1, view.pitch_v);
  pitch_ = (width_ + 31) / 32 * 32;
  sites_ = sites.values.data(), site_row_ = sites.row, phases_ = view.phases_v;
  const KernelPolynomial kernel = kernel_polynomial(slice.kernel.space, form);
  sheets_.clear(), stencils_.clear();
  uint64_t taps = 0;
  for (int64_t k = first; k <= last; ++k) {
    const auto at = static_cast<double>(k);
    const auto start = [&](size_t axis, double pitch) {
      const double domain = slice.domain_begin[view.axes[axis]] / plane - margin;
      return static_cast<int>(std::floor((domain - view.origin[axis] - at * view.shift[axis]) / pitch));
    };
    const SampleSheet& s = sheets_.emplace_back(SampleSheet{k, start(0, 1), start(1, view.pitch_v), nullptr});
    for (int phase = 0; phase < phases_; ++phase) {
      const Vec3 place{view.origin[0] + at * view.shift[0] + s.first_u,
                       view.origin[1] + at * view.shift[1] + (s.first_v + phase) * view.pitch_v,
                       view.origin[2] + at * view.shift[2]};
      stencils_.push_back(make_row_stencil(slice, kernel, sites, place));
      taps += stencils_.back().taps.size() + stencils_.back().both;
    }
  }
  taps_ = static_cast<double>(taps) / (2 * static_cast<double>(stencils_.size()));
}

void SampleSheets::fill(bool reference) {
  const size_t each = static_cast<size_t>(pitch_) * height_;
  floats_ = each * sheets_.size() + 2 * spare;
  if (floats_ > memory_.capacity()) {
    memory_.reserve(floats_);
    std::fill_n(memory_.data(), floats_, 0.0f);
  }
  for (size_t n = 0; n < sheets_.size(); ++n) {
    sheets_[n].samples = memory_.data() + spare + n * each;
    fill_rows(n, 0, 0, width_, height_, sheets_[n].samples, pitch_, reference);
  }
}

void SampleSheets::fill_window(int64_t k, int width, int height, int pitch, SampleSheet& window) const {
  const size_t n = place(k);
  const auto whole = [](int x, int period) { return x - ((x % period) + period) % period; };
  int u = whole(window.first_u - sheets_[n].first_u, 2),
      v = whole(window.first_v - sheets_[n].first_v, phases_);
  window.k = k, window.first_u = sheets_[n].first_u + u, window.first_v = sheets_[n].first_v + v;
  const int left = std::min(std::max(-u, 0), width) / 2 * 2,
            above = std::min(std::max(-v, 0), height) / phases_ * phases_;
  u += left, v += above;
  fill_rows(n, u, v, std::min(width - left, width_ - u), std::min(height - above, height_ - v),
            window.samples + static_cast<std::ptrdiff_t>(above) * pitch + left, pitch, false);
}

// Samples from (u, v) of the sheet on, which a stencil begins at.
void SampleSheets::fill_rows(size_t sheet, int u, int v, int width, int height, float* to, int pitch,
                             bool reference) const {
  if (u < 0 || v < 0) return;
  for (int y = 0; y < height; ++y) {
    const RowStencil& stencil = stencils_[sheet * phases_ + y % phases_];
    const RowArgs row{sites_ + (v + y) / phases_ * site_row_ + u / 2, &stencil,
                      to + static_cast<std::ptrdiff_t>(y) * pitch, width};
    reference ? fill_row_reference(row) : fill_row(row);
  }
}

double SampleSheets::sum(const SampleSheet& sheet, int x, int y) const {
  const auto n = static_cast<size_t>(&sheet - sheets_.data()) * phases_;
  return stencils_[n + y % phases_].sum[x & 1];
}

size_t SampleSheets::place(int64_t k) const {
  return std::clamp(k - sheets_.front().k, int64_t{0}, static_cast<int64_t>(sheets_.size()) - 1);
}

uint64_t SampleSheets::samples() const { return static_cast<uint64_t>(width_) * height_ * sheets_.size(); }

} // namespace bccsplat::bench
