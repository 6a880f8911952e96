// SPDX-License-Identifier: Apache-2.0
#include "fit/beyond/end_layers.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "fit/beyond/against_mirrors.h"
#include "fit/kept/packed_block.h"

namespace bccsplat {
namespace {

constexpr int64_t sites_tried = 1 << 17; // of a frame, about
// Bolder predictions keep the source frames better (tests/bench/notes/ends.md), and are taken where they
// predict as well to a decibel.
constexpr double as_good = 1.26;

// Sums positions of a table, each with its factor, into one.
FilterTable summed(const FilterTable& parts, const std::vector<float>& factors) {
  const auto [low, high] = std::minmax_element(parts.first.begin(), parts.first.end());
  FilterTable sum{static_cast<int>(*high - *low) + parts.taps, {*low}, {}};
  sum.weight.resize(sum.taps);
  const size_t taps = parts.taps;
  for (size_t i = 0; i < factors.size(); ++i)
    for (size_t k = 0; k < taps; ++k)
      sum.weight[(parts.first[i] - *low) + k] += factors[i] * parts.weight[i * taps + k];
  return sum;
}

} // namespace

FilterTable layer_table(const Lattice4& lattice, int32_t layer, bool end_known, double widening) {
  std::vector<double> positions{lattice.layer_frame(layer)};
  std::vector<float> factors{1};
  const bool first = layer == 0, last = end_known && layer == lattice.last_layer;
  if (lattice.space.bcc && lattice.lead == mended_plane && (first || last))
    for (const auto& [outside, factor] : against_mirrors) {
      positions.push_back(
          lattice.layer_frame(first ? mended_plane - outside : layer - mended_plane + outside));
      factors.push_back(factor);
    }
  const FilterTable parts = filter_table(widening, positions);
  return factors.size() == 1 ? parts : summed(parts, factors);
}

uint8_t choose_end_level(const std::vector<const FrameSites*>& frames, const Lattice3& lattice,
                         double widening) {
  if (frames.size() < 3) return usual_noise_level;
  NoiseTrial trial(frames.size(), widening);
  std::vector<float> row(static_cast<size_t>(trial.depth()));
  const BrickLayer shape(lattice, 0);
  const Int3 n = shape.dims();
  const auto step = static_cast<int32_t>(
      std::ceil(std::cbrt(static_cast<double>(lattice.sites(0)) / static_cast<double>(sites_tried))));
  for (int32_t z = 0; z < n[2]; z += step)
    for (int32_t y = 0; y < n[1]; y += step)
      for (int32_t x = 0; x < n[0]; x += step) {
        const size_t slot = shape.slot(x / brick_edge, y / brick_edge, z / brick_edge);
        const int site = (z % brick_edge * brick_edge + y % brick_edge) * brick_edge + x % brick_edge;
        for (size_t k = 0; k < row.size(); ++k) {
          const SiteBlock* block = frames[k]->block[0][slot].get();
          row[k] = block ? value_of(*block, site) : 0;
        }
        trial.add(row);
      }
  return trial.best(as_good);
}

EndPredictions::EndPredictions(double widening, int32_t lead) {
  constexpr double older_noise = 3e-5;
  if (lead != mended_plane) of_level_.emplace_back(widening, older_noise);
  for (size_t i = 0; lead == mended_plane && i < end_noises.size(); ++i)
    of_level_.emplace_back(widening, end_noises[i]);
}

std::vector<std::pair<int64_t, float>>
EndPredictions::inside(const FilterTable& table, int64_t n, const std::function<uint8_t(bool last)>& level) {
  std::map<int64_t, double> sum;
  for (int k = 0; k < table.taps; ++k) {
    const int64_t f = table.first[0] + k, beyond = std::max(-f, f - (n - 1));
    const double weight = table.weight[k];
    if (beyond <= 0) {
      sum[f] += weight;
      continue;
    }
    if (weight == 0) continue;
    const std::vector<double>& w = of_level_[level(f > 0)].weights(beyond, n);
    for (size_t i = 0; i < w.size(); ++i) {
      const int64_t inner = i;
      sum[f < 0 ? inner : n - 1 - inner] += weight * w[i];
    }
  }
  std::vector<std::pair<int64_t, float>> list;
  for (const auto& [f, weight] : sum) list.emplace_back(f, static_cast<float>(weight));
  return list;
}

} // namespace bccsplat
