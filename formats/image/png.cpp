// SPDX-License-Identifier: Apache-2.0
// Writes pictures with libpng, whose errors are long jumps and become exceptions here.
#include "formats/image/png.h"

#include <cmath>

#include "base/error.h"
#include "formats/image/sink_buffer.h"

namespace bccsplat {

unsigned char srgb_byte(double linear) {
  if (!(linear > 0)) return 0;
  if (linear >= 1) return 255;
  const double s = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  return static_cast<unsigned char>(std::lround(255 * s));
}

} // namespace bccsplat

#if defined(BCCSPLAT_WITH_IMAGE)

#include <png.h>

#include <csetjmp>
#include <memory>
#include <vector>

namespace bccsplat {
namespace {

struct Writer {
  SinkBuffer* sink;
  uint64_t position = 0;
  std::exception_ptr error; // what a callback threw, kept until the frames of libpng, which is C, are left
  std::string message;
};

void write_bytes(png_structp png, png_bytep bytes, png_size_t count) {
  auto& w = *static_cast<Writer*>(png_get_io_ptr(png));
  try {
    w.sink->write(w.position, std::as_bytes(std::span(bytes, count)));
    w.position += count;
  } catch (...) {
    w.error = std::current_exception();
  }
  if (w.error) png_error(png, "write failed");
}
void flush_bytes(png_structp) {}
void on_error(png_structp png, png_const_charp message) {
  static_cast<Writer*>(png_get_error_ptr(png))->message = message;
  png_longjmp(png, 1);
}
void on_warning(png_structp, png_const_charp) {}

// What is written, row by row.
struct Picture {
  int width, height;
  const float* rgba;
  std::ptrdiff_t row_floats;
  const PngOptions& options;
  [[nodiscard]] int channels() const { return options.background ? 3 : 4; }
};

void convert_row(const Picture& picture, int y, unsigned char* out) {
  const float* p = picture.rgba + y * picture.row_floats;
  for (int x = 0; x < picture.width; ++x, p += 4) {
    const double alpha = std::isnan(p[3]) ? 0 : std::fmin(1, std::fmax(0, p[3]));
    for (size_t c = 0; c < 3; ++c) {
      const double color = p[c];
      if (picture.options.background)
        *out++ = srgb_byte(color + (1 - alpha) * (*picture.options.background)[c]);
      else
        *out++ = alpha > 0 ? srgb_byte(color / alpha) : static_cast<unsigned char>(0);
    }
    if (!picture.options.background) *out++ = static_cast<unsigned char>(std::lround(255 * alpha));
  }
}

// False where the caller wants no more of it: the writer holds the exception.
bool goes_on(Writer& writer, const Picture& picture, int y) {
  if (!picture.options.progress) return true;
  try {
    picture.options.progress->report(static_cast<double>(y) / picture.height);
  } catch (...) {
    writer.error = std::current_exception();
  }
  return !writer.error;
}

// The level of zlib. Its default, 6, takes 1.5 to 2.2 times as long for 0 to 2 % fewer bytes
// (tests/bench/notes/render-speed.md).
constexpr int compression_level = 4;

// Makes all calls that may jump back to setjmp: no object with a destructor lives here. row: of bytes.
bool write_rows(png_structp png, png_infop info, Writer& writer, const Picture& picture, unsigned char* row) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_IHDR(png, info, static_cast<png_uint_32>(picture.width), static_cast<png_uint_32>(picture.height),
               8, picture.channels() == 4 ? PNG_COLOR_TYPE_RGBA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(png, compression_level);
  png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_write_info(png, info);
  for (int y = 0; y < picture.height; ++y) {
    if (!goes_on(writer, picture, y)) return false;
    convert_row(picture, y, row);
    png_write_row(png, row);
  }
  png_write_end(png, info);
  return true;
}

} // namespace

void write_png(ByteSink& sink, const std::string& name, int width, int height, const float* rgba,
               std::ptrdiff_t row_floats, const PngOptions& options) {
  const Picture picture{width, height, rgba, row_floats, options};
  std::vector<unsigned char> row(static_cast<size_t>(width) * picture.channels());
  SinkBuffer buffer(sink);
  Writer writer{&buffer, 0, {}, {}};
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &writer, on_error, on_warning);
  if (!png) fail(Code::out_of_memory, name, ": libpng has no memory");
  png_infop info = png_create_info_struct(png);
  bool good = false;
  if (info) {
    png_set_write_fn(png, &writer, write_bytes, flush_bytes);
    good = write_rows(png, info, writer, picture, row.data());
  }
  png_destroy_write_struct(&png, &info);
  if (writer.error) std::rethrow_exception(writer.error);
  if (!good) fail(Code::io_error, name, ": cannot write PNG: ", writer.message);
  buffer.finish();
}

} // namespace bccsplat

#else

namespace bccsplat {

void write_png(ByteSink&, const std::string& name, int, int, const float*, std::ptrdiff_t,
               const PngOptions&) {
  fail(Code::missing_feature, name, ": built without image files (BCCSPLAT_WITH_IMAGE)");
}

} // namespace bccsplat

#endif

namespace bccsplat {

void write_png(const std::string& path, int width, int height, const float* rgba, std::ptrdiff_t row_floats,
               const PngOptions& options) {
  const auto sink = create_file_sink(path, options.overwrite);
  write_png(*sink, path, width, height, rgba, row_floats, options);
  sink->commit();
}

} // namespace bccsplat
