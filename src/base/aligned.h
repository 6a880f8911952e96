// SPDX-License-Identifier: Apache-2.0
// Arrays that start on a cache line.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>
#include <span>

namespace bccsplat {

template<class T> class AlignedArray {
 public:
  AlignedArray() = default;
  // Keeps the memory when it suffices; the contents are undefined.
  void reserve(size_t count) {
    if (count <= capacity_) return;
    data_.reset(static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{64})));
    capacity_ = count;
  }
  // Grows as reserve does, but the first `used` elements are kept.
  void grow(size_t count, size_t used) {
    if (count <= capacity_) return;
    AlignedArray larger;
    larger.reserve(std::max(count, 2 * capacity_));
    std::copy_n(data_.get(), used, larger.data_.get());
    *this = std::move(larger);
  }
  [[nodiscard]] T* data() const { return data_.get(); }
  [[nodiscard]] size_t capacity() const { return capacity_; }

 private:
  struct Free {
    void operator()(T* p) const { ::operator delete (p, std::align_val_t{64}); }
  };
  std::unique_ptr<T, Free> data_;
  size_t capacity_ = 0;
};

} // namespace bccsplat
