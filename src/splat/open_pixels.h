// Which pixels of a tile are still open: sums over rectangles, so that what only finished pixels would see is
// not drawn.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace bccsplat {

class OpenPixels {
 public:
  // A tile of width x height pixels at (x, y) of the picture. Sums reach `border` pixels beyond it, where
  // nothing is ever open.
  void prepare(int x, int y, int width, int height, int border);

  // Sums anew: open(p) of pixel p = row * pitch + column.
  template<class Open> void count(int pitch, const Open& open) {
    const int around = 2 * border_, columns = width_ + around + 1;
    sum_.assign(static_cast<size_t>(columns * (height_ + around + 1)), 0);
    for (int y = 0; y < height_ + around; ++y) {
      const int32_t* const above = sum_.data() + y * columns;
      int32_t* const row = sum_.data() + (y + 1) * columns;
      if (y < border_ || y >= height_ + border_) {
        std::copy_n(above, columns, row);
        continue;
      }
      const size_t first = static_cast<size_t>(y - border_) * static_cast<size_t>(pitch);
      int32_t* const inner = row + border_ + 1;
      for (int x = 0; x < width_; ++x) inner[x] = open(first + static_cast<size_t>(x)) ? 1 : 0;
      int32_t sum = 0;
      for (int x = 0; x < width_; ++x) sum += inner[x], inner[x] = sum + above[border_ + 1 + x];
      std::fill_n(inner + width_, border_, sum + above[columns - 1]);
    }
  }

  // Whether no pixel of the tile inside the rectangle of the picture (x begin, y begin, x end, y end), or
  // within the border of it, is open.
  [[nodiscard]] bool hidden(const std::array<int, 4>& rect) const;
  // Whether less than a quarter of the tile is open.
  [[nodiscard]] bool mostly_closed() const { return sum_.back() < width_ * height_ / 4; }
  [[nodiscard]] const int32_t* sums() const { return sum_.data(); } // see TransformArgs::open_sum
  [[nodiscard]] int border() const { return border_; }

 private:
  int x_ = 0, y_ = 0, width_ = 0, height_ = 0, border_ = 0;
  std::vector<int32_t> sum_;
};

} // namespace bccsplat
