// SPDX-License-Identifier: Apache-2.0
// Vectors of gigabytes, in pages as large as the machine has: giving a thousand small pages back takes longer
// than all else of a call that is cancelled (tests/bench/notes/interaction.md).
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace bccsplat {

inline constexpr size_t large_page = size_t{2} << 20; // bytes

// Asks the system for large pages, where it has such a wish.
void prefer_large_pages(void* memory, size_t bytes);

// Memory of a large page that begins at a multiple of its size, of the system itself: heaps break up such
// places. Throws std::bad_alloc.
[[nodiscard]] void* take_large_page();
void give_back_large_page(void* memory) noexcept;

template<class T> struct PagedAllocator {
  using value_type = T;
  PagedAllocator() = default;
  template<class U> explicit PagedAllocator(const PagedAllocator<U>&) {}
  T* allocate(size_t count) {
    const size_t bytes = count * sizeof(T);
    if (bytes < least_bytes) return static_cast<T*>(::operator new(bytes));
    void* const memory = ::operator new (bytes, std::align_val_t{large_page});
    prefer_large_pages(memory, bytes);
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, size_t count) {
    if (count * sizeof(T) < least_bytes)
      ::operator delete(memory);
    else
      ::operator delete (memory, std::align_val_t{large_page});
  }
  friend bool operator==(const PagedAllocator&, const PagedAllocator&) { return true; }

 private:
  static constexpr size_t least_bytes = 2 * large_page;
};

template<class T> using PagedVector = std::vector<T, PagedAllocator<T>>;

} // namespace bccsplat
