// SPDX-License-Identifier: Apache-2.0
// Rounds a chunk row by row in coding order, each site with what its predecessors' errors leave it, and keeps
// what does not become air. Whether coarser units pay is seen from a first rounding in single steps: by how
// far its codes are from their predictions.
#include "formats/bcc4/coding/coefficient_codes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "formats/bcc4/coding/predict.h"

namespace bccsplat {
namespace {

// A gap between kept sites costs 9.7 bits (chunk.cpp), a site of air among small codes about 2.
constexpr size_t longest_gap = 4;
// The mean error of prediction, in steps, from which a doubled step pays
// (tests/bench/notes/coefficient-codes.md).
constexpr double least_error = 0.6;

// Calls body(x) for the sites of a row in `bits`.
template<class Body> void for_bits(unsigned bits, const Body& body) {
  for (; bits; bits &= bits - 1) body(std::countr_zero(bits));
}

// Rounds all sites that are not 0 and keeps those whose code is not that of air.
class Rounder {
 public:
  Rounder(const ChunkShape& shape, std::span<const Brick* const> bricks, const CoefficientCoding& coding)
      : shape_(shape), bricks_(bricks), coding_(coding), given_(bricks.size()) {
    for (size_t m = 0; m < bricks.size(); ++m)
      if (bricks[m]) find_given(*bricks[m], shape.box[m], given_[m]);
  }

  [[nodiscard]] CoefficientChunk round(int shift) const {
    CoefficientChunk chunk;
    chunk.shift = shift;
    chunk.sites.shape = shape_;
    chunk.sites.kept.resize(bricks_.size());
    take_holes(chunk.sites);
    const double step = coding_.step * (1 << shift);
    // Steps stay within 2^30, far beyond what a float holds exactly.
    const double most = (1 << 30) >> shift;
    const bool shaped = shift > 0 || coding_.shape_all;
    std::vector<uint32_t> codes; // of all given sites
    std::vector<Weights> weights;
    for (int m = 0; m < shape_.layers; ++m) weights.push_back(taps_of_layer(coding_.shape, shape_, m));
    for_rows([&](const Row<double>& row) {
      std::array<const double*, max_taps> taps;
      const size_t n = shaped ? gather_taps(row, taps) : 0;
      const Weights& w = weights[static_cast<size_t>(row.layer)];
      const auto m = static_cast<size_t>(row.layer), r = static_cast<size_t>(row.index);
      const float* values = bricks_[m]->value.data() + r * brick_edge;
      for_bits(given_[m][r], [&](int x) {
        double wanted = 0;
        for (size_t i = 0; i < n; ++i) wanted += w[i] * taps[i][x];
        wanted = wanted / (1 << fraction_bits) + static_cast<double>(values[x]);
        const double units = std::clamp(std::floor(wanted / step + 0.5), -most, most);
        row.own[x] = units * step - wanted;
        codes.push_back(i32_air + (static_cast<uint32_t>(static_cast<int32_t>(units)) << shift));
      });
    });
    keep(chunk.sites, codes);
    return chunk;
  }

