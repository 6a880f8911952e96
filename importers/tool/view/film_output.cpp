// SPDX-License-Identifier: Apache-2.0
#include "tool/view/film_output.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tool/view/film_rate.h"

namespace bcc4 {
namespace {

// Half of a film's colours come in blocks of two by two pixels, so its sizes are even.
uint32_t even(uint32_t n) { return n + n % 2; }

FilmFormat film_format(const RenderArguments& a, const PictureSize& size, size_t pictures) {
  return {even(size.width),   even(size.height), a.fps.value_or(usual_rate), a.common.threads, a.command_line,
          a.loop.value_or(1), pictures};
}

// Bytes of linear intensities from 0 to 1, without a power for each: finer than a byte's steps are near
// black.
const std::vector<unsigned char>& display_bytes() {
  static const std::vector<unsigned char> table = [] {
    std::vector<unsigned char> t(65536);
    for (size_t i = 0; i < t.size(); ++i)
      t[i] = static_cast<unsigned char>(std::lround(255 * linear_to_srgb(static_cast<double>(i) / 65535)));
    return t;
  }();
  return table;
}

} // namespace

FilmOutput::FilmOutput(const RenderArguments& a, const PictureSize& size, size_t count)
    : format_(film_format(a, size, count)), count_(count),
      background_(linear_background(a).value_or(Color{0, 0, 0})),
      rgb_(size_t{3} * format_.width * format_.height), film_(a.output, format_) {
  if (format_.width != size.width || format_.height != size.height)
    std::fprintf(
        stderr,
        "bcc4: %s: %u x %u becomes %u x %u, as films need even sizes: a line of background is added\n",
        a.output.c_str(), size.width, size.height, format_.width, format_.height);
}

void FilmOutput::take(const Image& image, const Picture&, double) {
  auto plane = sized<bccsplat_plane>();
  check(bccsplat_frame_get_channel(image.get(), BCCSPLAT_FRAME_RGBA, &plane), "film");
  const std::vector<unsigned char>& bytes = display_bytes();
  unsigned char* out = rgb_.data();
  for (uint32_t y = 0; y < format_.height; ++y)
    for (uint32_t x = 0; x < format_.width; ++x) {
      constexpr float none[4]{};
      const bool inside = x < plane.width && y < plane.height;
      const float* p = inside ? plane.pixels + y * (plane.row_bytes / sizeof(float)) + size_t{4} * x : none;
      const double behind = p[3] > 0 ? 1 - std::min(1.0, double{p[3]}) : 1; // NaN counts as nothing
      for (size_t c = 0; c < 3; ++c) {
        const double v = double{p[c]} + behind * background_[c];
        *out++ = bytes[v > 0 ? static_cast<size_t>(std::lround(65535 * std::min(1.0, v))) : 0];
      }
    }
  film_.add(rgb_);
}

std::string FilmOutput::in_words() const {
  const double rate = static_cast<double>(format_.fps[0]) / format_.fps[1];
  const double seconds = static_cast<double>(count_) * format_.shown / rate;
  return concat(", ", count_, count_ == 1 ? " picture, " : " pictures, ",
                format_.shown > 1 ? concat(format_.shown, " times, ") : "", short_number(seconds, 3),
                " s at ", short_number(rate, 4), " per second");
}

} // namespace bcc4
