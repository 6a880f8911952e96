// SPDX-License-Identifier: Apache-2.0
// Cosines, the principal components of frames by Jacobi rotations, and the change to either.
#include "formats/bcc4/wavelet/time_basis.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "formats/bcc4/wavelet/layer_sums.h"

namespace bccsplat {
namespace {

int16_t rounded(double v) { return static_cast<int16_t>(std::lround(v * basis_unit)); }

// Makes each layer of a slab the sum of all, in place, some samples at a time. These are copied side by side
// first: layers are as many bytes apart as makes caches hold few of them at once.
void change_basis(int layers, std::span<float> slab, const std::vector<float>& weights) {
  constexpr size_t block = 256;
  const size_t samples = slab.size() / layers;
  std::vector<float> in(block * layers);
  std::vector<WeighedLayer> sum(layers);
  for (size_t first = 0; first < samples; first += block) {
    const size_t n = std::min(block, samples - first);
    for (int k = 0; k < layers; ++k) std::copy_n(slab.data() + k * samples + first, n, in.data() + k * block);
    for (int to = 0; to < layers; ++to) {
      for (int k = 0; k < layers; ++k) sum[k] = {in.data() + k * block, weights[to * layers + k]};
      sum_layers(sum, 0, n, slab.data() + to * samples + first);
    }
  }
}

// What leads to the layers that rows B of nearly an orthogonal matrix make frames of: one step of Newton's
// from them, 2 B - B B^T B.
std::vector<float> inverse_of(int n, const std::vector<float>& rows) {
  std::vector<float> inverse;
  for (int k = 0; k < n; ++k) {
    std::vector<double> row(rows.begin() + k * n, rows.begin() + (k + 1) * n);
    for (double& v : row) v *= 2;
    for (int j = 0; j < n; ++j) {
      double product = 0;
      for (int t = 0; t < n; ++t) product += double{rows[k * n + t]} * rows[j * n + t];
      for (int t = 0; t < n; ++t) row[t] -= product * rows[j * n + t];
    }
    inverse.insert(inverse.end(), row.begin(), row.end());
  }
  return inverse;
}

} // namespace

TimeBasis cosine_basis(int frames) {
  TimeBasis basis{frames, std::vector<int16_t>(size_t(frames) * frames)};
  for (int k = 0; k < frames; ++k)
    for (int t = 0; t < frames; ++t)
      basis.rows[k * frames + t] =
          rounded(std::sqrt((k ? 2.0 : 1.0) / frames) * std::cos(std::numbers::pi * k * (t + .5) / frames));
  return basis;
}

void to_layers(const TimeBasis& basis, std::span<float> slab, bool exactly) {
  std::vector<float> weights;
  for (int layer = 0; layer < basis.frames; ++layer)
    for (int frame = 0; frame < basis.frames; ++frame) weights.push_back(basis.weight(layer, frame));
  change_basis(basis.frames, slab, exactly ? inverse_of(basis.frames, weights) : weights);
}

} // namespace bccsplat
