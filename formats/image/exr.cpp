// SPDX-License-Identifier: Apache-2.0
// Writes pictures and deep pictures with OpenEXR, through a sink that only a finished file leaves behind.
#include "formats/image/exr.h"

#include <algorithm>

#include "base/error.h"
#include "formats/image/sink_buffer.h"

#if defined(BCCSPLAT_WITH_IMAGE)

#include <ImathMatrix.h>
#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepImageStateAttribute.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfRational.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>

namespace bccsplat {
namespace {

Imath::M44f matrix(const std::array<double, 16>& rows) {
  Imath::M44f m;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) m[r][c] = static_cast<float>(rows[4 * r + c]);
  return m;
}

// A stream for OpenEXR on top of a sink.
class SinkStream : public Imf::OStream {
 public:
  SinkStream(SinkBuffer& sink, const char* name) : Imf::OStream(name), sink_(sink) {}
  void write(const char bytes[], int count) override {
    sink_.write(position_, std::as_bytes(std::span(bytes, count)));
    position_ += count;
  }
  uint64_t tellp() override { return position_; }
  void seekp(uint64_t position) override { position_ = position; }

 private:
  SinkBuffer& sink_;
  uint64_t position_ = 0;
};

Imf::Header make_header(int width, int height, const ExrOptions& options) {
  Imf::Header header(width, height);
  if (options.frames_per_second[1] > 0)
    Imf::addFramesPerSecond(header,
                            Imf::Rational(options.frames_per_second[0], options.frames_per_second[1]));
  if (options.exposure_seconds > 0) Imf::addExpTime(header, static_cast<float>(options.exposure_seconds));
  if (!options.comments.empty()) Imf::addComments(header, options.comments);
  if (options.view) {
    Imf::addWorldToCamera(header, matrix(options.view->world_to_camera));
    Imf::addWorldToNDC(header, matrix(options.view->world_to_ndc));
    header.screenWindowWidth() = static_cast<float>(options.view->screen_width);
  }
  for (const auto& [key, value] : options.attributes) header.insert(key, Imf::StringAttribute(value));
  return header;
}

// `write` fills the stream and must close OpenEXR's file, whose destructor writes the table of lines, and
// says nothing where it cannot.
template<class Write> void write_stream(ByteSink& sink, const std::string& name, const Write& write) {
  try {
    SinkBuffer buffer(sink);
    SinkStream stream(buffer, name.c_str());
    write(stream);
    buffer.finish();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    fail(Code::io_error, name, ": cannot write OpenEXR: ", e.what());
  }
}

// Rows that are written between two looks at the progress: whole blocks of ZIP.
constexpr int rows_at_once = 16;

void report_rows(const ExrOptions& options, int done, int height) {
  if (options.progress) options.progress->report(static_cast<double>(done) / height);
}

} // namespace

void write_exr(ByteSink& sink, const std::string& name, int width, int height,
               std::span<const ExrChannel> channels, const ExrOptions& options) {
  write_stream(sink, name, [&](Imf::OStream& stream) {
    Imf::Header header = make_header(width, height, options);
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer frame;
    for (const ExrChannel& c : channels) {
      header.channels().insert(c.name, Imf::Channel(Imf::FLOAT));
      // OpenEXR does not write through this pointer.
      auto* pixels = reinterpret_cast<char*>(const_cast<float*>(c.pixels));
      frame.insert(c.name, Imf::Slice(Imf::FLOAT, pixels, c.pixel_floats * sizeof(float),
                                      static_cast<size_t>(c.row_floats) * sizeof(float)));
    }
    Imf::OutputFile file(stream, header, 0);
    file.setFrameBuffer(frame);
    for (int y = 0; y < height; y += rows_at_once) {
      report_rows(options, y, height);
      file.writePixels(std::min(rows_at_once, height - y));
    }
  });
}

void write_deep_exr(ByteSink& sink, const std::string& name, int width, int height,
                    std::span<const uint64_t> first, std::span<const float> samples,
                    const ExrOptions& options) {
  constexpr std::array<const char*, 6> names{"Z", "ZBack", "A", "R", "G", "B"};
  write_stream(sink, name, [&](Imf::OStream& stream) {
    Imf::Header header = make_header(width, height, options);
    header.compression() = Imf::ZIPS_COMPRESSION;
    header.setType(Imf::DEEPSCANLINE);
    Imf::addDeepImageState(header, Imf::DIS_TIDY);
    for (const char* channel : names) header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
    // One row is written at a time, from tables of one row: the step from row to row is 0 bytes.
    const size_t columns = width;
    std::vector<uint32_t> counts(columns);
    std::array<std::vector<const float*>, names.size()> row;
    Imf::DeepFrameBuffer frame;
    frame.insertSampleCountSlice(
        Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts.data()), sizeof(uint32_t), 0));
    for (size_t c = 0; c < names.size(); ++c) {
      row[c].resize(columns);
      frame.insert(names[c], Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(row[c].data()),
                                            sizeof(const float*), 0, names.size() * sizeof(float)));
    }
    Imf::DeepScanLineOutputFile file(stream, header, 0);
    file.setFrameBuffer(frame);
    for (size_t y = 0; y < static_cast<size_t>(height); ++y) {
      report_rows(options, static_cast<int>(y), height);
      for (size_t x = 0; x < columns; ++x) {
        const uint64_t begin = first[y * columns + x], end = first[y * columns + x + 1];
        counts[x] = static_cast<uint32_t>(end - begin);
        for (size_t c = 0; c < names.size(); ++c) row[c][x] = samples.data() + begin * names.size() + c;
      }
      file.writePixels(1);
    }
  });
}

} // namespace bccsplat

#else

namespace bccsplat {

void write_exr(ByteSink&, const std::string& name, int, int, std::span<const ExrChannel>, const ExrOptions&) {
  fail(Code::missing_feature, name, ": built without image files (BCCSPLAT_WITH_IMAGE)");
}

void write_deep_exr(ByteSink&, const std::string& name, int, int, std::span<const uint64_t>,
                    std::span<const float>, const ExrOptions&) {
  fail(Code::missing_feature, name, ": built without image files (BCCSPLAT_WITH_IMAGE)");
}

} // namespace bccsplat

#endif

namespace bccsplat {

void write_exr(const std::string& path, int width, int height, std::span<const ExrChannel> channels,
               const ExrOptions& options) {
  const auto sink = create_file_sink(path, options.overwrite);
  write_exr(*sink, path, width, height, channels, options);
  sink->commit();
}

void write_deep_exr(const std::string& path, int width, int height, std::span<const uint64_t> first,
                    std::span<const float> samples, const ExrOptions& options) {
  const auto sink = create_file_sink(path, options.overwrite);
  write_deep_exr(*sink, path, width, height, first, samples, options);
  sink->commit();
}

} // namespace bccsplat
