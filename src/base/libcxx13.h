// SPDX-License-Identifier: Apache-2.0
// Parts of C++20 that the core uses and the standard library of Debian 12's emscripten (libc++ 13) lacks.
// This file is included before every file of a build for browsers, which has one thread.
#pragma once

#ifdef __cplusplus
#include <version>
#if defined(_LIBCPP_VERSION) && _LIBCPP_VERSION < 14000

#include <algorithm>
#include <cstddef>
#include <memory>
#include <type_traits>

namespace std {

template<class To, class From> constexpr To bit_cast(const From& from) noexcept {
  static_assert(sizeof(To) == sizeof(From));
  return __builtin_bit_cast(To, from);
}

template<class T> shared_ptr<T> make_shared_for_overwrite() { return shared_ptr<T>(new T); }
template<class T> unique_ptr<T> make_unique_for_overwrite(size_t count) {
  return unique_ptr<T>(new remove_extent_t<T>[count]);
}

template<class T> struct atomic_ref {
  explicit atomic_ref(T& of) : of_(of) {}
  template<class Order> T fetch_add(T by, Order /*order*/) const {
    return __atomic_fetch_add(&of_, by, __ATOMIC_RELAXED);
  }

 private:
  T& of_;
};

namespace ranges {
template<class Range, class Test> bool all_of(const Range& range, Test test) {
  return std::all_of(range.begin(), range.end(), test);
}
} // namespace ranges

} // namespace std

#endif
#endif
