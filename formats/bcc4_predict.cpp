#include "formats/bcc4_predict.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "base/error.h"
#include "formats/bcc4_predict_rows.h"

namespace bccsplat {
namespace {

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

template<class Stored> void join(const std::byte* planes, size_t count, std::byte* packed) {
  for (size_t i = 0; i < count; ++i) {
    Stored v = 0;
    for (size_t b = 0; b < sizeof v; ++b)
      v = static_cast<Stored>(v | static_cast<Stored>(static_cast<Stored>(planes[b * count + i]) << (8 * b)));
    std::memcpy(packed + i * sizeof v, &v, sizeof v);
  }
}

void join_planes(std::span<const std::byte> planes, uint32_t bytes, std::byte* packed) {
  const size_t count = planes.size() / bytes;
  if (bytes == 1)
    std::copy(planes.begin(), planes.end(), packed);
  else if (bytes == 2)
    join<uint16_t>(planes.data(), count, packed);
  else
    join<uint32_t>(planes.data(), count, packed);
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

// The ridge leaves a weight of 0.
void leave_out_west(Fit& fit, size_t n) {
  for (size_t i = 0; i < n; ++i) fit.a[0][i] = fit.a[i][0] = 0;
  fit.b[0] = 0;
}

} // namespace

std::vector<uint32_t> predict(const ChunkSites& sites, const ChunkCodes& codes, Predictor predictor,
                              std::span<const int16_t> weights) {
  if (predictor == Predictor::none) return sites.codes;
  const ClassWeights w = class_weights(sites.shape, predictor, weights);
  std::vector<uint32_t> residuals(sites.codes.size());
  predict_rows(sites, codes, w, residuals.data());
  return residuals;
}

void unpredict(const ChunkShape& shape, std::span<const BrickMask> kept, const ChunkCodes& codes,
               Predictor predictor, std::span<const int16_t> weights, std::span<const std::byte> planes,
               std::byte* packed) {
  if (predictor == Predictor::none)
    join_planes(planes, codes.bytes(), packed);
  else
    unpredict_rows(shape, kept, codes, class_weights(shape, predictor, weights), planes, packed);
}

size_t fitted_weights(const ChunkShape& shape) {
  const unsigned present = classes_present(shape);
  size_t n = 0;
  for (int c = 0; c < classes; ++c)
    if (present >> c & 1) n += static_cast<size_t>(class_taps(c));
  return n;
}

FittedWeights fit_weights(const ChunkSites& sites, const ChunkCodes& codes) {
  constexpr uint32_t sample = 6144; // sites; more did not make chunks smaller
  const auto every = std::max<uint32_t>(1, static_cast<uint32_t>(sites.codes.size()) / sample);
  std::vector<Fit> fits(classes);
  const uint32_t* code = sites.codes.data();
  uint32_t index = 0;
  walk<int64_t>(sites.shape, sites.kept, [&](const Row<int64_t>& row) {
    unsigned bits = sites.kept[static_cast<size_t>(row.layer)][static_cast<size_t>(row.index)];
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
  FittedWeights weights;
  const unsigned present = classes_present(sites.shape);
  for (int c = 0; c < classes; ++c) {
    if (!(present >> c & 1)) continue;
    const auto n = static_cast<size_t>(class_taps(c));
    const auto append = [&](std::vector<int16_t>& to, Fit fit) {
      const Weights w = fit.rows >= 2 * n ? solve(fit, n) : constant_weights(Predictor::cross, c);
      to.insert(to.end(), w.begin(), w.begin() + static_cast<std::ptrdiff_t>(n));
    };
    Fit& fit = fits[static_cast<size_t>(c)];
    append(weights.chained, fit);
    if (c & 1) leave_out_west(fit, n);
    append(weights.unchained, fit);
  }
  return weights;
}

} // namespace bccsplat
