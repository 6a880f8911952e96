// SPDX-License-Identifier: Apache-2.0
// What drawn pictures become: files of their own, a sheet or a film.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tool/handles.h"
#include "tool/view/color_space.h"
#include "tool/view/picture_cut.h"
#include "tool/view/picture_sequence.h"
#include "tool/view/render_arguments.h"

namespace bcc4 {

class PictureOutput {
 public:
  PictureOutput() = default;
  PictureOutput(const PictureOutput&) = delete;
  PictureOutput& operator=(const PictureOutput&) = delete;
  virtual ~PictureOutput() = default;
  // exposure: seconds that the picture gathers.
  virtual void take(const Image& image, const Picture& picture, double exposure) = 0;
  virtual void finish() = 0;
  // Returns what is told at the end, beside the size of a picture.
  [[nodiscard]] virtual std::string in_words() const { return {}; }
};

// count: of the pictures that it will take. It keeps references to the arguments and the device.
[[nodiscard]] std::unique_ptr<PictureOutput>
picture_output(const RenderArguments& arguments, const Device& device, const PictureSize& size, size_t count);

// Over the background that was chosen, or transparent; replaces what is there.
void save_png(const Image& image, const std::string& path, const RenderArguments& arguments);

// Linear, for what lies behind a picture.
[[nodiscard]] std::optional<Color> linear_background(const RenderArguments& arguments);

} // namespace bcc4
