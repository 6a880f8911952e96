// SPDX-License-Identifier: Apache-2.0
#include "readers/netcdf/even_levels.h"

#include <algorithm>
#include <cmath>

namespace bcc4 {
namespace {

constexpr uint64_t kMostPerLevel = 4;

// The levels of the source that a sample is between, and how far it is from the one to the other.
struct Place {
  uint64_t below = 0;
  double weight = 0;
};

Place place_of(const EvenLevels& even, uint64_t k) {
  const std::vector<double>& at = even.levels;
  const double wanted = even.begin + static_cast<double>(k) * even.step, sign = even.step < 0 ? -1 : 1;
  const auto next = std::upper_bound(at.begin() + 1, at.end() - 1, wanted,
                                     [&](double w, double level) { return sign * w < sign * level; });
  const auto below = static_cast<uint64_t>(next - at.begin()) - 1;
  const double weight = (wanted - at[below]) / (at[below + 1] - at[below]);
  return {below, std::clamp(std::abs(weight) < 1e-9       ? 0
                            : std::abs(weight - 1) < 1e-9 ? 1
                                                          : weight,
                            0.0, 1.0)};
}

// A missing value takes part only where it has a share.
double between(double a, double b, double weight) {
  return weight == 0 ? a : weight == 1 ? b : (1 - weight) * a + weight * b;
}

class LevelReader : public FrameReader {
 public:
  LevelReader(std::unique_ptr<FrameReader> source, EvenLevels even)
      : source_(std::move(source)), even_(std::move(even)), description_(source_->description()) {
    description_.dims[2] = even_.count;
    for (Channel& c : description_.channels) {
      c.type = c.precision = c.type == Type::f64 ? Type::f64 : Type::f32;
      c.step = c.offset = 0;
    }
  }
  const SeriesDescription& description() const override { return description_; }
  std::string frame_name(uint64_t frame) const override { return source_->frame_name(frame); }

  Frame read(uint64_t frame, size_t channel) override {
    const auto& from = source_->description().dims;
    const Frame levels = source_->read(frame, channel);
    const uint64_t plane = from[0] * from[1];
    const Type type = description_.channels[channel].type;
    std::vector<double> a(plane), b(plane);
    auto bytes = std::make_shared<Bytes>(plane * even_.count * type_size(type));
    for (uint64_t k = 0; k < even_.count; ++k) {
      const Place p = place_of(even_, k);
      gather_plane(levels, from, p.below, 0, a.data());
      gather_plane(levels, from, p.below + 1, 0, b.data());
      for (uint64_t i = 0; i < plane; ++i) {
        std::byte* const to = bytes->data() + (k * plane + i) * type_size(type);
        const double value = between(a[i], b[i], p.weight);
        type == Type::f64 ? store_as<double>(value, to) : store_as<float>(value, to);
      }
    }
    return dense_frame(type, std::move(bytes),
                       {{AxisRole::x, from[0]}, {AxisRole::y, from[1]}, {AxisRole::z, even_.count}});
  }

 private:
  std::unique_ptr<FrameReader> source_;
  EvenLevels even_;
  SeriesDescription description_;
};

} // namespace

bool strictly_monotonic(const std::vector<double>& levels) {
  const bool falls = levels.back() < levels.front();
  for (size_t i = 0; i < levels.size(); ++i)
    if (!std::isfinite(levels[i]) ||
        (i > 0 && !(falls ? levels[i] < levels[i - 1] : levels[i] > levels[i - 1])))
      return false;
  return true;
}

EvenLevels even_levels(const std::vector<double>& levels) {
  double closest = HUGE_VAL;
  for (size_t i = 1; i < levels.size(); ++i) closest = std::min(closest, std::abs(levels[i] - levels[i - 1]));
  const double whole = levels.back() - levels.front();
  const double most = static_cast<double>(kMostPerLevel * levels.size());
  const double steps = std::min(std::ceil(std::abs(whole) / closest - 1e-6), most);
  return {levels, levels.front(), whole / steps, static_cast<uint64_t>(steps) + 1};
}

std::unique_ptr<FrameReader> resample_levels(std::unique_ptr<FrameReader> source, const EvenLevels& even) {
  return std::make_unique<LevelReader>(std::move(source), even);
}

} // namespace bcc4
