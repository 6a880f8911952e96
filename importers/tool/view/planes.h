// SPDX-License-Identifier: Apache-2.0
// Planes of a moment's samples in a picture, in the proportions of the world, with their sides and a scale.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tool/handles.h"
#include "tool/view/picture_layout.h"
#include "tool/view/slice_choice.h"

namespace bcc4 {

class Planes {
 public:
  // colors: of values, linear. What is grey is black below them and white above. layout: it is looked at
  // later, too.
  Planes(Volume volume, uint32_t channel, const PictureLayout& layout,
         std::vector<std::array<double, 4>> colors);

  // Draws those of a moment through the samples nearest to a place of the world; a map's is the one that is
  // nearest to the ground or to the sea's surface.
  void draw(const Image& image, const Cut& where, const std::array<double, 3>& middle);
  // Returns where the last ones stand: "y = 30 (R to L, I to S), x = 12 ...", from left to right and from
  // below.
  [[nodiscard]] std::string in_words() const { return words_; }

 private:
  Volume volume_;
  uint32_t channel_;
  const PictureLayout& layout_;
  std::vector<std::array<double, 4>> colors_;
  std::string words_;
};

} // namespace bcc4
