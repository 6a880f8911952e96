// SPDX-License-Identifier: Apache-2.0
// Pictures side by side in one PNG, in rows from the top left.
#pragma once

#include <vector>

#include "tool/view/picture_output.h"

namespace bcc4 {

// Returns which of so many pictures a sheet with fewer places shows: evenly from the first to the last, or,
// where they go round a circle, to the one that leads to the first.
[[nodiscard]] std::vector<size_t> places_on_sheet(size_t pictures, size_t places, bool circle);

class ContactSheet : public PictureOutput {
 public:
  // The pictures were chosen by places_on_sheet.
  ContactSheet(const RenderArguments& arguments, const Device& device, const PictureSize& size);
  void take(const Image& image, const Picture& picture, double exposure) override;
  void finish() override;
  [[nodiscard]] std::string in_words() const override;

 private:
  const RenderArguments& a_;
  const Device& device_;
  PictureSize size_, whole_; // of a picture and of the sheet
  uint32_t gap_;
  size_t taken_ = 0;
  std::vector<float> rgba_;
};

} // namespace bcc4
