// SPDX-License-Identifier: Apache-2.0
// The fixed fields of a NIfTI-1 or NIfTI-2 header, in either byte order.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

#include "readers/text.h"
#include "readers/value_type.h"

namespace bcc4 {

// Byte offsets of the fields in the two versions.
struct NiftiFields {
  size_t header, dim, datatype, pixdim, vox_offset, slope, inter, units, toffset, qform, sform, quatern,
      qoffset, srow, text, intent, intent_name;
  bool wide; // NIfTI-2: dims are i64, floats f64, codes i32
};
inline constexpr NiftiFields kNifti1{348, 40,  70,  76,  108, 112, 116, 123, 136,
                                     252, 254, 256, 268, 280, 148, 68,  328, false};
inline constexpr NiftiFields kNifti2{540, 16,  12,  104, 168, 176, 184, 500, 216,
                                     344, 348, 352, 376, 400, 240, 504, 508, true};

class NiftiHeader {
 public:
  NiftiHeader(std::string bytes, const NiftiFields& fields, bool swap)
      : bytes_(std::move(bytes)), f_(fields), swap_(swap) {}
  [[nodiscard]] const NiftiFields& fields() const { return f_; }
  [[nodiscard]] bool swapped() const { return swap_; }
  template<class T> [[nodiscard]] T at(size_t offset) const {
    char raw[sizeof(T)];
    std::copy_n(bytes_.data() + offset, sizeof(T), raw);
    if (swap_) std::reverse(raw, raw + sizeof(T));
    T value;
    std::memcpy(&value, raw, sizeof value);
    return value;
  }
  [[nodiscard]] int64_t dim(size_t i) const {
    return f_.wide ? at<int64_t>(f_.dim + 8 * i) : at<int16_t>(f_.dim + 2 * i);
  }
  [[nodiscard]] double real(size_t offset, size_t i = 0) const {
    return f_.wide ? at<double>(offset + 8 * i) : static_cast<double>(at<float>(offset + 4 * i));
  }
  // Returns a float as the decimal number it was made from: 2.54, not 2.5399999618530273.
  [[nodiscard]] double decimal(size_t offset, size_t i = 0) const {
    if (f_.wide) return real(offset, i);
    return parse_number<double>(concat(at<float>(offset + 4 * i))).value_or(real(offset, i));
  }
  [[nodiscard]] int code(size_t offset) const { return f_.wide ? at<int32_t>(offset) : at<int16_t>(offset); }
  [[nodiscard]] int units() const {
    return f_.wide ? at<int32_t>(f_.units) : static_cast<int>(at<uint8_t>(f_.units));
  }
  // Returns a text of at most `most` bytes, which ends before.
  [[nodiscard]] std::string text(size_t offset, size_t most) const {
    const std::string_view field = std::string_view(bytes_).substr(offset, most);
    return std::string(trim(field.substr(0, field.find('\0'))));
  }
  [[nodiscard]] double vox_offset() const {
    return f_.wide ? static_cast<double>(at<int64_t>(f_.vox_offset)) : real(f_.vox_offset);
  }

 private:
  std::string bytes_;
  NiftiFields f_;
  bool swap_;
};

// Throws for a header that is cut off.
[[nodiscard]] NiftiHeader parse_nifti_header(const std::string& bytes, const std::string& path);

} // namespace bcc4
