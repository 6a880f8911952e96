// SPDX-License-Identifier: Apache-2.0
// Overflow-safe arithmetic on sizes that come from files or callers.
#pragma once

#include <cstdint>
#include <initializer_list>

#include "base/error.h"

namespace bccsplat {

[[nodiscard]] inline uint64_t checked_mul(uint64_t a, uint64_t b) {
  uint64_t r;
  if (__builtin_mul_overflow(a, b, &r)) fail(Code::limit_exceeded, "size overflow: ", a, " x ", b);
  return r;
}

[[nodiscard]] inline uint64_t checked_add(uint64_t a, uint64_t b) {
  uint64_t r;
  if (__builtin_add_overflow(a, b, &r)) fail(Code::limit_exceeded, "size overflow: ", a, " + ", b);
  return r;
}

[[nodiscard]] inline uint64_t checked_product(std::initializer_list<uint64_t> factors) {
  uint64_t r = 1;
  for (const uint64_t f : factors) r = checked_mul(r, f);
  return r;
}

} // namespace bccsplat
