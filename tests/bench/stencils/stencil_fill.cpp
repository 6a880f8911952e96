// SPDX-License-Identifier: Apache-2.0
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
  for (int j = kernel.terms; j-- > 0;) sum = sum * u + static_cast<double>(kernel.a[static_cast<size_t>(j)]);
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

void SampleSheets::begin(const Slice& slice, const StencilView& view, int64_t first, int64_t last,
                         double margin) {
  const double plane = slice.lattice.plane_distance();
  const auto extent = [&](size_t n, double pitch) {
    const double planes = (slice.domain_end[view.axes[n]] - slice.domain_begin[view.axes[n]]) / plane;
    return static_cast<int>(std::ceil((planes + 2 * margin) / pitch)) + 1;
  };
  width_ = extent(0, 1), height_ = extent(1, view.pitch_v);
  pitch_ = (width_ + 31) / 32 * 32 + spare;
  const size_t each = static_cast<size_t>(pitch_) * static_cast<size_t>(height_);
  const auto count = static_cast<size_t>(last - first + 1);
  const size_t floats = each * count + 2 * spare;
  if (floats > memory_.capacity()) {
    memory_.reserve(floats);
    std::fill_n(memory_.data(), floats, 0.0f);
  }
  floats_ = floats;
  sheets_.resize(count);
  for (size_t n = 0; n < count; ++n) {
    SampleSheet& s = sheets_[n];
    s.k = first + static_cast<int64_t>(n);
    const auto start = [&](size_t axis, double pitch) {
      const double domain = slice.domain_begin[view.axes[axis]] / plane - margin;
      const double origin = view.origin[axis] + static_cast<double>(s.k) * view.shift[axis];
      return static_cast<int>(std::floor((domain - origin) / pitch));
    };
    s.first_u = start(0, 1), s.first_v = start(1, view.pitch_v);
    s.samples = memory_.data() + spare + n * each;
  }
}

void SampleSheets::fill(const Slice& slice, const StencilView& view, const SiteArray& sites, KernelForm form,
                        bool reference) {
  const KernelPolynomial kernel = kernel_polynomial(slice.kernel.space, form);
  uint64_t taps = 0, samples = 0;
  for (const SampleSheet& s : sheets_) {
    const auto k = static_cast<double>(s.k);
    for (int phase = 0; phase < view.phases_v; ++phase) {
      const Vec3 place{view.origin[0] + k * view.shift[0] + s.first_u,
                       view.origin[1] + k * view.shift[1] + (s.first_v + phase) * view.pitch_v,
                       view.origin[2] + k * view.shift[2]};
      const RowStencil stencil = make_row_stencil(slice, kernel, sites, place);
      taps += stencil.taps.size() + stencil.both, samples += 2;
      for (int y = phase; y < height_; y += view.phases_v) {
        const RowArgs row{sites.values.data() + y / view.phases_v * sites.row, &stencil,
                          s.samples + static_cast<std::ptrdiff_t>(y) * pitch_, width_};
        reference ? fill_row_reference(row) : fill_row(row);
      }
    }
  }
  taps_ = static_cast<double>(taps) / static_cast<double>(std::max<uint64_t>(samples, 1));
}

const SampleSheet& SampleSheets::sheet(int64_t k) const {
  return sheets_[static_cast<size_t>(
      std::clamp(k - sheets_.front().k, int64_t{0}, static_cast<int64_t>(sheets_.size()) - 1))];
}

uint64_t SampleSheets::samples() const {
  return static_cast<uint64_t>(width_) * static_cast<uint64_t>(height_) * sheets_.size();
}

} // namespace bccsplat::bench
