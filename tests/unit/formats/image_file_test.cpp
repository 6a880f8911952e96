// SPDX-License-Identifier: Apache-2.0
// EXR and PNG files as OpenEXR and libpng read them: values, attributes, camera, opacity, background and the
// curve of sRGB. Built only where both libraries are there.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "base/error.h"
#include "formats/image/exr.h"
#include "formats/image/png.h"
#include "view/camera.h"

#if __has_include(<ImfInputFile.h>) && __has_include(<png.h>)
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfInputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <png.h>

namespace bccsplat {
namespace {

constexpr int width = 13, height = 7;

std::string temporary(const char* name) { return testing::TempDir() + name; }

// Premultiplied, with rows longer than the picture.
struct Picture {
  std::ptrdiff_t row_floats = (width + 3) * 4;
  std::vector<float> rgba = std::vector<float>(row_floats * height, 777.0f);
  std::vector<float> depth = std::vector<float>(width * height);
  Picture() {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        float* p = &rgba[y * row_floats + static_cast<size_t>(x) * 4];
        p[3] = static_cast<float>(x) / (width - 1);
        p[0] = p[3] * 0.5f, p[1] = p[3] * static_cast<float>(y) / (height - 1), p[2] = p[3];
        depth[y * width + x] =
            x == y ? std::numeric_limits<float>::infinity() : static_cast<float>(x - 3 * y);
      }
  }
};

template<class Call> Code code_of(Call call) {
  try {
    call();
  } catch (const Error& e) {
    return e.code();
  }
  return Code::ok;
}

TEST(Exr, ReadsBackBitForBitWithItsAttributes) {
  const Picture picture;
  const std::string path = temporary("round.exr");
  std::remove(path.c_str());
  ExrOptions options;
  options.frames_per_second = {25, 1};
  options.attributes = {{"bccsplat/kernel", "radial20+b3"}};
  const float* rgba = picture.rgba.data();
  const std::vector<ExrChannel> channels = {{"R", rgba, 4, picture.row_floats},
                                            {"G", rgba + 1, 4, picture.row_floats},
                                            {"B", rgba + 2, 4, picture.row_floats},
                                            {"A", rgba + 3, 4, picture.row_floats},
                                            {"depth.Z", picture.depth.data(), 1, width}};
  write_exr(path, width, height, channels, options);
  std::vector<float> green(width * height), depth(width * height);
  { // closed before it is replaced
    Imf::InputFile file(path.c_str());
    EXPECT_EQ(Imf::framesPerSecond(file.header()).n, 25);
    EXPECT_EQ(file.header().typedAttribute<Imf::StringAttribute>("bccsplat/kernel").value(), "radial20+b3");
    EXPECT_EQ(file.header().compression(), Imf::ZIP_COMPRESSION);
    Imf::FrameBuffer frame;
    frame.insert("G", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(green.data()), 4, 4 * width));
    frame.insert("depth.Z", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(depth.data()), 4, 4 * width));
    file.setFrameBuffer(frame);
    file.readPixels(0, height - 1);
  }
  EXPECT_EQ(depth, picture.depth);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      EXPECT_EQ(green[y * width + x], rgba[y * picture.row_floats + static_cast<size_t>(x) * 4 + 1]);
  EXPECT_EQ(code_of([&] { write_exr(path, width, height, channels, {}); }), Code::file_exists);
  ExrOptions again;
  again.overwrite = true;
  EXPECT_EQ(code_of([&] { write_exr(path, width, height, channels, again); }), Code::ok);
  std::remove(path.c_str());
  EXPECT_NE(code_of([&] { write_exr("/nonexistent/x.exr", width, height, channels, {}); }), Code::ok);
}

