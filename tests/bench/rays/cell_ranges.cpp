// SPDX-License-Identifier: Apache-2.0
// Values at the corners are sums of rows of coefficients with the same weights all along (stencil_fill.h).
// Layer by layer of corners, their smallest and largest over each cell are folded into the layer's cells; the
// range of the coefficients in reach, which is taken over the box around their ball, widens them.
#include "tests/bench/rays/cell_ranges.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/bench/stencils/site_array.h"
#include "tests/bench/stencils/stencil_fill.h"

namespace bccsplat::bench {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
// Planes beyond a cell that hold sites in reach of it.
constexpr int reach = 2;
// What sums of floats may be off by, of the largest coefficient.
constexpr float rounding = 1e-6f;

struct Row {
  std::vector<float> low, high;
};

class Filler {
 public:
  Filler(const Slice& slice, int parts, const CellBound& bound)
      : slice_(slice), parts_(parts), bound_(bound),
        sites_(make_site_array(slice, {0, 1, 2}, 2 * (reach + 2))) {
    for (size_t a = 0; a < 3; ++a) {
      out_.cells[a] = slice.lattice.last[a];
      out_.blocks[a] = (out_.cells[a] + block_edge - 1) / block_edge;
    }
    width_ = static_cast<size_t>(out_.cells[0]), height_ = static_cast<size_t>(out_.cells[1]);
    pitch_ = (width_ / 2 + 1 + 63) / 32 * 64;
    const double square = slice.kernel.space.radius * slice.kernel.space.radius;
    reach2_ = 2 * square;
    make_stencils();
    find_filled();
  }

  CellRanges make() {
    const size_t layer = width_ * height_;
    std::vector<float> low(block_edge * layer), high(low.size()), plane_low(layer), plane_high(layer);
    out_.of_block.assign(static_cast<size_t>(out_.blocks[0]) * static_cast<size_t>(out_.blocks[1]) *
                             static_cast<size_t>(out_.blocks[2]),
                         -1);
    corner_layer(0, plane_low, plane_high);
    for (int z0 = 0; z0 < out_.cells[2]; z0 += block_edge) {
      const int count = std::min(block_edge, out_.cells[2] - z0);
      for (int l = 0; l < count; ++l) {
        float* const to_low = low.data() + static_cast<size_t>(l) * layer;
        float* const to_high = high.data() + static_cast<size_t>(l) * layer;
        std::copy(plane_low.begin(), plane_low.end(), to_low);
        std::copy(plane_high.begin(), plane_high.end(), to_high);
        for (int h = 1; h <= parts_; ++h) {
          corner_layer((z0 + l) * parts_ + h, plane_low, plane_high);
          for (size_t n = 0; n < layer; ++n) {
            to_low[n] = std::min(to_low[n], plane_low[n]);
            to_high[n] = std::max(to_high[n], plane_high[n]);
          }
        }
        widen(z0 + l, to_low, to_high);
      }
      store(z0, count, low, high);
    }
    return std::move(out_);
  }

 private:
  static constexpr int phases = 4; // along y and z: halves of planes over two planes

  // Sample n of a row stands at n planes and `half` of one.
  RowStencil row_stencil(double half, double y, double z) const {
    RowStencil s;
    std::vector<StencilTap> both, even, odd;
    for (int pz = -reach - 1; pz <= reach + 3; ++pz)
      for (int py = -reach - 1; py <= reach + 3; ++py)
        for (int px = -reach - 1; px <= reach + 3; ++px) {
          const int c = px & 1;
          if ((py & 1) != c || (pz & 1) != c) continue;
          StencilTap t{sites_.at(c, (px - c) / 2, (py - c) / 2, (pz - c) / 2), {}};
          bool is[2]{};
          for (int n = 0; n < 2; ++n) {
            const double dx = px - half - n, dy = py - y, dz = pz - z;
            const double r2 = 0.5 * (dx * dx + dy * dy + dz * dz);
            is[n] = 2 * r2 < reach2_;
            if (is[n]) t.weight[n] = static_cast<float>(slice_.kernel.space.value(r2));
          }
          if (is[0] || is[1]) (is[0] && is[1] ? both : is[0] ? even : odd).push_back(t);
        }
    s.both = both.size(), s.even = even.size();
    for (const auto* list : {&both, &even, &odd}) s.taps.insert(s.taps.end(), list->begin(), list->end());
    return s;
  }

  void make_stencils() {
    for (int z = 0; z < phases; ++z)
      for (int y = 0; y < phases; ++y)
        for (int x = 0; x < 2; ++x) stencils_.push_back(row_stencil(0.5 * x, 0.5 * y, 0.5 * z));
  }

