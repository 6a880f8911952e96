// SPDX-License-Identifier: Apache-2.0
// Pages are one strip each, not packed. Files that may grow beyond 4 GB are BigTIFF. The steps of the grid
// and of time stand where ImageJ has them; where the grid lies in the world TIFF has no place for.
#include "tool/output/tiff_output.h"

#include <tiffio.h>

#include <cmath>

#include "readers/calendar.h"
#include "readers/error.h"
#include "readers/text.h"

namespace bcc4 {
namespace {

double step_of(const Affine& m, size_t a) { return std::hypot(m[a], m[4 + a], m[8 + a]); }

std::string description(const VolumeOutput& o) {
  const uint64_t frames = o.series ? o.times.size() : 1;
  std::string text = concat(
      "ImageJ=1.53t\nimages=", o.dims[2] * frames, "\nslices=", o.dims[2], "\nframes=", frames,
      "\nhyperstack=true\nmode=grayscale\nspacing=", step_of(o.affine, 2),
      "\nunit=", o.spatial_unit.empty() ? "pixel" : o.spatial_unit, "\n"); // without one no step counts
  if (frames > 1) {
    const double step = (o.times.back() - o.times[0]) / static_cast<double>(frames - 1);
    const auto seconds = seconds_in(o.time_unit);
    text += concat("finterval=", step * seconds.value_or(1), "\ntunit=", seconds ? "sec" : o.time_unit, "\n");
  }
  return text + "loop=false\n";
}

class TiffOutputFile : public VolumeFile {
 public:
  TiffOutputFile(const std::string& path, const std::string& name, const VolumeOutput& o)
      : name_(name), o_(o), plane_bytes_(o.dims[0] * o.dims[1] * type_size(o.type)) {
    constexpr uint64_t most = uint64_t{4'000'000'000}, of_page = 512; // its fields
    const uint64_t pages = o.dims[2] * (o.series ? o.times.size() : 1);
    TIFFSetErrorHandler(nullptr); // reports are made here
    TIFFSetWarningHandler(nullptr);
    tiff_ = TIFFOpen(path.c_str(), (plane_bytes_ + of_page) * pages > most ? "w8" : "w");
    if (!tiff_) fail_writing();
  }
  TiffOutputFile(const TiffOutputFile&) = delete;
  TiffOutputFile& operator=(const TiffOutputFile&) = delete;
  ~TiffOutputFile() override {
    if (tiff_) TIFFClose(tiff_);
  }

  void write(std::span<const std::byte> planes) override {
    for (; !planes.empty(); planes = planes.subspan(plane_bytes_)) write_page(planes.first(plane_bytes_));
  }
  void finish() override {
    if (TIFFFlush(tiff_) == 0) fail_writing();
    TIFFClose(tiff_);
    tiff_ = nullptr;
  }

 private:
  [[noreturn]] void fail_writing() const {
    fail_resources(name_, ": libtiff cannot write it: is the disk full?");
  }

  void write_page(std::span<const std::byte> plane) {
    constexpr int bits_of_byte = 8;
    const int format = is_float(o_.type) ? SAMPLEFORMAT_IEEEFP
                       : o_.type == Type::i8 || o_.type == Type::i16 || o_.type == Type::i32
                           ? SAMPLEFORMAT_INT
                           : SAMPLEFORMAT_UINT;
    TIFFSetField(tiff_, TIFFTAG_IMAGEWIDTH, static_cast<uint32_t>(o_.dims[0]));
    TIFFSetField(tiff_, TIFFTAG_IMAGELENGTH, static_cast<uint32_t>(o_.dims[1]));
    TIFFSetField(tiff_, TIFFTAG_ROWSPERSTRIP, static_cast<uint32_t>(o_.dims[1]));
    TIFFSetField(tiff_, TIFFTAG_BITSPERSAMPLE, static_cast<int>(type_size(o_.type)) * bits_of_byte);
    TIFFSetField(tiff_, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff_, TIFFTAG_SAMPLEFORMAT, format);
    TIFFSetField(tiff_, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff_, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff_, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
    TIFFSetField(tiff_, TIFFTAG_RESOLUTIONUNIT, RESUNIT_NONE);
    TIFFSetField(tiff_, TIFFTAG_XRESOLUTION, 1 / step_of(o_.affine, 0)); // samples a unit
    TIFFSetField(tiff_, TIFFTAG_YRESOLUTION, 1 / step_of(o_.affine, 1));
    if (page_++ == 0) TIFFSetField(tiff_, TIFFTAG_IMAGEDESCRIPTION, description(o_).c_str());
    auto* const bytes = const_cast<std::byte*>(plane.data()); // in the file's order, which is the machine's
    if (TIFFWriteEncodedStrip(tiff_, 0, bytes, static_cast<tmsize_t>(plane.size())) < 0 ||
        TIFFWriteDirectory(tiff_) == 0)
      fail_writing();
  }

  std::string name_;
  VolumeOutput o_;
  size_t plane_bytes_;
  TIFF* tiff_ = nullptr;
  uint64_t page_ = 0;
};

} // namespace

std::unique_ptr<VolumeFile> create_tiff(const std::string& path, const std::string& name,
                                        const VolumeOutput& output) {
  return std::make_unique<TiffOutputFile>(path, name, output);
}

} // namespace bcc4
