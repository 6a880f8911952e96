// SPDX-License-Identifier: Apache-2.0
#include "readers/tiff/tiff_shape.h"

#include <algorithm>
#include <string_view>

#include "readers/text.h"

namespace bcc4 {
namespace {

using Sizes = std::vector<uint64_t>;

// Returns what stands between two marks behind a key of JSON, "" where it is not there.
std::string_view value_between(std::string_view json, std::string_view key, char open, char close) {
  const size_t at = json.find(key);
  if (at == std::string_view::npos) return {};
  const std::string_view rest = trim(json.substr(at + key.size()));
  if (!rest.starts_with(':')) return {};
  const std::string_view value = trim(rest.substr(1));
  const size_t end = value.find(close, 1);
  return value.starts_with(open) && end != std::string_view::npos ? value.substr(1, end - 1)
                                                                  : std::string_view{};
}

// Returns how many of the sizes are those of a page: height, width and samples of a pixel.
size_t sizes_of_page(const Sizes& sizes, const TiffKind& kind) {
  for (const Sizes& page : {Sizes{kind.height, kind.width, kind.samples}, Sizes{kind.height, kind.width}})
    if ((page.size() > 2 || kind.samples == 1) && sizes.size() >= page.size() &&
        std::equal(page.rbegin(), page.rend(), sizes.rbegin()))
      return page.size();
  return 0;
}

// Whether each of the letters is known, and there once.
bool names_pages(const std::string& letters) {
  const auto once = [&](char letter) {
    return std::string_view("czt").find(letter) != std::string_view::npos &&
           std::count(letters.begin(), letters.end(), letter) == 1;
  };
  return std::all_of(letters.begin(), letters.end(), once);
}

} // namespace

std::optional<TiffShape> tiff_shape(const TiffFile& file) {
  const std::string& text = file.description();
  if (!text.starts_with("{")) return std::nullopt;
  const auto told = parse_numbers(split_commas(value_between(text, "\"shape\"", '[', ']')));
  if (!told) return std::nullopt;
  Sizes sizes;
  for (const double size : *told) {
    if (!(size >= 1 && size < 0x1p32)) return std::nullopt;
    sizes.push_back(static_cast<uint64_t>(size));
  }
  const size_t of_page = sizes_of_page(sizes, file.kind());
  if (of_page == 0) return std::nullopt;
  const std::string names = lower(value_between(text, "\"axes\"", '"', '"'));
  const bool named = names.size() == sizes.size();
  TiffShape shape;
  for (size_t a = sizes.size() - of_page; a-- > 0;) {
    if (sizes[a] == 1) continue;
    shape.sizes.push_back(sizes[a]);
    if (named) shape.letters += names[a];
  }
  if (!names_pages(shape.letters)) shape.letters.clear();
  return shape;
}

} // namespace bcc4