  // Of each plane y of each plane z: from which to which plane x sites are not the base.
  void find_filled() {
    const Int3 last = slice_.lattice.last;
    first_.assign(static_cast<size_t>((last[1] + 1) * (last[2] + 1)), std::numeric_limits<int>::max());
    last_.assign(first_.size(), -1);
    for (int z = 0; z <= last[2]; ++z)
      for (int y = z & 1; y <= last[1]; y += 2) {
        const int c = z & 1;
        const size_t at = static_cast<size_t>(z * (last[1] + 1) + y);
        const float* const row = sites_.values.data() + sites_.at(c, 0, y / 2, z / 2);
        for (int x = c; x <= last[0]; x += 2) {
          const float v = row[x / 2];
          if (v == 0) continue;
          first_[at] = std::min(first_[at], x), last_[at] = std::max(last_[at], x);
          largest_ = std::max(largest_, std::fabs(v));
        }
      }
  }

  // The cells [begin, end) of a row of corners that may see sites which are not the base.
  std::array<int, 2> filled(int y, int z) const {
    const Int3 last = slice_.lattice.last;
    int begin = std::numeric_limits<int>::max(), end = -1;
    for (int pz = std::max(z - reach - 1, 0); pz <= std::min(z + reach + 2, last[2]); ++pz)
      for (int py = std::max(y - reach - 1, 0); py <= std::min(y + reach + 2, last[1]); ++py) {
        const size_t at = static_cast<size_t>(pz * (last[1] + 1) + py);
        begin = std::min(begin, first_[at]), end = std::max(end, last_[at]);
      }
    if (end < 0) return {0, 0};
    return {std::max(begin - reach - 2, 0), std::min(end + reach + 2, out_.cells[0])};
  }

  // The smallest and largest corner of each cell of a row, along x alone.
  void corner_row(int y, int z, Row& to) {
    to.low.assign(width_, 0), to.high.assign(width_, 0);
    const int step = 2 / parts_; // halves
    const int hy = y * step, hz = z * step;
    auto [begin, end] = filled(hy / 2, hz / 2);
    if (begin >= end) return;
    begin -= begin % 2;
    const std::ptrdiff_t sites = (hz / 4) * sites_.layer + (hy / 4) * sites_.row + begin / 2;
    const size_t at = static_cast<size_t>((hz % 4) * phases + hy % 4) * 2;
    const int count = end - begin + 1;
    for (int half = 0; half < parts_; ++half) {
      row_[half].resize(pitch_ + 128);
      fill_row({sites_.values.data() + sites, &stencils_[at + static_cast<size_t>(half)], row_[half].data(),
                count});
    }
    const float *const whole = row_[0].data(), *const between = row_[parts_ - 1].data();
    float *const low = to.low.data() + begin, *const high = to.high.data() + begin;
    const auto n = static_cast<size_t>(end - begin);
    if (parts_ == 1) {
      for (size_t x = 0; x < n; ++x)
        low[x] = std::min(whole[x], whole[x + 1]), high[x] = std::max(whole[x], whole[x + 1]);
      return;
    }
    for (size_t x = 0; x < n; ++x) {
      low[x] = std::min(std::min(whole[x], whole[x + 1]), between[x]);
      high[x] = std::max(std::max(whole[x], whole[x + 1]), between[x]);
    }
  }

  void corner_layer(int z, std::vector<float>& low, std::vector<float>& high) {
    Row row;
    const int rows = out_.cells[1] * parts_;
    for (int y = 0; y <= rows; ++y) {
      corner_row(y, z, row);
      const auto fold = [&](int cell, bool first) {
        float* const l = low.data() + static_cast<size_t>(cell) * width_;
        float* const h = high.data() + static_cast<size_t>(cell) * width_;
        if (first) {
          std::copy(row.low.begin(), row.low.end(), l), std::copy(row.high.begin(), row.high.end(), h);
          return;
        }
        for (size_t x = 0; x < width_; ++x)
          l[x] = std::min(l[x], row.low[x]), h[x] = std::max(h[x], row.high[x]);
      };
      if (y > 0) fold((y - 1) / parts_, false);
      if (y % parts_ == 0 && y < rows) fold(y / parts_, true);
    }
  }

  // The range of the coefficients on the planes of one parity that a cell reaches, over x and y: rows of
  // sites three at a time.
  void window(int c, int w, std::vector<float>& low, std::vector<float>& high) const {
    const size_t columns = width_ / 2 + 2, rows = height_ / 2 + 2;
    low.resize(columns * rows), high.resize(low.size());
    for (size_t v = 0; v < rows; ++v)
      for (int dv = -1; dv <= 1; ++dv) {
        const float* const row = sites_.values.data() + sites_.at(c, 0, static_cast<int>(v) + dv, w);
        float *const l = low.data() + v * columns, *const h = high.data() + v * columns;
        for (size_t u = 0; u < columns; ++u) {
          const auto at = static_cast<std::ptrdiff_t>(u);
          const float least = std::min(std::min(row[at - 1], row[at]), row[at + 1]);
          const float most = std::max(std::max(row[at - 1], row[at]), row[at + 1]);
          l[u] = dv < 0 ? least : std::min(l[u], least), h[u] = dv < 0 ? most : std::max(h[u], most);
        }
      }
  }

