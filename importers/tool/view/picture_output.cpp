// SPDX-License-Identifier: Apache-2.0
#include "tool/view/picture_output.h"

#include <algorithm>

#include "tool/output/film.h"
#include "tool/view/contact_sheet.h"
#include "tool/view/film_output.h"

namespace bcc4 {
namespace {

class PictureFiles : public PictureOutput {
 public:
  PictureFiles(const RenderArguments& a, bool sequence) : a_(a), sequence_(sequence) {}

  void take(const Image& image, const Picture& picture, double exposure) override {
    if (!lower(picture.path).ends_with(".exr")) return save_png(image, picture.path, a_);
    auto o = sized<bccsplat_image_options>();
    o.overwrite = 1;
    constexpr std::array<int32_t, 2> usual{24, 1};
    if (sequence_ || a_.fps) {
      const auto rate = a_.fps.value_or(usual);
      std::copy(rate.begin(), rate.end(), o.frames_per_second);
    }
    o.exposure_seconds = exposure;
    o.comments = a_.command_line.c_str();
    const auto save_exr = a_.deep ? bccsplat_frame_save_deep_exr : bccsplat_frame_save_exr;
    check(save_exr(image.get(), picture.path.c_str(), &o), picture.path);
  }
  void finish() override {}

 private:
  const RenderArguments& a_;
  bool sequence_;
};

} // namespace

std::optional<Color> linear_background(const RenderArguments& a) {
  if (!a.background) return std::nullopt;
  Color linear;
  for (size_t i = 0; i < 3; ++i) linear[i] = srgb_to_linear((*a.background)[i]);
  return linear;
}

void save_png(const Image& image, const std::string& path, const RenderArguments& a) {
  auto o = sized<bccsplat_image_options>();
  o.overwrite = 1; // pictures are made again and again
  if (const auto background = linear_background(a)) {
    o.use_background = 1;
    std::copy(background->begin(), background->end(), o.background);
  }
  check(bccsplat_frame_save_png(image.get(), path.c_str(), &o), path);
}

std::unique_ptr<PictureOutput> picture_output(const RenderArguments& a, const Device& device,
                                              const PictureSize& size, size_t count) {
  if (a.sheet) return std::make_unique<ContactSheet>(a, device, size);
  if (is_film(a.output)) return std::make_unique<FilmOutput>(a, size, count);
  return std::make_unique<PictureFiles>(a, count > 1);
}

} // namespace bcc4
