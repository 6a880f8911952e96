// SPDX-License-Identifier: Apache-2.0
// Letters are drawn by stb_truetype; the font's file is put into the program by the assembler.
#include "tool/annotate/font.h"

#include "readers/error.h"

#if BCCSPLAT_WITH_TEXT

#include <algorithm>
#include <cmath>
#include <cstdint>

#define STBTT_STATIC
#define STB_TRUETYPE_IMPLEMENTATION
#include <stb_truetype.h>

#if defined(_WIN32) // no sections to come back to there, nor names to hide
asm(".section .rdata,\"dr\"\n"
    ".balign 16\n"
    ".globl bcc4_font\n"
    "bcc4_font:\n"
    ".incbin \"" BCCSPLAT_FONT "\"\n"
    ".byte 0\n"
    ".text\n");
#else
asm(".pushsection .rodata\n"
    ".balign 16\n"
    ".global bcc4_font\n"
    ".hidden bcc4_font\n"
    "bcc4_font:\n"
    ".incbin \"" BCCSPLAT_FONT "\"\n"
    ".byte 0\n"
    ".popsection\n");
#endif
extern "C" const unsigned char bcc4_font[]; // NOLINT(modernize-avoid-c-arrays): its length is the assembler's

namespace bcc4 {
namespace {

const stbtt_fontinfo& font() {
  static const stbtt_fontinfo loaded = [] {
    stbtt_fontinfo f;
    if (!stbtt_InitFont(&f, bcc4_font, 0)) fail_resources("the program's font cannot be read");
    return f;
  }();
  return loaded;
}

constexpr int unknown_letter = 0xFFFD;

struct Letter {
  int code;
  std::string_view bytes;
};

// Returns the letters of UTF-8; other bytes become the sign for unknown letters, control characters spaces.
std::vector<Letter> letters_of(std::string_view text) {
  std::vector<Letter> out;
  for (size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const size_t length = byte < 0x80       ? 1
                          : byte >> 5 == 6  ? 2
                          : byte >> 4 == 14 ? 3
                          : byte >> 3 == 30 ? 4
                                            : 0;
    int code = length < 2 ? byte : byte & (0x7F >> length);
    bool good = length > 0 && i + length <= text.size();
    for (size_t k = 1; good && k < length; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      good = next >> 6 == 2;
      code = code << 6 | (next & 0x3F);
    }
    const size_t bytes = good ? length : 1;
    out.push_back({!good ? unknown_letter : code < 0x20 || code == 0x7F ? ' ' : code, text.substr(i, bytes)});
    i += bytes;
  }
  return out;
}

// Calls place(glyph, x) for each letter; returns where the line ends. In pixels.
template<class Place> double lay_out(std::string_view text, double scale, const Place& place) {
  double x = 0;
  int before = 0;
  for (const Letter& letter : letters_of(text)) {
    const int glyph = stbtt_FindGlyphIndex(&font(), letter.code);
    int advance = 0;
    stbtt_GetGlyphHMetrics(&font(), glyph, &advance, nullptr);
    if (before) x += scale * stbtt_GetGlyphKernAdvance(&font(), before, glyph);
    place(glyph, x);
    x += scale * advance;
    before = glyph;
  }
  return x;
}

double scale_of(double em) { return stbtt_ScaleForMappingEmToPixels(&font(), static_cast<float>(em)); }

} // namespace

bool has_font() { return true; }

void require_font() { (void)font(); }

double text_width(std::string_view text, double em) {
  return lay_out(text, scale_of(em), [](int, double) {});
}

TextMask text_mask(std::string_view text, double em, int pad) {
  const double scale = scale_of(em);
  const auto f = static_cast<float>(scale);
  int ascent = 0, descent = 0;
  stbtt_GetFontVMetrics(&font(), &ascent, &descent, nullptr);
  TextMask m;
  m.pad = pad;
  m.baseline = pad + static_cast<int>(std::ceil(scale * ascent));
  m.height = m.baseline + static_cast<int>(std::ceil(-scale * descent)) + pad;
  m.width = 2 * pad + static_cast<int>(std::ceil(text_width(text, em))) + 1;
  m.coverage.resize(static_cast<size_t>(m.width) * m.height);
  lay_out(text, scale, [&](int glyph, double at) {
    const double whole = std::floor(at);
    const auto shift = static_cast<float>(at - whole);
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    stbtt_GetGlyphBitmapBoxSubpixel(&font(), glyph, f, f, shift, 0, &x0, &y0, &x1, &y1);
    if (x1 <= x0 || y1 <= y0) return;
    std::vector<unsigned char> letter(static_cast<size_t>(x1 - x0) * (y1 - y0));
    stbtt_MakeGlyphBitmapSubpixel(&font(), letter.data(), x1 - x0, y1 - y0, x1 - x0, f, f, shift, 0, glyph);
    for (int y = std::max(y0, -m.baseline); y < std::min(y1, m.height - m.baseline); ++y)
      for (int x = x0; x < x1; ++x) {
        const int column = pad + static_cast<int>(whole) + x;
        if (column < 0 || column >= m.width) continue;
        float& there = m.coverage[static_cast<size_t>(y + m.baseline) * m.width + column];
        const unsigned char here = letter[static_cast<size_t>(y - y0) * (x1 - x0) + (x - x0)];
        there = std::max(there, static_cast<float>(here) / 255);
      }
  });
  return m;
}

std::string missing_letters(std::string_view text) {
  std::string out;
  for (const Letter& letter : letters_of(text))
    if (stbtt_FindGlyphIndex(&font(), letter.code) == 0 && out.find(letter.bytes) == std::string::npos)
      out += letter.bytes;
  return out;
}

std::string fitted_text(const std::string& text, double em, double width) {
  if (text_width(text, em) <= width) return text;
  std::string part = text;
  while (!part.empty() && text_width(part + "…", em) > width) {
    while (!part.empty() && (static_cast<unsigned char>(part.back()) & 0xC0) == 0x80) part.pop_back();
    if (!part.empty()) part.pop_back();
  }
  return part + "…";
}

} // namespace bcc4

#else

namespace bcc4 {

bool has_font() { return false; }
void require_font() {
  fail_usage("--annotate, --layout: this bcc4 was built without a font (BCCSPLAT_WITH_TEXT)");
}
double text_width(std::string_view, double) {
  require_font();
  return 0;
}
TextMask text_mask(std::string_view, double, int) {
  require_font();
  return {};
}
std::string missing_letters(std::string_view) { return ""; }
std::string fitted_text(const std::string& text, double, double) { return text; }

} // namespace bcc4

#endif
