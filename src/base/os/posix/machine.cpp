// SPDX-License-Identifier: Apache-2.0
#include "base/machine.h"

#include <dlfcn.h>
#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <new>
#include <string>

#include "base/paged_vector.h"

namespace bccsplat {

uint64_t machine_memory() {
  const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
  if (pages <= 0 || page <= 0) return uint64_t{1} << 30;
  return static_cast<uint64_t>(pages) * page;
}

int64_t machine_process() { return static_cast<int64_t>(::getpid()); }

bool machine_has_library(const char* name) {
  const char* const missing = std::getenv("BCCSPLAT_MISSING_LIBRARIES");
  if (missing && (":" + std::string(missing) + ":").find(":" + std::string(name) + ":") != std::string::npos)
    return false;
  return dlopen(name, RTLD_LAZY | RTLD_LOCAL) != nullptr;
}

void* machine_symbol(const char* name) { return dlsym(RTLD_DEFAULT, name); }

void prefer_large_pages([[maybe_unused]] void* memory, [[maybe_unused]] size_t bytes) {
#ifdef MADV_HUGEPAGE
  // If refused, the memory is as it would have been. The rest of a page at the end stays in small ones.
  (void)madvise(memory, bytes / large_page * large_page, MADV_HUGEPAGE);
#endif
}

void* take_large_page() {
  // Twice as much has a large page in it; what lies around that goes back, untouched.
  void* const all = mmap(nullptr, 2 * large_page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (all == MAP_FAILED) throw std::bad_alloc();
  auto* const begin = static_cast<std::byte*>(all);
  const size_t before = (large_page - reinterpret_cast<uintptr_t>(all) % large_page) % large_page;
  if (before > 0) munmap(begin, before);
  munmap(begin + before + large_page, large_page - before);
  prefer_large_pages(begin + before, large_page);
  return begin + before;
}

void give_back_large_page(void* memory) noexcept { munmap(memory, large_page); }

void around_forks([[maybe_unused]] void (*before)(), [[maybe_unused]] void (*after)()) {
#ifndef __EMSCRIPTEN__
  if (pthread_atfork(before, after, after) != 0) throw std::bad_alloc();
#endif
}

} // namespace bccsplat
