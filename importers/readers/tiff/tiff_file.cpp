// SPDX-License-Identifier: Apache-2.0
// Pages through libtiff, which unpacks them and turns bytes; what it cannot give as rows of plain numbers is
// refused.
#include "readers/tiff/tiff_file.h"

#include <tiffio.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>

#include "readers/error.h"

namespace bcc4 {
namespace {

constexpr int kBitsOfByte = 8;

thread_local std::string last_words; // of libtiff

void keep_words(const char* /*module*/, const char* format, va_list arguments) {
  char text[500];
  std::vsnprintf(text, sizeof text, format, arguments);
  last_words = text;
}

uint16_t field(TIFF* file, uint32_t tag) {
  uint16_t value = 0;
  TIFFGetFieldDefaulted(file, tag, &value);
  return value;
}

std::optional<Type> type_of(int bits, int format) {
  const auto sized = [&](std::initializer_list<Type> types) -> std::optional<Type> {
    for (const Type type : types)
      if (static_cast<int>(type_size(type)) * kBitsOfByte == bits) return type;
    return std::nullopt;
  };
  if (format == SAMPLEFORMAT_IEEEFP) return sized({Type::f16, Type::f32, Type::f64});
  if (format == SAMPLEFORMAT_INT) return sized({Type::i8, Type::i16, Type::i32, Type::i64});
  if (format == SAMPLEFORMAT_UINT || format == SAMPLEFORMAT_VOID)
    return sized({Type::u8, Type::u16, Type::u32, Type::u64});
  return std::nullopt;
}

void check_packing(TIFF* file, const std::string& path) {
  const uint16_t compression = field(file, TIFFTAG_COMPRESSION);
  if (TIFFIsCODECConfigured(compression) == 0)
    fail_input(path, ": its compression, number ", compression,
               " of TIFF, is not in this libtiff: save it without compression, or with deflate");
  if (field(file, TIFFTAG_SAMPLESPERPIXEL) > 1 && field(file, TIFFTAG_PLANARCONFIG) == PLANARCONFIG_SEPARATE)
    fail_input(path, ": the colours of a page stand one after the other: tiffcp -p contig puts them side by "
                     "side");
}

TiffKind kind_of(TIFF* file, const std::string& path) {
  check_packing(file, path);
  TiffKind kind;
  TIFFGetField(file, TIFFTAG_IMAGEWIDTH, &kind.width);
  TIFFGetField(file, TIFFTAG_IMAGELENGTH, &kind.height);
  kind.samples = field(file, TIFFTAG_SAMPLESPERPIXEL);
  kind.photometric = PHOTOMETRIC_MINISBLACK;
  TIFFGetField(file, TIFFTAG_PHOTOMETRIC, &kind.photometric);
  const int bits = field(file, TIFFTAG_BITSPERSAMPLE);
  const auto type = type_of(bits, field(file, TIFFTAG_SAMPLEFORMAT));
  if (!type) fail_input(path, ": pixels of ", bits, " bits, or complex ones: convert it to 8, 16 or 32 bits");
  kind.type = *type;
  constexpr uint16_t read[] = {PHOTOMETRIC_MINISWHITE, PHOTOMETRIC_MINISBLACK, PHOTOMETRIC_RGB,
                               PHOTOMETRIC_PALETTE};
  if (std::find(std::begin(read), std::end(read), kind.photometric) == std::end(read))
    fail_input(path, ": its colours, number ", kind.photometric,
               " of TIFF, are no grey values or RGB: "
               "convert it to one of these");
  if (kind.width == 0 || kind.height == 0) fail_input(path, ": a page has no pixels: damaged");
  return kind;
}

} // namespace

TiffFile::TiffFile(const std::string& path) : path_(path), file_(nullptr, TIFFClose) {
  TIFFSetErrorHandler(keep_words);
  TIFFSetWarningHandler(nullptr);
  file_.reset(TIFFOpen(path.c_str(), "r"));
  if (!file_) fail_input(path, ": libtiff cannot open it: ", last_words);
  last_words.clear();
  do {
    uint32_t subfile = 0;
    TIFFGetField(file_.get(), TIFFTAG_SUBFILETYPE, &subfile);
    if ((subfile & FILETYPE_REDUCEDIMAGE) != 0) continue;
    const TiffKind kind = kind_of(file_.get(), path);
    if (offsets_.empty())
      kind_ = kind, describe_first_page();
    else if (!(kind == kind_))
      fail_input(path, ": page ", offsets_.size(), " has another size or type than the first one (",
                 kind.width, " x ", kind.height, " ", type_name(kind.type), ", not ", kind_.width, " x ",
                 kind_.height, " ", type_name(kind_.type), "): save the pages that belong together");
    if (TIFFIsTiled(file_.get()) != 0)
      tile_bytes_ = std::max<uint64_t>(tile_bytes_, TIFFTileSize64(file_.get()));
    offsets_.push_back(TIFFCurrentDirOffset(file_.get()));
  } while (TIFFReadDirectory(file_.get()) != 0);
  if (!last_words.empty()) fail_page(offsets_.size());
  if (offsets_.empty()) fail_input(path, ": no page but smaller copies of others");
}

void TiffFile::describe_first_page() {
  const char* text = nullptr;
  if (TIFFGetField(file_.get(), TIFFTAG_IMAGEDESCRIPTION, &text) != 0 && text) description_ = text;
  constexpr uint32_t tags[] = {TIFFTAG_XRESOLUTION, TIFFTAG_YRESOLUTION};
  for (size_t a = 0; a < 2; ++a)
    if (float value = 0; TIFFGetField(file_.get(), tags[a], &value) != 0 && value > 0) resolution_[a] = value;
}

void TiffFile::fail_page(uint64_t page) const {
  fail_input(path_, ": page ", page, " cannot be read", last_words.empty() ? "" : ": " + last_words,
             ": damaged or cut off");
}

void TiffFile::read(uint64_t page, std::span<std::byte> values) {
  last_words.clear();
  if (TIFFSetSubDirectory(file_.get(), offsets_[page]) == 0) fail_page(page);
  if (TIFFIsTiled(file_.get()) != 0)
    read_tiles(page, values);
  else
    read_strips(page, values);
}

void TiffFile::read_strips(uint64_t page, std::span<std::byte> values) {
  const uint64_t row = kind_.page_bytes() / kind_.height;
  uint32_t rows = 0;
  TIFFGetFieldDefaulted(file_.get(), TIFFTAG_ROWSPERSTRIP, &rows);
  rows = std::clamp<uint32_t>(rows, 1, kind_.height);
  for (uint32_t y = 0; y < kind_.height; y += rows) {
    const auto part = values.subspan(y * row, std::min(rows, kind_.height - y) * row);
    const tmsize_t size = static_cast<tmsize_t>(part.size());
    if (TIFFReadEncodedStrip(file_.get(), y / rows, part.data(), size) != size) fail_page(page);
  }
}

void TiffFile::read_tiles(uint64_t page, std::span<std::byte> values) {
  const uint64_t pixel = kind_.samples * type_size(kind_.type), row = kind_.width * pixel;
  uint32_t nx = 0, ny = 0;
  TIFFGetField(file_.get(), TIFFTAG_TILEWIDTH, &nx);
  TIFFGetField(file_.get(), TIFFTAG_TILELENGTH, &ny);
  const tmsize_t size = TIFFTileSize(file_.get());
  if (nx == 0 || ny == 0 || size != static_cast<tmsize_t>(nx * ny * pixel)) fail_page(page);
  std::vector<std::byte> tile(size);
  for (uint32_t y = 0; y < kind_.height; y += ny)
    for (uint32_t x = 0; x < kind_.width; x += nx) {
      if (TIFFReadEncodedTile(file_.get(), TIFFComputeTile(file_.get(), x, y, 0, 0), tile.data(), size) !=
          size)
        fail_page(page);
      const uint64_t width = std::min(nx, kind_.width - x) * pixel;
      for (uint32_t j = 0; j < std::min(ny, kind_.height - y); ++j)
        std::copy_n(tile.begin() + static_cast<std::ptrdiff_t>(j * nx * pixel), width,
                    values.begin() + static_cast<std::ptrdiff_t>((y + j) * row + x * pixel));
    }
}

} // namespace bcc4
