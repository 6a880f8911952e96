// SPDX-License-Identifier: Apache-2.0
// Pictures as a film: opaque over the background, in display colours, of even sizes.
#pragma once

#include <vector>

#include "tool/output/film.h"
#include "tool/view/picture_output.h"

namespace bcc4 {

class FilmOutput : public PictureOutput {
 public:
  FilmOutput(const RenderArguments& arguments, const PictureSize& size, size_t count);
  void take(const Image& image, const Picture& picture, double exposure) override;
  void finish() override { film_.finish(); }
  [[nodiscard]] std::string in_words() const override;

 private:
  FilmFormat format_;
  size_t count_;
  Color background_; // linear
  std::vector<unsigned char> rgb_;
  Film film_;
};

} // namespace bcc4