  struct Window {
    int w = std::numeric_limits<int>::min();
    std::vector<float> low, high;
  };
  const Window& windowed(int c, int w) {
    Window& kept = windows_[static_cast<size_t>(c)][static_cast<size_t>((w + 3) % 3)];
    if (kept.w != w) kept.w = w, window(c, w, kept.low, kept.high);
    return kept;
  }

  // Widens the ranges of a layer of cells by what may lie between their corners.
  void widen(int z, float* low, float* high) {
    const std::array<int, 2> middle{(z + 1) / 2, z / 2}; // of the sites in reach, by coset
    const size_t columns = width_ / 2 + 2;
    std::array<std::array<const Window*, 3>, 2> near{};
    for (int c = 0; c < 2; ++c)
      for (int d = -1; d <= 1; ++d)
        near[static_cast<size_t>(c)][static_cast<size_t>(d + 1)] =
            &windowed(c, middle[static_cast<size_t>(c)] + d);
    std::vector<float> least[2], most[2];
    const auto of_range = static_cast<float>(0.5 * bound_.of_range),
               of_middle = static_cast<float>(0.5 * bound_.of_middle);
    for (size_t y = 0; y < height_; ++y) {
      for (size_t c = 0; c < 2; ++c) {
        least[c].assign(columns, infinity), most[c].assign(columns, -infinity);
        const size_t from = (c == 0 ? (y + 1) / 2 : y / 2) * columns;
        for (const Window* w : near[c])
          for (size_t u = 0; u < columns; ++u) {
            least[c][u] = std::min(least[c][u], w->low[from + u]);
            most[c][u] = std::max(most[c][u], w->high[from + u]);
          }
      }
      for (size_t x = 0; x < width_; ++x) {
        const float l = std::min(least[0][(x + 1) / 2], least[1][x / 2]);
        const float h = std::max(most[0][(x + 1) / 2], most[1][x / 2]);
        const float more = of_range * (h - l) + of_middle * std::fabs(h + l);
        const float all = l == 0 && h == 0 ? 0 : more + rounding * largest_;
        low[y * width_ + x] -= all, high[y * width_ + x] += all;
      }
    }
  }

  void store(int z0, int count, const std::vector<float>& low, const std::vector<float>& high) {
    const size_t layer = width_ * height_;
    for (int by = 0; by < out_.blocks[1]; ++by)
      for (int bx = 0; bx < out_.blocks[0]; ++bx) {
        const int columns = std::min(block_edge, out_.cells[0] - bx * block_edge),
                  rows = std::min(block_edge, out_.cells[1] - by * block_edge);
        const size_t from =
            static_cast<size_t>(by * block_edge) * width_ + static_cast<size_t>(bx * block_edge);
        float least = infinity, most = -infinity;
        const auto each = [&](const auto& body) {
          for (int l = 0; l < count; ++l)
            for (int v = 0; v < rows; ++v)
              for (int u = 0; u < columns; ++u)
                body(static_cast<size_t>((l * block_edge + v) * block_edge + u),
                     from + static_cast<size_t>(l) * layer + static_cast<size_t>(v) * width_ +
                         static_cast<size_t>(u));
        };
        each([&](size_t, size_t at) { least = std::min(least, low[at]), most = std::max(most, high[at]); });
        if (least == 0 && most == 0) continue;
        BlockRanges b;
        b.low = least, b.high = most, b.scale = std::max((most - least) / 254, 1e-30f);
        b.from.fill(255);
        each([&](size_t cell, size_t at) {
          b.from[cell] =
              static_cast<uint8_t>(std::max(std::floor((low[at] - least) / b.scale - 0.01f), 0.0f));
          b.to[cell] =
              static_cast<uint8_t>(std::min(std::ceil((high[at] - least) / b.scale + 0.01f), 255.0f));
        });
        const int bz = z0 / block_edge;
        out_.of_block[static_cast<size_t>((bz * out_.blocks[1] + by) * out_.blocks[0] + bx)] =
            static_cast<int32_t>(out_.ranges.size());
        out_.ranges.push_back(b);
      }
  }

  const Slice& slice_;
  int parts_;
  CellBound bound_;
  SiteArray sites_;
  CellRanges out_;
  size_t width_ = 0, height_ = 0, pitch_ = 0;
  double reach2_ = 0; // planes, squared
  float largest_ = 0;
  std::vector<RowStencil> stencils_;
  std::vector<int> first_, last_;
  std::vector<float> row_[2];
  std::array<std::array<Window, 3>, 2> windows_;
};

} // namespace

CellRanges make_cell_ranges(const Slice& slice, int parts, const CellBound& bound) {
  return Filler(slice, parts, bound).make();
}

} // namespace bccsplat::bench
