// SPDX-License-Identifier: Apache-2.0
// Rounds a chunk, each site with what its predecessors' errors leave it, and keeps what does not become air.
// Whether coarser units pay is seen from a first rounding in single steps: by how far its codes are from
// their predictions.
#include "formats/bcc4/encode/coefficient_codes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "formats/bcc4/coding/predict.h"
#include "formats/bcc4/encode/fit_weights.h"
#include "formats/bcc4/encode/round_units.h"

namespace bccsplat {
namespace {

// A gap between kept sites costs 9.7 bits (chunk.cpp), a site of air among small codes about 2.
constexpr size_t longest_gap = 4;
// Steps stay below 2^30, far beyond what a float holds exactly.
constexpr int32_t most_steps = 1 << 30;
// The mean error of prediction, in steps, from which a doubled step pays
// (tests/bench/notes/coefficient-codes.md).
constexpr double least_error = 0.6;
// The sites that weights are fitted to for that: of a mean error fewer tell enough.
constexpr uint32_t shift_sample = 1536;

// Keeps holes, sites that are not air, and the gaps between them that are short.
class Keeper {
 public:
  // sites: the shape, holes, and masks of kept sites that are empty.
  explicit Keeper(ChunkSites& sites) : sites_(sites) {}

  // The next row of a layer, in coding order; `units` are of its sites.
  void take_row(size_t layer, size_t row, int width, const int32_t* units, int shift) {
    const auto full = static_cast<uint16_t>((1u << width) - 1);
    unsigned other = 0; // than air
    for (int x = 0; x < width; ++x) other |= static_cast<unsigned>(units[x] != 0) << x;
    if (!sites_.hole.empty()) other |= sites_.hole[layer][row] & full;
    if (other == full) {
      keep_gap();
      sites_.kept[layer][row] = full;
      for (int x = 0; x < width; ++x) sites_.codes.push_back(code_of(units[x], shift));
    } else if (other == 0 && width > static_cast<int>(longest_gap)) {
      gap_ = longest_gap + 1;
    } else {
      for (int x = 0; x < width; ++x)
        if (other >> x & 1)
          keep_gap(), keep({layer, row, x}, code_of(units[x], shift));
        else
          leave_out({layer, row, x});
    }
  }

 private:
  struct Site {
    size_t layer, row;
    int x;
  };
  static uint32_t code_of(int32_t units, int shift) {
    return i32_air + (static_cast<uint32_t>(units) << shift);
  }
  void keep(const Site& s, uint32_t code) {
    uint16_t& row = sites_.kept[s.layer][s.row];
    row = static_cast<uint16_t>(row | 1u << s.x);
    sites_.codes.push_back(code);
  }
  void leave_out(const Site& s) {
    if (gap_ < longest_gap) left_out_[gap_] = s;
    gap_ = std::min(gap_ + 1, longest_gap + 1);
  }
  void keep_gap() {
    for (size_t i = 0; i < gap_ && gap_ <= longest_gap; ++i) keep(left_out_[i], i32_air);
    gap_ = 0;
  }

  ChunkSites& sites_;
  std::array<Site, longest_gap> left_out_{};
  size_t gap_ = longest_gap + 1; // sites since the last that was kept, of those that are too many the least
};

// Rounds all sites that are not 0 and keeps those whose code is not that of air.
class Rounder {
 public:
  Rounder(const ChunkShape& shape, std::span<const Brick* const> bricks, const CoefficientCoding& coding)
      : shape_(shape), bricks_(bricks), coding_(coding), units_(bricks.size()) {}

  [[nodiscard]] CoefficientChunk round(int shift) {
    UnitRounding how{
        .unit = coding_.step * (1 << shift), .most = static_cast<double>(most_steps >> shift), .weights = {}};
    if (shift > 0 || coding_.shape_all)
      for (int m = 0; m < shape_.layers; ++m) how.weights.push_back(taps_of_layer(coding_.shape, shape_, m));
    round_units(shape_, bricks_, how, units_);
    CoefficientChunk chunk{.sites = kept_sites(shift), .shift = shift};
    for (const uint32_t code : chunk.sites.codes)
      if (std::abs(static_cast<int32_t>(code - i32_air)) >= most_steps)
        fail(Code::limit_exceeded, "writer: coefficients of 2^30 and more steps of ", coding_.step,
             "; a range that holds the values has larger steps, and floats have none");
    return chunk;
  }

