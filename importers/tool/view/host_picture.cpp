// SPDX-License-Identifier: Apache-2.0
// Reads a host's picture with OpenEXR: any type of R, G, B, A and Z in scan lines or tiles, over its display
// window. A pixel outside the data window is transparent, and nothing is there.
#include <algorithm>
#include <cstddef>
#include <exception>
#include <limits>

#include "readers/error.h"
#include "tool/view/host_things.h"

#ifdef BCCSPLAT_WITH_IMAGE
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#endif

namespace bcc4 {

#ifdef BCCSPLAT_WITH_IMAGE
namespace {

constexpr int most_pixels = 65536; // a side

void read_pixels(Imf::InputFile& file, const std::string& path, HostPicture& out) {
  const auto& display = file.header().displayWindow();
  const auto& data = file.header().dataWindow();
  const int width = display.max.x - display.min.x + 1, height = display.max.y - display.min.y + 1;
  if (width < 1 || height < 1 || width > most_pixels || height > most_pixels)
    fail_input(path, ": a picture of ", width, " x ", height, " pixels");
  out.width = static_cast<uint32_t>(width), out.height = static_cast<uint32_t>(height);
  const Imf::ChannelList& channels = file.header().channels();
  for (const char* name : {"R", "G", "B"})
    if (!channels.findChannel(name)) fail_input(path, ": there is no channel ", name);
  // Our own pictures have it in a layer.
  const char* const depth = channels.findChannel("Z") ? "Z" : "depth.Z";
  const bool with_depth = channels.findChannel(depth) != nullptr;
  const size_t pixels = size_t{out.width} * out.height;
  out.rgba.assign(4 * pixels, 0);
  if (with_depth) out.depth.assign(pixels, std::numeric_limits<float>::infinity());
  // The data window, whole, and of it what is displayed.
  const size_t columns = static_cast<size_t>(data.max.x - data.min.x) + 1,
               rows = static_cast<size_t>(data.max.y - data.min.y) + 1;
  if (columns > most_pixels || rows > most_pixels) fail_input(path, ": its data window is too large");
  std::vector<float> plane(5 * columns * rows);
  Imf::FrameBuffer buffer;
  const char* const names[] = {"R", "G", "B", "A", depth};
  for (size_t c = 0; c < 5; ++c) {
    // Without a channel its fill value: opaque.
    char* const base =
        reinterpret_cast<char*>(plane.data() + c) -
        5 * sizeof(float) *
            (static_cast<ptrdiff_t>(data.min.y) * static_cast<ptrdiff_t>(columns) + data.min.x);
    buffer.insert(names[c],
                  Imf::Slice(Imf::FLOAT, base, 5 * sizeof(float), 5 * sizeof(float) * columns, 1, 1, 1));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(data.min.y, data.max.y);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int i = x + display.min.x - data.min.x, j = y + display.min.y - data.min.y;
      if (i < 0 || j < 0 || i >= static_cast<int>(columns) || j >= static_cast<int>(rows)) continue;
      const float* from = plane.data() + 5 * (static_cast<size_t>(j) * columns + static_cast<size_t>(i));
      const size_t p = static_cast<size_t>(y) * out.width + static_cast<size_t>(x);
      std::copy_n(from, 4, out.rgba.data() + 4 * p);
      if (with_depth) out.depth[p] = from[4];
    }
}

} // namespace

HostPicture read_host_picture(const std::string& path) {
  HostPicture out;
  try {
    Imf::InputFile file(path.c_str(), 0);
    read_pixels(file, path, out);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    fail_input(path, ": it cannot be read as a flat OpenEXR picture: ", e.what());
  }
  return out;
}
#else
HostPicture read_host_picture(const std::string& path) {
  fail_usage("--over ", path, ": this bcc4 was built without OpenEXR");
}
#endif

} // namespace bcc4
