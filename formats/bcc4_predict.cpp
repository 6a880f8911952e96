#include "formats/bcc4_predict.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "base/error.h"

namespace bccsplat {
namespace {

// A layer of cells with a border of one: cell (x, y, z) is code minus air, x fastest, 0 where not kept.
constexpr int stride_y = 18, stride_z = 18 * 18, layer_cells = 18 * 18 * 18;
constexpr int fraction_bits = 12; // of weights

constexpr int own_taps = 10, cross_taps = 8, previous_taps = 7,
              max_taps = own_taps + cross_taps + previous_taps;
constexpr std::array<int, own_taps> own_offset = {-1,
                                                  -stride_y,
                                                  -stride_z,
                                                  -1 - stride_y,
                                                  -1 - stride_z,
                                                  -stride_y - stride_z,
                                                  -1 - stride_y - stride_z,
                                                  1 - stride_y,
                                                  1 - stride_z,
                                                  stride_y - stride_z};
constexpr std::array<int, previous_taps> previous_offset = {0,        -1,        1,       -stride_y,
                                                            stride_y, -stride_z, stride_z};

// Neighbours that exist decide which weights a layer uses: bit 0 cross, bit 1 previous.
constexpr int classes = 4;
[[nodiscard]] int layer_class(const ChunkShape& shape, int layer) {
  return (shape.has_cross(layer) ? 1 : 0) | (shape.has_previous(layer) ? 2 : 0);
}
[[nodiscard]] int class_taps(int c) {
  return own_taps + (c & 1 ? cross_taps : 0) + (c & 2 ? previous_taps : 0);
}

[[nodiscard]] unsigned classes_present(const ChunkShape& shape) {
  unsigned present = 0;
  for (int m = 0; m < shape.layers; ++m)
    if (!shape.empty(m)) present |= 1u << layer_class(shape, m);
  return present;
}

// Weights of one class in tap order: own, cross, previous; taps a class lacks are left out.
using Weights = std::array<int16_t, max_taps>;
using ClassWeights = std::array<Weights, classes>;

[[nodiscard]] Weights constant_weights(Predictor predictor, int c) {
  Weights w{};
  const bool cross = c & 1, previous = c & 2;
  const size_t previous_at = own_taps + (cross ? cross_taps : 0);
  const auto use_cross = [&] { std::fill_n(w.begin() + own_taps, cross_taps, int16_t{512}); };
  switch (predictor) {
  case Predictor::lorenzo:
    w = {4096, 4096, 4096, -4096, -4096, -4096, 4096};
    break;
  case Predictor::previous:
    if (previous)
      w[previous_at] = 4096;
    else if (cross)
      use_cross();
    else
      w[0] = 4096;
    break;
  case Predictor::cross:
    if (cross)
      use_cross();
    else if (previous)
      w[previous_at] = 4096;
    else
      w[0] = 4096;
    break;
  default:
    w[0] = 4096;
    break;
  }
  return w;
}

[[nodiscard]] ClassWeights class_weights(const ChunkShape& shape, Predictor predictor,
                                         std::span<const int16_t> fitted) {
  ClassWeights all{};
  const unsigned present = classes_present(shape);
  for (int c = 0; c < classes; ++c) {
    auto& w = all[static_cast<size_t>(c)];
    if (predictor != Predictor::fitted) {
      w = constant_weights(predictor, c);
    } else if (present >> c & 1) {
      const auto n = static_cast<size_t>(class_taps(c));
      std::copy_n(fitted.begin(), n, w.begin());
      fitted = fitted.subspan(n);
      int sum = 0;
      for (const int16_t v : w) sum += std::abs(int{v});
      // Keeps 32-bit sums from overflowing.
      if (sum > INT16_MAX)
        fail(Code::corrupt, "chunk: prediction weights sum to ", sum, ", more than ", INT16_MAX);
    }
  }
  return all;
}

// The cells a row of sites is predicted from; each pointer stands at the cell of its first site.
template<class D> struct Row {
  int layer, index, width; // index = z*16 + y
  D* own;
  const D* cross; // at the lowest of the 8 neighbours; null: none
  const D* previous;
};

// The cells around the sites of a layer, from the layer before.
template<class D> void copy_border(D* to, const D* from, const Int3& n) {
  const auto [nx, ny, nz] = n;
  const auto copy = [&](std::ptrdiff_t at, int count) { std::copy_n(from + at, count, to + at); };
  copy(0, stride_z);
  copy((nz + 1) * stride_z, stride_z);
  for (int z = 1; z <= nz; ++z) {
    copy(z * stride_z, stride_y);
    copy(z * stride_z + (ny + 1) * stride_y, stride_y);
    for (int y = 1; y <= ny; ++y) {
      copy(z * stride_z + y * stride_y, 1);
      copy(z * stride_z + y * stride_y + nx + 1, 1);
    }
  }
}

// Visits the rows of a chunk in coding order and keeps the borders. While a layer is under way its border is
// that of the layer before, or without one repeats what is known so far; afterwards it repeats the nearest
// cell. `body` fills the sites of the row.
template<class D, class Body> void walk(const ChunkShape& shape, Body&& body) {
  std::vector<D> ring(3 * layer_cells);
  const auto layer_at = [&](int m) { return ring.data() + (m % 3) * layer_cells; };
  const auto copy_row = [](D* to, const D* from) { std::copy_n(from, stride_y, to); };
  for (int m = 0; m < shape.layers; ++m) {
    D* const layer = layer_at(m);
    std::fill_n(layer, layer_cells, D{0});
    if (shape.empty(m)) continue;
    const auto [nx, ny, nz] = shape.box[static_cast<size_t>(m)];
    const D* previous = shape.has_previous(m) ? layer_at(m - shape.period) : nullptr;
    const D* cross = shape.has_cross(m) ? layer_at(m - 1) : nullptr;
    const D* before = previous ? previous : cross;
    if (before) copy_border(layer, before, shape.box[static_cast<size_t>(m)]);
    const std::ptrdiff_t lowest = shape.coset(m) == 1 ? 0 : -1 - stride_y - stride_z;
    for (int z = 0; z < nz; ++z) {
      D* const plane = layer + (z + 1) * stride_z;
      if (!before && z > 0) copy_row(plane, plane - stride_z + stride_y);
      for (int y = 0; y < ny; ++y) {
        D* const row = plane + (y + 1) * stride_y;
        if (!before) row[0] = row[1 - stride_y];
        const std::ptrdiff_t at = row + 1 - layer;
        body(Row<D>{m, z * brick_edge + y, nx, row + 1, cross ? cross + at + lowest : nullptr,
                    previous ? previous + at : nullptr});
        row[nx + 1] = row[nx];
      }
      copy_row(plane + (ny + 1) * stride_y, plane + ny * stride_y);
    }
    for (int z = 0; z < nz; ++z) {
      D* const plane = layer + (z + 1) * stride_z;
      for (int y = 0; y < ny; ++y) plane[(y + 1) * stride_y] = plane[(y + 1) * stride_y + 1];
      copy_row(plane, plane + stride_y);
      copy_row(plane + (ny + 1) * stride_y, plane + ny * stride_y);
    }
    std::copy_n(layer + stride_z, stride_z, layer);
    std::copy_n(layer + nz * stride_z, stride_z, layer + (nz + 1) * stride_z);
  }
}

// Taps of a class without the first (x - 1), as pointers into the row.
template<class D> size_t gather_taps(const Row<D>& row, std::array<const D*, max_taps>& taps) {
  size_t n = 0;
  for (const int o : own_offset) taps[n++] = row.own + o;
  if (row.cross)
    for (int i = 0; i < cross_taps; ++i)
      taps[n++] = row.cross + (i & 1) + (i >> 1 & 1) * stride_y + (i >> 2) * stride_z;
  if (row.previous)
    for (const int o : previous_offset) taps[n++] = row.previous + o;
  return n;
}

template<class D> class RowSums {
 public:
  explicit RowSums(const ClassWeights& weights) : weights_(weights) {}
  // Weighted sums of all taps but x - 1: nothing of the row itself is read.
  void start(const Row<D>& row) {
    std::array<const D*, max_taps> taps;
    const size_t n = gather_taps(row, taps);
    const Weights& w = weights_[static_cast<size_t>((row.cross ? 1 : 0) | (row.previous ? 2 : 0))];
    west_ = w[0];
    std::array<D, brick_edge> sum; // local: the compiler sees that cells do not overlap it
    sum.fill(D{1} << (fraction_bits - 1));
    for (size_t t = 1; t < n; ++t)
      if (w[t] != 0) add(sum, w[t], taps[t]);
    sum_ = sum;
  }
  // The same with x - 1: the cells of the row are known.
  void start_known(const Row<D>& row) {
    start(row);
    if (west_ != 0) add(sum_, west_, row.own - 1);
  }
  [[nodiscard]] D with_west(size_t x, D west) const { return (sum_[x] + west_ * west) >> fraction_bits; }
  [[nodiscard]] D known(size_t x) const { return sum_[x] >> fraction_bits; }

 private:
  static void add(std::array<D, brick_edge>& sum, D weight, const D* cells) {
    std::array<D, brick_edge> c;
    std::copy_n(cells, brick_edge, c.begin());
    for (size_t x = 0; x < brick_edge; ++x) sum[x] += weight * c[x];
  }

  const ClassWeights& weights_;
  std::array<D, brick_edge> sum_{};
  D west_ = 0;
};

[[nodiscard]] uint32_t fold(uint32_t difference, uint32_t mask) {
  const uint32_t d = difference & mask;
  return (d > mask >> 1 ? 2 * (mask - d) + 1 : 2 * d) & mask;
}
[[nodiscard]] uint32_t unfold(uint32_t f, uint32_t mask) { return f & 1 ? mask - (f >> 1) : f >> 1; }

// The code predicted, from a sum relative to air. Sums stay far from the ends of D.
template<class D> [[nodiscard]] uint32_t clamp_code(D relative, D air, D mask) {
  return static_cast<uint32_t>(std::clamp<D>(relative + air, 0, mask));
}

template<class D>
std::vector<uint32_t> predict_as(const ChunkSites& sites, const ChunkCodes& codes,
                                 const ClassWeights& weights) {
  std::vector<uint32_t> residuals(sites.codes.size());
  uint32_t* out = residuals.data();
  const uint32_t* code = sites.codes.data();
  const uint32_t mask = codes.mask();
  const D air = codes.air, top = mask;
  RowSums<D> sums(weights);
  walk<D>(sites.shape, [&](const Row<D>& row) {
    const unsigned kept = sites.kept[static_cast<size_t>(row.layer)][static_cast<size_t>(row.index)];
    if (kept == 0) return;
    for (unsigned bits = kept; bits; bits &= bits - 1)
      row.own[std::countr_zero(bits)] = static_cast<D>(*code++) - air;
    sums.start_known(row);
    std::array<uint32_t, brick_edge> folded;
    for (size_t x = 0; x < brick_edge; ++x)
      folded[x] = fold(static_cast<uint32_t>(row.own[x] + air) - clamp_code(sums.known(x), air, top), mask);
    if (kept == 0xffff)
      out = std::copy(folded.begin(), folded.end(), out);
    else
      for (unsigned bits = kept; bits; bits &= bits - 1)
        *out++ = folded[static_cast<size_t>(std::countr_zero(bits))];
  });
  return residuals;
}

template<class D>
void unpredict_as(ChunkSites& sites, const ChunkCodes& codes, const ClassWeights& weights,
                  std::span<const uint32_t> residuals) {
  sites.codes.resize(residuals.size());
  uint32_t* code = sites.codes.data();
  const uint32_t* residual = residuals.data();
  const uint32_t mask = codes.mask();
  const D air = codes.air, top = mask;
  RowSums<D> sums(weights);
  walk<D>(sites.shape, [&](const Row<D>& row) {
    const unsigned kept = sites.kept[static_cast<size_t>(row.layer)][static_cast<size_t>(row.index)];
    if (kept == 0) return;
    sums.start(row);
    const auto next = [&](size_t x, D west) {
      *code = (clamp_code(sums.with_west(x, west), air, top) + unfold(*residual++, mask)) & mask;
      return row.own[x] = static_cast<D>(*code++) - air;
    };
    if (kept == 0xffff) {
      D west = row.own[-1];
      for (size_t x = 0; x < brick_edge; ++x) west = next(x, west);
    } else {
      for (unsigned bits = kept; bits; bits &= bits - 1) {
        const auto x = static_cast<size_t>(std::countr_zero(bits));
        next(x, row.own[static_cast<std::ptrdiff_t>(x) - 1]);
      }
    }
  });
}

// Normal equations of one class.
struct Fit {
  size_t rows = 0;
  std::array<std::array<double, max_taps>, max_taps> a{};
  std::array<double, max_taps> b{};
};

// Solves by Cholesky with a ridge that shrinks weights the sample does not determine. Returns weights in
// 1/4096.
[[nodiscard]] Weights solve(Fit& fit, size_t n) {
  for (size_t i = 0; i < n; ++i) fit.a[i][i] += 1e-4 * fit.a[i][i] + 1;
  for (size_t j = 0; j < n; ++j) {
    for (size_t k = 0; k < j; ++k) fit.a[j][j] -= fit.a[j][k] * fit.a[j][k];
    fit.a[j][j] = std::sqrt(std::max(fit.a[j][j], 1e-300));
    for (size_t i = j + 1; i < n; ++i) {
      for (size_t k = 0; k < j; ++k) fit.a[i][j] -= fit.a[i][k] * fit.a[j][k];
      fit.a[i][j] /= fit.a[j][j];
    }
  }
  std::array<double, max_taps> w = fit.b;
  for (size_t i = 0; i < n; ++i) {
    for (size_t k = 0; k < i; ++k) w[i] -= fit.a[i][k] * w[k];
    w[i] /= fit.a[i][i];
  }
  for (size_t i = n; i-- > 0;) {
    for (size_t k = i + 1; k < n; ++k) w[i] -= fit.a[k][i] * w[k];
    w[i] /= fit.a[i][i];
  }
  constexpr double one = 1 << fraction_bits;
  double sum = 0;
  for (size_t i = 0; i < n; ++i) sum += std::fabs(w[i]) * one + 1;
  const double scale = std::min(one, one * INT16_MAX / sum);
  Weights q{};
  for (size_t i = 0; i < n; ++i)
    q[i] = static_cast<int16_t>(
        std::clamp(std::floor(w[i] * scale + 0.5), -double{INT16_MAX}, double{INT16_MAX}));
  return q;
}

} // namespace

std::vector<uint32_t> predict(const ChunkSites& sites, const ChunkCodes& codes, Predictor predictor,
                              std::span<const int16_t> weights) {
  if (predictor == Predictor::none) return sites.codes;
  const ClassWeights w = class_weights(sites.shape, predictor, weights);
  return codes.type == ValueType::f32 ? predict_as<int64_t>(sites, codes, w)
                                      : predict_as<int32_t>(sites, codes, w);
}

void unpredict(ChunkSites& sites, const ChunkCodes& codes, Predictor predictor,
               std::span<const int16_t> weights, std::span<const uint32_t> residuals) {
  if (predictor == Predictor::none) {
    sites.codes.assign(residuals.begin(), residuals.end());
    return;
  }
  const ClassWeights w = class_weights(sites.shape, predictor, weights);
  if (codes.type == ValueType::f32)
    unpredict_as<int64_t>(sites, codes, w, residuals);
  else
    unpredict_as<int32_t>(sites, codes, w, residuals);
}

size_t fitted_weights(const ChunkShape& shape) {
  const unsigned present = classes_present(shape);
  size_t n = 0;
  for (int c = 0; c < classes; ++c)
    if (present >> c & 1) n += static_cast<size_t>(class_taps(c));
  return n;
}

std::vector<int16_t> fit_weights(const ChunkSites& sites, const ChunkCodes& codes) {
  constexpr uint32_t sample = 6144; // sites; more did not make chunks smaller
  const auto every = std::max<uint32_t>(1, static_cast<uint32_t>(sites.codes.size()) / sample);
  std::vector<Fit> fits(classes);
  const uint32_t* code = sites.codes.data();
  uint32_t index = 0;
  walk<int64_t>(sites.shape, [&](const Row<int64_t>& row) {
    unsigned bits = sites.kept[static_cast<size_t>(row.layer)][static_cast<size_t>(row.index)];
    if (bits == 0) return;
    std::array<const int64_t*, max_taps> taps;
    const size_t n = gather_taps(row, taps);
    Fit& fit = fits[static_cast<size_t>((row.cross ? 1 : 0) | (row.previous ? 2 : 0))];
    for (; bits; bits &= bits - 1, ++code, ++index) {
      const int x = std::countr_zero(bits);
      const int64_t value = int64_t{*code} - codes.air;
      // A scattered choice: a regular one would meet the same columns in every row.
      if ((index * 2654435761u >> 16) % every == 0) {
        std::array<double, max_taps> v;
        for (size_t i = 0; i < n; ++i) v[i] = static_cast<double>(taps[i][x]);
        for (size_t i = 0; i < n; ++i) {
          for (size_t j = 0; j <= i; ++j) fit.a[i][j] += v[i] * v[j];
          fit.b[i] += v[i] * static_cast<double>(value);
        }
        ++fit.rows;
      }
      row.own[x] = value;
    }
  });
  std::vector<int16_t> weights;
  const unsigned present = classes_present(sites.shape);
  for (int c = 0; c < classes; ++c) {
    if (!(present >> c & 1)) continue;
    const auto n = static_cast<size_t>(class_taps(c));
    Fit& fit = fits[static_cast<size_t>(c)];
    const Weights w = fit.rows >= 2 * n ? solve(fit, n) : constant_weights(Predictor::cross, c);
    weights.insert(weights.end(), w.begin(), w.begin() + static_cast<std::ptrdiff_t>(n));
  }
  return weights;
}

} // namespace bccsplat
