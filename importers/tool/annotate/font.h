// SPDX-License-Identifier: Apache-2.0
// Text as coverage of pixels, in the font that is part of the program: DejaVu Sans.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace bcc4 {

// One line of text: rows of coverage from 0 to 1, with `pad` pixels around it.
struct TextMask {
  int width = 0, height = 0;
  int pad = 0, baseline = 0; // the first letter starts at column `pad` and stands on row `baseline`
  std::vector<float> coverage;
};

// Whether the program was built with a font (BCCSPLAT_WITH_TEXT).
[[nodiscard]] bool has_font();
// Throws where it was not.
void require_font();
// Pixels from the start of a line of UTF-8 to its end; em: pixels of the font's size.
[[nodiscard]] double text_width(std::string_view text, double em);
[[nodiscard]] TextMask text_mask(std::string_view text, double em, int pad);
// The letters of a text that the font does not have, each once; boxes are drawn for them.
[[nodiscard]] std::string missing_letters(std::string_view text);
// The text, or as much of its beginning as fits with an ellipsis.
[[nodiscard]] std::string fitted_text(const std::string& text, double em, double width);

} // namespace bcc4
