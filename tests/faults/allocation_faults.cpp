// SPDX-License-Identifier: Apache-2.0
// Stands in for malloc and its like, also in libraries that the program loads; sanitizers own malloc, so that
// with them it stands in for operator new alone.
#include "allocation_faults.h"

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <new>

namespace {

std::atomic<bool> armed{false}, keep_failing{false};
std::atomic<uint64_t> counted{0}, failing{0};
std::atomic<int64_t> live{0};

// Counts an allocation; true: it is to fail.
bool fails() {
  if (!armed.load(std::memory_order_relaxed)) return false;
  const uint64_t n = counted.fetch_add(1), f = failing.load();
  return n == f || (n > f && keep_failing.load());
}

} // namespace

namespace faults {

void fail_allocation(uint64_t n, bool all_after) {
  counted = 0, failing = n, keep_failing = all_after;
  armed = true;
}

uint64_t stop_failing() {
  armed = false;
  return counted;
}

int64_t live_allocations() { return live; }

} // namespace faults

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

// The sanitizer owns malloc; it looks for leaks itself.
static void* allocate(std::size_t size, std::size_t alignment) {
  if (fails()) return nullptr;
  void* p = nullptr;
  if (alignment <= alignof(std::max_align_t))
    p = std::malloc(size);
  else if (posix_memalign(&p, alignment, size) != 0)
    p = nullptr;
  live += p != nullptr;
  return p;
}
static void release(void* p) {
  live -= p != nullptr;
  std::free(p);
}

void* operator new(std::size_t size) {
  if (void* p = allocate(size, 1)) return p;
  throw std::bad_alloc();
}
void* operator new[](std::size_t size) { return operator new(size); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  if (void* p = allocate(size, static_cast<std::size_t>(alignment))) return p;
  throw std::bad_alloc();
}
void* operator new[](std::size_t size, std::align_val_t alignment) { return operator new(size, alignment); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return allocate(size, 1); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return allocate(size, 1); }
void operator delete(void* p) noexcept { release(p); }
void operator delete[](void* p) noexcept { release(p); }
void operator delete(void* p, std::size_t) noexcept { release(p); }
void operator delete[](void* p, std::size_t) noexcept { release(p); }
void operator delete(void* p, std::align_val_t) noexcept { release(p); }
void operator delete[](void* p, std::align_val_t) noexcept { release(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { release(p); }
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept { release(p); }

#else

// glibc lets a program bring its own malloc family, for the shared libraries it loads too.
extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

static void* counted_block(void* p) {
  live += p != nullptr;
  return p;
}
static void* no_memory() {
  errno = ENOMEM;
  return nullptr;
}

void* malloc(std::size_t size) { return fails() ? no_memory() : counted_block(__libc_malloc(size)); }
void* calloc(std::size_t n, std::size_t size) {
  return fails() ? no_memory() : counted_block(__libc_calloc(n, size));
}
void* realloc(void* old, std::size_t size) {
  if (fails()) return no_memory();
  void* p = __libc_realloc(old, size);
  live += (p != nullptr) - (old != nullptr && (p != nullptr || size == 0));
  return p;
}
void* memalign(std::size_t alignment, std::size_t size) {
  return fails() ? no_memory() : counted_block(__libc_memalign(alignment, size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }
int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  if (fails()) return ENOMEM;
  void* p = counted_block(__libc_memalign(alignment, size));
  if (!p) return ENOMEM;
  *out = p;
  return 0;
}
void free(void* p) {
  live -= p != nullptr;
  __libc_free(p);
}

} // extern "C"

#endif
