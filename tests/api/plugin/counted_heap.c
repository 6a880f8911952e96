/* SPDX-License-Identifier: Apache-2.0 */
#include "counted_heap.h"

#include <errno.h>
#include <malloc.h>
#include <stddef.h>

/* The GNU C library's own, under their other names. */
extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);
extern void __libc_free(void*);

static long blocks, bytes, peak;

#pragma GCC visibility push(default) /* or the libraries would call the C library's */

static void* taken(void* block) {
  long now, most;
  if (!block) return block;
  __atomic_add_fetch(&blocks, 1, __ATOMIC_RELAXED);
  now = __atomic_add_fetch(&bytes, (long)malloc_usable_size(block), __ATOMIC_RELAXED);
  most = __atomic_load_n(&peak, __ATOMIC_RELAXED);
  while (now > most && !__atomic_compare_exchange_n(&peak, &most, now, 1, __ATOMIC_RELAXED, __ATOMIC_RELAXED))
    ;
  return block;
}
static void given(void* block) {
  if (!block) return;
  __atomic_sub_fetch(&blocks, 1, __ATOMIC_RELAXED);
  __atomic_sub_fetch(&bytes, (long)malloc_usable_size(block), __ATOMIC_RELAXED);
}

void* malloc(size_t n) { return taken(__libc_malloc(n)); }
void* calloc(size_t n, size_t size) { return taken(__libc_calloc(n, size)); }
void* memalign(size_t alignment, size_t n) { return taken(__libc_memalign(alignment, n)); }
void* aligned_alloc(size_t alignment, size_t n) { return taken(__libc_memalign(alignment, n)); }
int posix_memalign(void** out, size_t alignment, size_t n) {
  void* block = taken(__libc_memalign(alignment, n));
  if (!block) return ENOMEM;
  *out = block;
  return 0;
}
void free(void* block) {
  given(block);
  __libc_free(block);
}
void* realloc(void* block, size_t n) {
  const long before = block ? (long)malloc_usable_size(block) : 0;
  void* moved = __libc_realloc(block, n);
  if (!moved && n > 0) return moved; /* the old block stays */
  if (block) {
    __atomic_sub_fetch(&blocks, 1, __ATOMIC_RELAXED);
    __atomic_sub_fetch(&bytes, before, __ATOMIC_RELAXED);
  }
  return taken(moved);
}

#pragma GCC visibility pop

long heap_blocks(void) { return __atomic_load_n(&blocks, __ATOMIC_RELAXED); }
long heap_bytes(void) { return __atomic_load_n(&bytes, __ATOMIC_RELAXED); }
long heap_peak(void) { return __atomic_load_n(&peak, __ATOMIC_RELAXED); }
void heap_reset_peak(void) { __atomic_store_n(&peak, heap_bytes(), __ATOMIC_RELAXED); }
