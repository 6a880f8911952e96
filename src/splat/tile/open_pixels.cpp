// SPDX-License-Identifier: Apache-2.0
#include "splat/tile/open_pixels.h"

#include <algorithm>
#include <numeric>

namespace bccsplat {

void OpenPixels::prepare(const PlannedTile& tile, const SplatPlan& plan) {
  ring_x_ = tile.ring_x, ring_y_ = tile.ring_y, ring_width_ = tile.ring_width,
  ring_height_ = tile.ring_height;
  width_ = tile.width, height_ = tile.height, around_ = plan.raise.around;
  const bool fan = plan.raise.fan.taps > 0;
  if (fan) ring_x_ = tile.x, ring_y_ = tile.y, ring_width_ = width_, ring_height_ = height_, around_ = 0;
  pixels_.assign(static_cast<size_t>(ring_width_) + 1, 0), row_.resize(height_);
  before_.assign(static_cast<size_t>(width_) + 1, 0);
  const int own = plan.raise.taps / 2 - 1; // of a pixel's samples
  for (int x = 0; x < width_; ++x)
    ++pixels_[(plan.raise.taps && !fan ? plan.raise.x.at(tile.x + x) + own : tile.x + x) - ring_x_ + 1];
  std::partial_sum(pixels_.begin(), pixels_.end(), pixels_.begin());
  rows_.assign(static_cast<size_t>(ring_height_) + 1, 0);
  for (int y = 0; y < height_; ++y) {
    row_[y] = (plan.raise.taps && !fan ? plan.raise.y.at(tile.y + y) + own : tile.y + y) - ring_y_;
    ++rows_[static_cast<size_t>(row_[y]) + 1];
  }
  std::partial_sum(rows_.begin(), rows_.end(), rows_.begin());
}

bool OpenPixels::counts_like(const OpenPixels& other) const {
  const auto place = [](const OpenPixels& o) {
    return std::array{o.ring_x_, o.ring_y_, o.ring_width_, o.ring_height_, o.width_, o.height_, o.around_};
  };
  return place(*this) == place(other) && pixels_ == other.pixels_ && row_ == other.row_;
}

std::array<int, 4> OpenPixels::in_ring(const std::array<int, 4>& rect) const {
  const auto x = [&](int at) { return std::clamp(at - ring_x_, 0, ring_width_); };
  const auto y = [&](int at) { return std::clamp(at - ring_y_, 0, ring_height_); };
  return {x(rect[0] - around_), y(rect[1] - around_), x(rect[2] + around_), y(rect[3] + around_)};
}

int OpenPixels::open(const std::array<int, 4>& in_ring) const {
  const auto [x0, y0, x1, y1] = in_ring;
  const auto sum = [&](int y, int x) { return sum_[y * (ring_width_ + 1) + x]; };
  return sum(y1, x1) - sum(y1, x0) - sum(y0, x1) + sum(y0, x0);
}

bool OpenPixels::hidden(const std::array<int, 4>& rect) const { return open(in_ring(rect)) == 0; }

bool OpenPixels::all_open(const std::array<int, 4>& rect) const {
  const auto r = in_ring(rect);
  const auto count = [](const std::vector<int>& before, int from, int to) {
    return before[to] - before[from];
  };
  return open(r) == count(pixels_, r[0], r[2]) * count(rows_, r[1], r[3]);
}

} // namespace bccsplat
