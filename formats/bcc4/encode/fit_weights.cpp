// SPDX-License-Identifier: Apache-2.0
// Fits the weights of predictor 5 to a chunk by least squares (bcc4.md, section 7): sums products of
// neighbours over a sample of the sites, class by class, and solves the normal equations.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <span>

#include "formats/bcc4/coding/predict.h"
#include "formats/bcc4/coding/predict_walk.h"
#include "formats/bcc4/encode/fit_weights.h"
#include "formats/bcc4/encode/normal_equations.h"
#include "formats/bcc4/encode/tap_rows.h"
#include "points/runs.h"

namespace bccsplat {
namespace {

// The normal equations of one class.
struct Fit {
  size_t rows = 0;
  LeastSquares equations;
};

// Clears what is known about the site at x - 1, so that the ridge makes its weight 0.
void leave_out_west(Fit& fit, size_t n) {
  LeastSquares& e = fit.equations;
  for (size_t i = 0; i < n; ++i) e.a[0][i] = e.a[i][0] = 0;
  e.b[0] = 0;
}

[[nodiscard]] Fit fit_of(const NormalEquations& sums, size_t sites, size_t n) {
  Fit fit;
  fit.rows = sites;
  for (size_t i = 0; i < n; ++i) {
    std::copy_n(sums.sum[i].begin(), i + 1, fit.equations.a[i].begin());
    fit.equations.b[i] = sums.sum[n][i];
  }
  return fit;
}

// Collects sites of one class with their neighbours and sums their products up, of cells of at most two
// bytes.
class NarrowSamples {
 public:
  using Cell = float;
  NarrowSamples(size_t n, const ChunkCodes& codes) : n_(n), rows_(n, codes.bytes() == 1) {}
  void add(const std::array<const float*, max_taps>& taps, const float* own, unsigned chosen) {
    rows_.add(taps, own, chosen);
  }
  [[nodiscard]] Fit fit() { return fit_of(rows_.sums(), rows_.count(), n_); }

 private:
  size_t n_;
  TapRows rows_;
};

// The same of cells of four bytes, 64 sites at a time.
class WideSamples {
 public:
  using Cell = int64_t;
  WideSamples(size_t n, const ChunkCodes&) : n_(n) {}
  void add(const std::array<const int64_t*, max_taps>& taps, const int64_t* own, unsigned chosen) {
    for (; chosen; chosen &= chosen - 1) {
      const int x = std::countr_zero(chosen);
      double* const to = room_.data() + held_ * width;
      for (size_t i = 0; i < n_; ++i) to[i] = static_cast<double>(taps[i][x]);
      to[n_] = static_cast<double>(own[x]);
      ++count_;
      if (++held_ == most) sum_up();
    }
  }
  [[nodiscard]] Fit fit() {
    sum_up();
    return fit_of(equations_, count_, n_);
  }

 private:
  static constexpr size_t width = NormalEquations::columns, most = 64;
  void sum_up() {
    add_samples(equations_, std::span<const double>(room_).first(held_ * width), n_);
    held_ = 0;
  }

  size_t n_;
  NormalEquations equations_;
  std::array<double, most * width> room_{};
  size_t held_ = 0, count_ = 0;
};

// Chooses one in `every` sites. The choice is scattered, as a regular one would meet the same columns in
// every row.
class Choose {
 public:
  explicit Choose(uint32_t every) : most_(UINT32_MAX / every), per_(most_ + 1) {}
  // Bits of the chosen ones among the next sites.
  [[nodiscard]] uint32_t next(int sites) {
    uint32_t bits = 0;
    // A number below 2^16 is a multiple of `every` where its product with 2^32 / every hardly goes beyond a
    // multiple of 2^32 (Lemire, Kaser and Kurz 2019, "Faster remainder by direct computation").
    for (int i = 0; i < sites; ++i, hash_ += 2654435761u)
      bits |= static_cast<uint32_t>((hash_ >> 16) * per_ <= most_) << i;
    return bits;
  }

 private:
  uint32_t most_, per_, hash_ = 0;
};

template<class Samples> FittedWeights fit_weights_of(const ChunkSites& sites, const ChunkCodes& codes) {
  constexpr uint32_t sample = 6144; // sites that are looked at, more or less; more made no chunks smaller
  Choose choose(std::max<uint32_t>(1, static_cast<uint32_t>(sites.codes.size()) / sample));
  using D = typename Samples::Cell;
  std::array<std::unique_ptr<Samples>, classes> samples;
  const unsigned present = classes_present(sites.shape);
  for (int c = 0; c < classes; ++c)
    if (present >> c & 1) samples[c] = std::make_unique<Samples>(static_cast<size_t>(class_taps(c)), codes);
  const uint32_t* code = sites.codes.data();
  const int64_t air = codes.air;
  CellRing<D> ring;
  walk_rows<D>(sites.shape, sites.kept, ring, [&](const Row<D>& row) {
    const unsigned kept = sites.kept[row.layer][row.index];
    for (unsigned bits = kept; bits; bits &= bits - 1)
      row.own[std::countr_zero(bits)] = static_cast<D>(*code++ - air);
    unsigned chosen = choose.next(std::popcount(kept));
    if (kept != full_row) chosen = expand_bits(static_cast<uint16_t>(chosen), static_cast<uint16_t>(kept));
    if (chosen == 0) return;
    std::array<const D*, max_taps> taps;
    gather_taps(row, taps);
    samples[(row.cross ? 1 : 0) | (row.previous ? 2 : 0)]->add(taps, row.own, chosen);
  });
  FittedWeights weights;
  for (int c = 0; c < classes; ++c) {
    if (!(present >> c & 1)) continue;
    const size_t n = class_taps(c);
    const auto append = [&](std::vector<int16_t>& to, const Fit& fit) {
      const Weights w = fit.rows >= 2 * n ? solve(fit.equations, n) : constant_weights(Predictor::cross, c);
      to.insert(to.end(), w.begin(), w.begin() + n);
    };
    Fit fit = samples[c]->fit();
    append(weights.chained, fit);
    if (c & 1) leave_out_west(fit, n);
    append(weights.unchained, fit);
  }
  return weights;
}

} // namespace

FittedWeights fit_weights(const ChunkSites& sites, const ChunkCodes& codes) {
  if (codes.bytes() <= 2) return fit_weights_of<NarrowSamples>(sites, codes);
  return fit_weights_of<WideSamples>(sites, codes);
}

} // namespace bccsplat
