// SPDX-License-Identifier: Apache-2.0
#include "base/paged_vector.h"

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace bccsplat {

void prefer_large_pages([[maybe_unused]] void* memory, [[maybe_unused]] size_t bytes) {
#ifdef MADV_HUGEPAGE
  // If refused, the memory is as it would have been. The rest of a page at the end stays in small ones.
  (void)madvise(memory, bytes / large_page * large_page, MADV_HUGEPAGE);
#endif
}

} // namespace bccsplat
