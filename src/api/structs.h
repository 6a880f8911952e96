// SPDX-License-Identifier: Apache-2.0
// Size-tagged structs across versions of the header.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "api/guard.h"

namespace bccsplat::api {

// No struct of any version is longer: a larger size was never set.
inline constexpr size_t longest_struct = 1 << 16;

// The caller's struct as this version knows it: missing fields are zero; a tail this version does not know
// must be zero. NULL gives all defaults.
template<class T> [[nodiscard]] T read_struct(const T* in, const char* name) {
  T out{};
  out.struct_size = sizeof(T);
  if (!in) return out;
  const size_t size = in->struct_size;
  if (size < 2 * sizeof(uint32_t) || size > longest_struct)
    fail(Code::invalid_struct_size, name, ": struct_size is ", size, "; set it to sizeof the struct");
  const auto* bytes = reinterpret_cast<const unsigned char*>(in);
  for (size_t i = sizeof(T); i < size; ++i)
    if (bytes[i] != 0)
      fail(Code::invalid_struct_size, name, ": byte ", i, " is set but this library knows ", sizeof(T),
           " bytes; update the library");
  std::memcpy(&out, in, std::min(size, sizeof(T)));
  out.struct_size = sizeof(T);
  return out;
}

// Fills as much of the caller's struct as it holds; its struct_size stays.
template<class T> void write_struct(T* out, const T& value, const char* name) {
  require(out, name);
  const uint32_t size = out->struct_size;
  if (size < 2 * sizeof(uint32_t))
    fail(Code::invalid_struct_size, name, ": struct_size is ", size, "; set it to sizeof the struct");
  std::memcpy(out, &value, std::min<size_t>(size, sizeof(T)));
  out->struct_size = size;
}

// Fails as write_struct would, before any work is done.
template<class T> void check_output(const T* out, const char* name) {
  if (out && out->struct_size < 2 * sizeof(uint32_t))
    fail(Code::invalid_struct_size, name, ": struct_size is ", out->struct_size,
         "; set it to sizeof the struct");
}

// Element i of a caller's array, whose elements are as long as the caller's header made them.
template<class T> [[nodiscard]] const T* element(const T* array, size_t i) {
  return reinterpret_cast<const T*>(reinterpret_cast<const unsigned char*>(array) + i * array->struct_size);
}

inline void require_zero(uint64_t reserved, const char* name) {
  if (reserved != 0) fail(Code::invalid_argument, name, " must be 0");
}

} // namespace bccsplat::api