 private:
  // Calls body for the rows that have given sites, in coding order, with cells for the errors of their sites.
  // Beyond the chunk there are none: other chunks are rounded on their own.
  template<class Body> void for_rows(const Body& body) const {
    std::vector<double> cells(3 * layer_cells);
    const auto layer_at = [&](int m) { return cells.data() + (m % 3) * layer_cells; };
    for (int m = 0; m < shape_.layers; ++m) {
      std::fill_n(layer_at(m), layer_cells, 0.0);
      const BrickMask& given = given_[static_cast<size_t>(m)];
      const std::ptrdiff_t lowest = shape_.coset(m) == 1 ? 0 : -1 - stride_y - stride_z;
      for (int r = 0; r < brick_rows; ++r) {
        if (given[static_cast<size_t>(r)] == 0) continue;
        const std::ptrdiff_t at = (r / brick_edge + 1) * stride_z + (r % brick_edge + 1) * stride_y + 1;
        body(Row<double>{m, r, shape_.box[static_cast<size_t>(m)][0], layer_at(m) + at,
                         shape_.has_cross(m) ? layer_at(m - 1) + at + lowest : nullptr,
                         shape_.has_previous(m) ? layer_at(m - shape_.period) + at : nullptr});
      }
    }
  }
  static void find_given(const Brick& brick, const Int3& box, BrickMask& given) {
    for (size_t r = 0; r < brick_rows; ++r)
      for (size_t x = 0; x < static_cast<size_t>(box[0]); ++x)
        if (brick.value[r * brick_edge + x] != 0) given[r] = static_cast<uint16_t>(given[r] | 1u << x);
  }
  void take_holes(ChunkSites& sites) const {
    for (size_t m = 0; m < bricks_.size(); ++m) {
      if (!bricks_[m] || !bricks_[m]->hole) continue;
      sites.hole.resize(bricks_.size());
      sites.hole[m] = *bricks_[m]->hole;
    }
  }
  // Keeps holes, sites that are not air, and the gaps between them that are short.
  void keep(ChunkSites& sites, const std::vector<uint32_t>& codes) const {
    struct Site {
      size_t layer, row;
      int x;
    };
    std::vector<Site> gap;
    bool after_kept = false;
    size_t next = 0;
    const auto keep_one = [&](const Site& s, uint32_t code) {
      uint16_t& row = sites.kept[s.layer][s.row];
      row = static_cast<uint16_t>(row | 1u << s.x);
      sites.codes.push_back(code);
    };
    for (size_t m = 0; m < bricks_.size(); ++m)
      for (int z = 0; z < shape_.box[m][2]; ++z)
        for (int y = 0; y < shape_.box[m][1]; ++y)
          for (int x = 0; x < shape_.box[m][0]; ++x) {
            const Site site{m, static_cast<size_t>(z * brick_edge + y), x};
            const uint32_t code = given_[m][site.row] >> x & 1 ? codes[next++] : i32_air;
            const bool hole = !sites.hole.empty() && (sites.hole[m][site.row] >> x & 1);
            if (code == i32_air && !hole) {
              if (after_kept && gap.size() <= longest_gap) gap.push_back(site);
              continue;
            }
            if (gap.size() <= longest_gap)
              for (const Site& s : gap) keep_one(s, i32_air);
            gap.clear();
            keep_one(site, code);
            after_kept = true;
          }
  }

  const ChunkShape& shape_;
  std::span<const Brick* const> bricks_;
  const CoefficientCoding& coding_;
  std::vector<BrickMask> given_;
};

// The shift that pays, by the errors of prediction at shift 0.
[[nodiscard]] int choose_shift(ChunkSites sites, const CoefficientCoding& coding) {
  if (sites.codes.empty()) return 0;
  const auto [low, high] = std::minmax_element(sites.codes.begin(), sites.codes.end());
  const ChunkCodes codes = codes_of_chunk(i32_codes, *low, *high, 0);
  for (uint32_t& code : sites.codes) code = codes.of_ordered(code);
  const FittedWeights fitted = fit_weights(sites, codes);
  double sum = 0;
  for (const uint32_t folded : predict(sites, codes, Predictor::fitted, fitted.unchained))
    sum += static_cast<double>(folded / 2 + (folded & 1));
  const double mean = sum / static_cast<double>(sites.codes.size());
  int shift = 0;
  while (shift < coding.most_shift && mean >= least_error * (1 << shift)) ++shift;
  return shift;
}

} // namespace

CoefficientChunk round_coefficients(const ChunkShape& shape, std::span<const Brick* const> bricks,
                                    const CoefficientCoding& coding) {
  const Rounder rounder(shape, bricks, coding);
  CoefficientChunk chunk = rounder.round(0);
  if (coding.most_shift == 0) return chunk;
  const int shift = choose_shift(chunk.sites, coding);
  return shift == 0 ? std::move(chunk) : rounder.round(shift);
}

} // namespace bccsplat
