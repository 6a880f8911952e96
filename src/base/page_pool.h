// SPDX-License-Identifier: Apache-2.0
// Memory of objects of one size of which there are thousands, such as bricks, in pieces of a large page: the
// first touch of a small page takes longer than filling it. What is given back is used again, so that layers
// that follow each other lie where those before them did.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "base/paged_vector.h"

namespace bccsplat {

// The pieces of some pools, and their lock: what one pool gives back may be the next one's.
class PageStore {
 public:
  PageStore() = default;
  PageStore(const PageStore&) = delete;
  PageStore& operator=(const PageStore&) = delete;
  ~PageStore(); // when all blocks of all pools have been given back

  // Bytes that it has of the system: at most half as much again as the pieces in which blocks are taken, or
  // two pieces more.
  [[nodiscard]] size_t bytes() const;
  // Keeps nothing for later from now on.
  void close() noexcept;
  // For a fork, whose child finds the lock as it was: nobody takes or gives between the two.
  void lock() const { mutex_.lock(); }
  void unlock() const { mutex_.unlock(); }

 private:
  friend class PagePool;
  // Under the lock.
  [[nodiscard]] void* take();
  void give_back(void* piece) noexcept;

  mutable std::mutex mutex_;
  bool keeps_ = true;
  std::vector<void*> empty_;
  size_t taken_ = 0;
};

// Blocks begin on a cache line. Calls may be concurrent.
class PagePool {
 public:
  // block: bytes, far fewer than a piece has. The store must outlive the pool.
  PagePool(size_t block, PageStore& store);

  // Throws std::bad_alloc.
  [[nodiscard]] void* take();
  void give_back(void* block) noexcept;

 private:
  struct Piece;
  void unlink(Piece* piece);
  void link(Piece* piece);

  size_t block_, blocks_; // of a piece
  PageStore& store_;
  Piece* open_ = nullptr; // pieces that have room
};

// Returns the store of this process and of the children that it forks. Objects may outlive what is static: at
// the end of the process, or of the library in it, the store is closed and stays.
[[nodiscard]] PageStore& process_pages();

template<class T> struct PooledAllocator {
  using value_type = T;
  PooledAllocator() = default;
  template<class U> PooledAllocator(const PooledAllocator<U>&) {} // to that of another type
  T* allocate(size_t /*one*/) { return static_cast<T*>(pool.take()); }
  void deallocate(T* object, size_t /*one*/) noexcept { pool.give_back(object); }
  friend bool operator==(const PooledAllocator&, const PooledAllocator&) { return true; }

 private:
  // There from the start: no fork meets it half made.
  static inline PagePool pool{sizeof(T), process_pages()};
};

// As std::make_shared_for_overwrite, of a type with thousands of objects. Address sanitizer, which looks at
// each object, and browsers, which have no pages, get it of the heap.
template<class T> [[nodiscard]] std::shared_ptr<T> make_pooled_for_overwrite() {
#if defined(__EMSCRIPTEN__) || defined(__SANITIZE_ADDRESS__)
  return std::make_shared_for_overwrite<T>();
#else
  return std::allocate_shared_for_overwrite<T>(PooledAllocator<T>());
#endif
}

} // namespace bccsplat