 private:
  [[nodiscard]] ChunkSites kept_sites(int shift) const {
    ChunkSites sites;
    sites.shape = shape_;
    sites.kept.resize(bricks_.size());
    sites.codes.reserve(shape_.sites());
    for (size_t m = 0; m < bricks_.size(); ++m) {
      if (!bricks_[m] || !bricks_[m]->hole) continue;
      sites.hole.resize(bricks_.size());
      sites.hole[m] = *bricks_[m]->hole;
    }
    Keeper keeper(sites);
    for (size_t m = 0; m < bricks_.size(); ++m)
      for (int z = 0; z < shape_.box[m][2]; ++z)
        for (int y = 0; y < shape_.box[m][1]; ++y) {
          const size_t row = z * brick_edge + y;
          keeper.take_row(m, row, shape_.box[m][0], units_[m].data() + row * brick_edge, shift);
        }
    return sites;
  }

  const ChunkShape& shape_;
  std::span<const Brick* const> bricks_;
  const CoefficientCoding& coding_;
  std::vector<LayerUnits> units_; // those of layers without a brick stay 0
};

// The shift that pays, by the errors of prediction at shift 0.
[[nodiscard]] int choose_shift(ChunkSites sites, const CoefficientCoding& coding) {
  if (sites.codes.empty()) return 0;
  const auto [low, high] = std::minmax_element(sites.codes.begin(), sites.codes.end());
  const ChunkCodes codes = codes_of_chunk(i32_codes, *low, *high, 0);
  for (uint32_t& code : sites.codes) code = codes.of_ordered(code);
  const FittedWeights fitted = fit_weights(sites, codes, shift_sample);
  double sum = 0;
  for (const uint32_t folded : predict(sites, codes, Predictor::fitted, fitted.unchained))
    sum += folded / 2 + (folded & 1);
  const double mean = sum / static_cast<double>(sites.codes.size());
  int shift = 0;
  while (shift < coding.most_shift && mean >= least_error * (1 << shift)) ++shift;
  return shift;
}

template<class Code> void pack(std::span<const uint32_t> ordered, const ChunkCodes& coded, std::byte* to) {
  for (const uint32_t code : ordered) {
    const auto narrow = static_cast<Code>(coded.of_ordered(code));
    std::memcpy(to, &narrow, sizeof narrow);
    to += sizeof narrow;
  }
}

} // namespace

ChunkData packed(const CoefficientChunk& chunk) {
  const ChunkSites& sites = chunk.sites;
  ChunkData data;
  data.shape = sites.shape, data.kept = sites.kept, data.hole = sites.hole;
  uint32_t count = 0;
  for (const BrickMask& mask : sites.kept) {
    data.first.push_back(count);
    for (const uint16_t row : mask) count += std::popcount(row);
  }
  data.first.push_back(count);
  const auto [low, high] = std::minmax_element(sites.codes.begin(), sites.codes.end());
  data.coded = count == 0 ? i32_codes : codes_of_chunk(i32_codes, *low, *high, chunk.shift);
  data.codes.resize(size_t{count} * data.coded.bytes());
  if (data.coded.bytes() == 1)
    pack<uint8_t>(sites.codes, data.coded, data.codes.data());
  else if (data.coded.bytes() == 2)
    pack<uint16_t>(sites.codes, data.coded, data.codes.data());
  else
    pack<uint32_t>(sites.codes, data.coded, data.codes.data());
  return data;
}

CoefficientChunk round_coefficients(const ChunkShape& shape, std::span<const Brick* const> bricks,
                                    const CoefficientCoding& coding) {
  Rounder rounder(shape, bricks, coding);
  CoefficientChunk chunk = rounder.round(0);
  if (coding.most_shift == 0) return chunk;
  const int shift = choose_shift(chunk.sites, coding);
  return shift == 0 ? std::move(chunk) : rounder.round(shift);
}

} // namespace bccsplat
