// SPDX-License-Identifier: Apache-2.0
#include "readers/tiff/tiff_shape.h"

#include <algorithm>
#include <string_view>

#include "readers/records.h"
#include "readers/text.h"

namespace bcc4 {
namespace {

using Sizes = std::vector<uint64_t>;

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
  const Record told = read_record(file.description());
  Sizes sizes;
  for (const Record& size : told.value("shape", Record::array())) {
    const double n = size.is_number() ? size.get<double>() : 0;
    if (!(n >= 1 && n < 0x1p32)) return std::nullopt;
    sizes.push_back(static_cast<uint64_t>(n));
  }
  const size_t of_page = sizes_of_page(sizes, file.kind());
  if (of_page == 0) return std::nullopt;
  const std::string names = lower(text_in(told, "axes"));
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
