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
