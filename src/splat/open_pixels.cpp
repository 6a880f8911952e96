#include "splat/open_pixels.h"

#include <algorithm>

namespace bccsplat {

void OpenPixels::prepare(int x, int y, int width, int height, int border) {
  x_ = x, y_ = y, width_ = width, height_ = height, border_ = border;
}

bool OpenPixels::hidden(const std::array<int, 4>& rect) const {
  const int left = x_ - border_, top = y_ - border_, columns = width_ + 2 * border_,
            rows = height_ + 2 * border_;
  const auto sum = [&](int y, int x) {
    y = std::clamp(y - top, 0, rows), x = std::clamp(x - left, 0, columns);
    return sum_[static_cast<size_t>(y * (columns + 1) + x)];
  };
  const int x0 = rect[0] - border_, y0 = rect[1] - border_, x1 = rect[2] + border_, y1 = rect[3] + border_;
  return sum(y1, x1) - sum(y1, x0) - sum(y0, x1) + sum(y0, x0) == 0;
}

} // namespace bccsplat