TEST(Exr, HoldsCameraExposureAndComments) {
  const Picture picture;
  const std::string path = temporary("standard.exr");
  const std::vector<ExrChannel> channels = {{"R", picture.rgba.data(), 4, picture.row_floats}};
  ExrOptions options;
  options.overwrite = true;
  write_exr(path, width, height, channels, options);
  {
    const Imf::InputFile file(path.c_str());
    EXPECT_FALSE(Imf::hasFramesPerSecond(file.header()) || Imf::hasExpTime(file.header()) ||
                 Imf::hasComments(file.header()) || Imf::hasWorldToCamera(file.header()) ||
                 Imf::hasWorldToNDC(file.header()));
    EXPECT_EQ(file.header().screenWindowWidth(), 1);
  }
  // A camera at (10, 20, 30) that looks along +x with z up: its right is -y.
  const WorldCamera camera{true, {10, 20, 30}, {0, -1, 0}, {0, 0, 1}, {1, 0, 0}, 0.5};
  const PictureMatrices m = picture_matrices(camera, width, height);
  options.exposure_seconds = 0.125;
  options.comments = "bcc4 render";
  options.view = ExrView{m.world_to_camera, m.world_to_ndc, 0.5 * width / height};
  write_exr(path, width, height, channels, options);
  const Imf::InputFile file(path.c_str());
  EXPECT_EQ(Imf::expTime(file.header()), 0.125f);
  EXPECT_EQ(Imf::comments(file.header()), "bcc4 render");
  EXPECT_EQ(file.header().screenWindowWidth(), static_cast<float>(0.5 * width / height));
  // Four ahead, one to the right, two up: Imath multiplies row vectors, as OpenEXR's matrices are meant.
  const Imath::V3f point(14, 19, 32);
  const Imath::V3f seen = point * Imf::worldToCamera(file.header());
  EXPECT_EQ(seen, Imath::V3f(1, 2, 4));
  const Imath::V3f flat = point * Imf::worldToNDC(file.header()); // divides by the fourth part
  EXPECT_NEAR(flat.x, 0.5 + 1.0 / 4 / (0.5 * width / height), 1e-6);
  EXPECT_NEAR(flat.y, 0.5 - 2.0 / 4 / 0.5, 1e-6);
  std::remove(path.c_str());
}

std::vector<unsigned char> read_png(const std::string& path, unsigned format) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_file(&image, path.c_str()));
  EXPECT_EQ(image.width, static_cast<unsigned>(width));
  EXPECT_EQ(image.height, static_cast<unsigned>(height));
  EXPECT_EQ(image.format & PNG_FORMAT_FLAG_ALPHA, format & PNG_FORMAT_FLAG_ALPHA);
  image.format = format;
  std::vector<unsigned char> bytes(PNG_IMAGE_SIZE(image));
  EXPECT_TRUE(png_image_finish_read(&image, nullptr, bytes.data(), 0, nullptr));
  return bytes;
}

TEST(Png, HoldsStraightAlphaOrABackground) {
  const Picture picture;
  const std::string path = temporary("round.png");
  std::remove(path.c_str());
  write_png(path, width, height, picture.rgba.data(), picture.row_floats, {});
  const auto straight = read_png(path, PNG_FORMAT_RGBA);
  const auto at = [](const auto& bytes, int x, int y, int c, int n) {
    return bytes[static_cast<size_t>((y * width + x) * n + c)];
  };
  EXPECT_EQ(at(straight, 0, 3, 3, 4), 0);
  EXPECT_EQ(at(straight, 6, 3, 3, 4), 128);
  for (int x = 1; x < width; ++x) {
    EXPECT_EQ(at(straight, x, 3, 0, 4), srgb_byte(0.5)); // whatever the opacity
    EXPECT_EQ(at(straight, x, 0, 1, 4), 0);              // the first row is the top
    EXPECT_EQ(at(straight, x, height - 1, 1, 4), 255);
  }
  PngOptions options;
  EXPECT_EQ(
      code_of([&] { write_png(path, width, height, picture.rgba.data(), picture.row_floats, options); }),
      Code::file_exists);
  options.overwrite = true;
  options.background = {0.25, 0.25, 0.25};
  write_png(path, width, height, picture.rgba.data(), picture.row_floats, options);
  const auto over = read_png(path, PNG_FORMAT_RGB);
  EXPECT_EQ(at(over, 0, 2, 0, 3), srgb_byte(0.25));
  EXPECT_EQ(at(over, 6, 2, 0, 3), srgb_byte(0.5 * 0.5 + 0.5 * 0.25));
  std::remove(path.c_str());
}

TEST(Png, TransferCurveIsSrgb) {
  EXPECT_EQ(srgb_byte(0), 0);
  EXPECT_EQ(srgb_byte(1), 255);
  EXPECT_EQ(srgb_byte(2), 255);
  EXPECT_EQ(srgb_byte(std::nan("")), 0);
  EXPECT_EQ(srgb_byte(0.2140), 127); // mid grey
  EXPECT_EQ(srgb_byte(0.001), 3);    // the linear foot: 12.92 * 255 * 0.001
}

} // namespace
} // namespace bccsplat
#endif
