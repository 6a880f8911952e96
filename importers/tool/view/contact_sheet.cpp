// SPDX-License-Identifier: Apache-2.0
#include "tool/view/contact_sheet.h"

#include <algorithm>

#include "tool/output/output_file.h"

namespace bcc4 {
namespace {

constexpr uint32_t gap_share = 50; // the gap between pictures is this part of their smaller side
constexpr uint64_t longest_side = 65536;

} // namespace

std::vector<size_t> places_on_sheet(size_t pictures, size_t places, bool circle) {
  std::vector<size_t> chosen;
  const size_t count = std::min(pictures, places);
  for (size_t i = 0; i < count; ++i) {
    if (count == pictures || circle)
      chosen.push_back(i * pictures / count);
    else
      chosen.push_back(count == 1 ? 0 : (i * (pictures - 1) + (count - 1) / 2) / (count - 1));
  }
  return chosen;
}

ContactSheet::ContactSheet(const RenderArguments& a, const Device& device, const PictureSize& size)
    : a_(a), device_(device), size_(size),
      gap_(std::max<uint32_t>(1, std::min(size.width, size.height) / gap_share)) {
  require_writable_folder(a.output);
  const auto [columns, rows] = *a.sheet;
  const auto side = [&](uint64_t count, uint64_t pixels) { return count * pixels + (count - 1) * gap_; };
  const uint64_t width = side(columns, size.width), height = side(rows, size.height);
  if (width > longest_side || height > longest_side)
    fail_usage("--sheet ", columns, "x", rows, ": ", width, " x ", height,
               " pixels are too many; --size is that of each picture");
  whole_ = {static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
  rgba_.resize(width * height * 4);
}

void ContactSheet::take(const Image& image, const Picture&, double) {
  auto plane = sized<bccsplat_plane>();
  check(bccsplat_frame_get_channel(image.get(), BCCSPLAT_FRAME_RGBA, &plane), "sheet");
  const size_t column = taken_ % (*a_.sheet)[0], row = taken_ / (*a_.sheet)[0];
  ++taken_;
  for (size_t y = 0; y < size_.height; ++y) {
    const float* from = plane.pixels + y * (plane.row_bytes / sizeof(float));
    const size_t line = row * (size_.height + gap_) + y;
    std::copy_n(from, size_t{4} * size_.width,
                &rgba_[4 * (line * whole_.width + column * (size_.width + gap_))]);
  }
}

void ContactSheet::finish() {
  bccsplat_frame* wrapped = nullptr;
  check(bccsplat_frame_wrap(device_.get(), whole_.width, whole_.height, rgba_.data(), 0, &wrapped), "sheet");
  const Image image(wrapped);
  save_png(image, a_.output, a_);
}

std::string ContactSheet::in_words() const {
  return concat(", ", taken_, taken_ == 1 ? " picture" : " pictures", " on ", whole_.width, " x ",
                whole_.height);
}

} // namespace bcc4
