// SPDX-License-Identifier: Apache-2.0
// The data types of the format, and channels made of two parts of a voxel.
#include "readers/nifti/nifti_values.h"

#include <algorithm>
#include <cmath>

#include "readers/error.h"

namespace bcc4 {
namespace {

struct ScalarCode {
  int code;
  Type type;
};
constexpr ScalarCode kScalars[] = {{2, Type::u8},     {4, Type::i16},   {8, Type::i32},   {16, Type::f32},
                                   {64, Type::f64},   {256, Type::i8},  {512, Type::u16}, {768, Type::u32},
                                   {1024, Type::i64}, {1280, Type::u64}};

enum class Part : uint8_t { real, imaginary, magnitude, phase };
const std::vector<std::string> kParts{"real", "imaginary", "magnitude", "phase"};

float part_of(Part part, double real, double imaginary) {
  switch (part) {
  case Part::real:
    return static_cast<float>(real);
  case Part::imaginary:
    return static_cast<float>(imaginary);
  case Part::magnitude:
    return static_cast<float>(std::hypot(real, imaginary));
  case Part::phase:
    break;
  }
  return static_cast<float>(std::atan2(imaginary, real));
}

class ComplexReader : public FrameReader {
 public:
  ComplexReader(SeriesDescription description, DenseSeries series, std::vector<Part> parts)
      : description_(std::move(description)), series_(std::move(series)), parts_(std::move(parts)) {}
  const SeriesDescription& description() const override { return description_; }
  std::string frame_name(uint64_t frame) const override { return series_.path_of(frame); }

  Frame read(uint64_t frame, size_t channel) override {
    const Part part = parts_[channel];
    if (part == Part::real || part == Part::imaginary) return series_.read(frame, part == Part::real ? 0 : 1);
    const Frame real = series_.read(frame, 0), imaginary = series_.read(frame, 1);
    const auto& d = description_.dims;
    const uint64_t plane = d[0] * d[1];
    std::vector<double> re(plane), im(plane);
    auto bytes = std::make_shared<Bytes>(plane * d[2] * sizeof(float));
    for (uint64_t z = 0; z < d[2]; ++z) {
      gather_plane(real, d, z, 0, re.data());
      gather_plane(imaginary, d, z, 0, im.data());
      for (uint64_t i = 0; i < plane; ++i) {
        const float value = part_of(part, re[i], im[i]);
        std::memcpy(bytes->data() + (z * plane + i) * sizeof value, &value, sizeof value);
      }
    }
    return dense_frame(Type::f32, std::move(bytes),
                       {{AxisRole::x, d[0]}, {AxisRole::y, d[1]}, {AxisRole::z, d[2]}});
  }

 private:
  SeriesDescription description_;
  DenseSeries series_;
  std::vector<Part> parts_;
};

} // namespace

NiftiValues nifti_values(const NiftiHeader& header, const std::string& path) {
  constexpr int complex_f32 = 32, rgb = 128, complex_f64 = 1792, rgba = 2304;
  const int code = header.at<int16_t>(header.fields().datatype);
  for (const auto& [number, type] : kScalars)
    if (number == code) return {type};
  if (code == complex_f32) return {Type::f32, 2, {"real", "imaginary"}};
  if (code == complex_f64) return {Type::f64, 2, {"real", "imaginary"}};
  if (code == rgb) return {Type::u8, 3, {"red", "green", "blue"}};
  if (code == rgba) return {Type::u8, 4, {"red", "green", "blue", "alpha"}};
  fail_input(path, ": NIfTI data type ", code,
             " cannot be read; integers, floats and complex numbers of 64 bits a part and colours can");
}

std::unique_ptr<FrameReader> open_complex(SeriesDescription d, DenseSeries series,
                                          const ReaderOptions& options, const std::string& path,
                                          const Channel& kind) {
  const std::vector<std::string> wanted =
      options.channels.empty() ? std::vector<std::string>{kParts[0], kParts[1]} : options.channels;
  std::vector<Part> parts;
  for (const std::string& name : wanted) {
    const auto found = std::find(kParts.begin(), kParts.end(), name);
    if (found == kParts.end())
      fail_usage("--channel ", name, ": ", path, " holds complex numbers: ", join(kParts, " or "),
                 did_you_mean(name, kParts));
    parts.push_back(static_cast<Part>(found - kParts.begin()));
    Channel& channel = d.channels.emplace_back(kind);
    channel.name = name;
    channel.type = series.frame_type();
    if (parts.back() != Part::magnitude && parts.back() != Part::phase) continue;
    channel.type = channel.precision = Type::f32; // made of two numbers, in no steps
    channel.step = channel.offset = 0;
    if (parts.back() == Part::phase) channel.unit = "rad";
  }
  return std::make_unique<ComplexReader>(std::move(d), std::move(series), std::move(parts));
}

} // namespace bcc4
