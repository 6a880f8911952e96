// SPDX-License-Identifier: Apache-2.0
// Looks for the middle of a box in the next frame, at every distance in whole voxels that the box has room
// for: the least sum of squared differences wins, if it explains most of what changed.
#include "choose/motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace bccsplat::series {
namespace {

constexpr size_t kPairs = 24;       // of frames, those that differ most
constexpr size_t kFarthest = 8;     // voxels along an axis
constexpr size_t kLeast = 4;        // samples of the middle along an axis that has more
constexpr double kExplained = 0.25; // what may be left of the differences

// Two frames of a box, one after the other.
struct Pair {
  const SampleStretch* stretch = nullptr;
  const float *now = nullptr, *next = nullptr;
  std::array<size_t, 3> room{}, middle{}; // voxels to either side, and in between
  double difference = 0;                  // of the middle where it stands

  // Sums the squared differences of the middle and what is (dx, dy, dz) from it in the next frame; stops
  // where that is `most`.
  [[nodiscard]] double at(int dx, int dy, int dz, double most) const {
    const auto& d = stretch->box.dims;
    double sum = 0;
    for (size_t z = 0; z < middle[2]; ++z) {
      for (size_t y = 0; y < middle[1]; ++y) {
        const size_t from = ((z + room[2]) * d[1] + y + room[1]) * d[0] + room[0];
        const auto to = static_cast<size_t>(static_cast<std::ptrdiff_t>(from) + dx +
                                            static_cast<std::ptrdiff_t>(d[0]) *
                                                (dy + static_cast<std::ptrdiff_t>(d[1]) * dz));
        for (size_t x = 0; x < middle[0]; ++x) {
          const double off = static_cast<double>(next[to + x]) - static_cast<double>(now[from + x]);
          if (std::isfinite(off)) sum += off * off;
        }
      }
      if (sum >= most) break;
    }
    return sum;
  }
};

std::vector<Pair> pairs_of(const SampleStretch& s) {
  std::vector<Pair> pairs;
  const size_t size = s.box.dims[0] * s.box.dims[1] * s.box.dims[2];
  for (const std::vector<float>& values : s.values)
    for (uint64_t f = 0; f + 1 < s.frames; f += std::max<uint64_t>(1, s.frames / 4)) {
      Pair pair;
      pair.stretch = &s;
      pair.now = values.data() + f * size, pair.next = pair.now + size;
      for (size_t a = 0; a < 3; ++a) {
        const size_t n = s.box.dims[a];
        pair.room[a] = n > kLeast ? std::min(kFarthest, (n - kLeast) / 2) : 0;
        pair.middle[a] = n - 2 * pair.room[a];
      }
      pair.difference = pair.at(0, 0, 0, HUGE_VAL);
      if (pair.difference > 0) pairs.push_back(pair);
    }
  return pairs;
}

// How far the middle went; none where it is not found again, or perhaps lies beyond the box.
std::optional<double> distance_of(const Pair& pair) {
  double least = pair.difference;
  std::array<int, 3> best{};
  const auto room = [&](size_t a) { return static_cast<int>(pair.room[a]); };
  for (int dz = -room(2); dz <= room(2); ++dz)
    for (int dy = -room(1); dy <= room(1); ++dy)
      for (int dx = -room(0); dx <= room(0); ++dx)
        if (const double sum = pair.at(dx, dy, dz, least); sum < least) least = sum, best = {dx, dy, dz};
  if (least > kExplained * pair.difference) return std::nullopt;
  return std::sqrt(best[0] * best[0] + best[1] * best[1] + best[2] * best[2]);
}

} // namespace

std::optional<double> voxels_a_frame(const SeriesSample& sample) {
  std::vector<Pair> pairs;
  for (const SampleStretch& s : sample.stretches)
    for (const Pair& pair : pairs_of(s)) pairs.push_back(pair);
  std::sort(pairs.begin(), pairs.end(),
            [](const Pair& a, const Pair& b) { return a.difference > b.difference; });
  if (pairs.size() > kPairs) pairs.resize(kPairs);
  std::vector<double> found;
  for (const Pair& pair : pairs)
    if (const auto distance = distance_of(pair)) found.push_back(*distance);
  if (found.empty() || 2 * found.size() < pairs.size()) return std::nullopt;
  std::sort(found.begin(), found.end());
  return found[found.size() / 2];
}

} // namespace bccsplat::series
