// SPDX-License-Identifier: Apache-2.0
// Flags of blocks of air, flags of holes, then corrections in whole steps of twice the bound, each with what
// its neighbours are as context. Coder and decoder are one walk over a box.
#include "tests/bench/coder/details.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "tests/bench/coder/binary_coder.h"
#include "tests/bench/coder/bit_models.h"

namespace bccsplat::bench {
namespace {

constexpr int air_edge = 4;
constexpr int details_learn = 255;

// One value for each sample of a box, 0 outside.
template<class T> class BoxValues {
 public:
  BoxValues(const std::array<int, 3>& size, int frames)
      : n_(size), values_(size_t(frames) * size[0] * size[1] * size[2]) {}
  [[nodiscard]] T at(int t, int z, int y, int x) const {
    return t < 0 || z < 0 || y < 0 || x < 0 ? T{} : values_[index(t, z, y, x)];
  }
  T& set(int t, int z, int y, int x) { return values_[index(t, z, y, x)]; }

 private:
  [[nodiscard]] size_t index(int t, int z, int y, int x) const {
    return ((size_t(t) * n_[2] + z) * n_[1] + y) * n_[0] + x;
  }
  std::array<int, 3> n_;
  std::vector<T> values_;
};

// Calls body(z, y, x) for each block of air's edge.
template<class Body> void for_blocks(const DetailBox& box, const Body& body) {
  for (int z = 0; z * air_edge < box.size[2]; ++z)
    for (int y = 0; y * air_edge < box.size[1]; ++y)
      for (int x = 0; x * air_edge < box.size[0]; ++x) body(z, y, x);
}

// Calls body(first sample of a run, samples in it) for the rows of a block in all frames.
template<class Body> void for_rows(const DetailBox& box, int bz, int by, int bx, const Body& body) {
  const int x = bx * air_edge, width = std::min(air_edge, box.size[0] - x);
  for (int t = 0; t < box.frames; ++t)
    for (int z = bz * air_edge; z < std::min((bz + 1) * air_edge, box.size[2]); ++z)
      for (int y = by * air_edge; y < std::min((by + 1) * air_edge, box.size[1]); ++y)
        body(box.row(t, z, y) + x, width);
}

bool is_air(const DetailBox& box, float air, std::span<const float> source, int bz, int by, int bx) {
  bool all = true;
  for_rows(box, bz, by, bx, [&](size_t first, int width) {
    for (int i = 0; i < width; ++i) all &= source[first + i] == air;
  });
  return all;
}

// What the encoder tells of a sample; the decoder has none of it.
struct Facts {
  std::span<const float> source, restored;
  float step = 0;
  [[nodiscard]] int correction(size_t i, float bound) const {
    const float off = source[i] - restored[i];
    return std::fabs(off) <= bound ? 0 : static_cast<int>(std::lround(off / step));
  }
};

template<class Coder> class DetailCoder {
 public:
  DetailCoder(Coder& coder, const DetailBox& box, const DetailRule& rule)
      : coder_(coder), box_(box), rule_(rule) {}

  // Calls body(z, y, x) for the blocks that are air.
  template<class Known, class Body> void air(const Known& known, const Body& body) {
    BoxValues<uint8_t> flags(box_.size, 1);
    for_blocks(box_, [&](int z, int y, int x) {
      const int context =
          flags.at(0, z, y, x - 1) + 2 * flags.at(0, z, y - 1, x) + 4 * flags.at(0, z - 1, y, x);
      if (!bit(known(z, y, x), air_[context])) return;
      flags.set(0, z, y, x) = 1;
      body(z, y, x);
    });
  }
  // Calls body(index) for each hole.
  template<class Known, class Body> void holes(const Known& known, const Body& body) {
    BoxValues<uint8_t> flags(box_.size, box_.frames);
    for_samples([&](int t, int z, int y, int x, size_t i) {
      const int context = flags.at(t, z, y, x - 1) + 2 * flags.at(t, z, y - 1, x) +
                          4 * flags.at(t, z - 1, y, x) + 8 * flags.at(t - 1, z, y, x);
      if (!bit(known(i), holes_[context])) return;
      flags.set(t, z, y, x) = 1;
      body(i);
    });
  }
  // Calls body(index, steps) for each sample that is corrected.
  template<class Known, class Body> void corrections(const Known& known, const Body& body) {
    BoxValues<uint8_t> flags(box_.size, box_.frames);
    for_samples([&](int t, int z, int y, int x, size_t i) {
      const int context = flags.at(t, z, y, x - 1) + flags.at(t, z, y - 1, x) + flags.at(t, z - 1, y, x) +
                          flags.at(t, z, y - 1, x - 1) + 5 * flags.at(t - 1, z, y, x) +
                          10 * (flags.at(t - 1, z, y - 1, x) | flags.at(t - 1, z, y, x - 1));
      const int steps = correction(known(i), corrected_[context]);
      if (steps == 0) return;
      flags.set(t, z, y, x) = 1;
      body(i, steps);
    });
  }

 private:
  bool bit(bool value, BitModel& model) {
    constexpr uint32_t least = 4;
    value = coder_.code(value, std::clamp<uint32_t>(model.one, least, certain - least));
    model.learn(value, details_learn);
    return value;
  }
  int correction(int steps, BitModel& any) {
    if (!bit(steps != 0, any)) return 0;
    const bool negative = coder_.code(steps < 0, certain / 2);
    const int beyond = code_rare(coder_, std::max(0, std::abs(steps) - 1),
                                 [&](bool longer, int place) { return bit(longer, more_[place]); });
    return negative ? -1 - beyond : 1 + beyond;
  }
  template<class Body> void for_samples(const Body& body) {
    for (int t = 0; t < box_.frames; ++t)
      for (int z = 0; z < box_.size[2]; ++z)
        for (int y = 0; y < box_.size[1]; ++y)
          for (int x = 0; x < box_.size[0]; ++x) body(t, z, y, x, box_.row(t, z, y) + x);
  }

  Coder& coder_;
  const DetailBox& box_;
  const DetailRule& rule_;
  std::array<BitModel, 8> air_{};
  std::array<BitModel, most_rare_bits + 1> more_{};
  std::array<BitModel, 16> holes_{};
  std::array<BitModel, 20> corrected_{};
};

// Rounding to floats may not break the bound.
constexpr float a_bit_less = 1.999F; // than twice
float step_of(const DetailRule& rule) { return rule.bound * a_bit_less; }

} // namespace

std::vector<std::byte> code_details(const DetailBox& box, const DetailRule& rule,
                                    std::span<const float> source, std::span<const float> restored) {
  BinaryEncoder coder;
  DetailCoder<BinaryEncoder> details(coder, box, rule);
  std::vector<float> known(restored.begin(), restored.end());
  bool any = false;
  const auto keep = [&](size_t i) { known[i] = source[i], any = true; };
  details.air([&](int z, int y, int x) { return is_air(box, rule.air, source, z, y, x); },
              [&](int z, int y, int x) {
                for_rows(box, z, y, x, [&](size_t first, int n) {
                  for (int i = 0; i < n; ++i) keep(first + i);
                });
              });
  if (rule.has_holes) details.holes([&](size_t i) { return !std::isfinite(source[i]); }, keep);
  const Facts facts{source, known, step_of(rule)};
  if (rule.bound > 0)
    details.corrections(
        [&](size_t i) { return std::isfinite(source[i]) ? facts.correction(i, rule.bound) : 0; },
        [&](size_t, int) { any = true; });
  return any ? coder.finish() : std::vector<std::byte>{};
}

void apply_details(const DetailBox& box, const DetailRule& rule, std::span<const std::byte> bytes,
                   std::span<float> restored) {
  if (bytes.empty()) return;
  BinaryDecoder coder(bytes);
  DetailCoder<BinaryDecoder> details(coder, box, rule);
  details.air([](int, int, int) { return false; },
              [&](int z, int y, int x) {
                for_rows(box, z, y, x,
                         [&](size_t first, int n) { std::fill_n(restored.data() + first, n, rule.air); });
              });
  if (rule.has_holes)
    details.holes([](size_t) { return false; },
                  [&](size_t i) { restored[i] = std::numeric_limits<float>::quiet_NaN(); });
  if (rule.bound > 0)
    details.corrections(
        [](size_t) { return 0; },
        [&](size_t i, int steps) { restored[i] += static_cast<float>(steps) * step_of(rule); });
}

void mark_exact(const DetailBox& box, const DetailRule& rule, std::span<const float> source,
                std::span<uint8_t> exact) {
  for_blocks(box, [&](int z, int y, int x) {
    const bool air = is_air(box, rule.air, source, z, y, x);
    for_rows(box, z, y, x, [&](size_t first, int n) {
      for (int i = 0; i < n; ++i) exact[first + i] = air || !std::isfinite(source[first + i]);
    });
  });
}

} // namespace bccsplat::bench
