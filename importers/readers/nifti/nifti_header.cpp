// SPDX-License-Identifier: Apache-2.0
#include "readers/nifti/nifti_header.h"

#include "readers/error.h"
#include "readers/nifti/nifti_reader.h"

namespace bcc4 {
namespace {

uint32_t size_field(std::string_view start, bool swap) {
  char raw[4];
  std::copy_n(start.data(), 4, raw);
  if (swap) std::reverse(raw, raw + 4);
  uint32_t size = 0;
  std::memcpy(&size, raw, 4);
  return size;
}

bool magic_at(std::string_view start, size_t offset, std::string_view magic) {
  return start.size() >= offset + magic.size() && start.substr(offset, magic.size()) == magic;
}

} // namespace

NiftiHeader parse_nifti_header(const std::string& bytes, const std::string& path) {
  if (bytes.size() >= 4) {
    for (const bool swap : {false, true})
      for (const NiftiFields* f : {&kNifti1, &kNifti2})
        if (size_field(bytes, swap) == f->header && bytes.size() >= f->header)
          return NiftiHeader(bytes, *f, swap);
  }
  fail_input(path, ": the NIfTI header is cut off");
}

Type nifti_type(const NiftiHeader& header, const std::string& path) {
  static constexpr std::pair<int, Type> codes[] = {
      {2, Type::u8},   {4, Type::i16},   {8, Type::i32},   {16, Type::f32},   {64, Type::f64},
      {256, Type::i8}, {512, Type::u16}, {768, Type::u32}, {1024, Type::i64}, {1280, Type::u64}};
  const int code = header.at<int16_t>(header.fields().datatype);
  for (const auto& [number, type] : codes)
    if (number == code) return type;
  const char* const parts = code == 32 || code == 1792 || code == 2048 ? "complex numbers: real, imaginary"
                            : code == 128 || code == 2304              ? "colours: red, green, blue"
                                                                       : "";
  fail_input(path, ": NIfTI data type ", code, " cannot be read; integers and floats up to 64 bits can",
             *parts ? concat(" (it holds ", parts, "; write each part to a file of its own)") : "");
}

bool is_nifti(std::string_view start) {
  if (start.size() < 348) return false;
  for (const bool swap : {false, true}) {
    const uint32_t size = size_field(start, swap);
    if (size == 348 && (magic_at(start, 344, std::string_view("n+1\0", 4)) ||
                        magic_at(start, 344, std::string_view("ni1\0", 4))))
      return true;
    if (size == 540 && (magic_at(start, 4, std::string_view("n+2\0\r\n\032\n", 8)) ||
                        magic_at(start, 4, std::string_view("ni2\0\r\n\032\n", 8))))
      return true;
  }
  return false;
}

bool is_analyze(std::string_view start) {
  return start.size() >= 348 && (size_field(start, false) == 348 || size_field(start, true) == 348) &&
         !is_nifti(start);
}

} // namespace bcc4
