// SPDX-License-Identifier: Apache-2.0
#include "base/machine.h"

#include <windows.h>

#include <psapi.h>

#include <array>
#include <new>

#include "base/paged_vector.h"

namespace bccsplat {

uint64_t machine_memory() {
  MEMORYSTATUSEX status{};
  status.dwLength = sizeof status;
  return GlobalMemoryStatusEx(&status) ? status.ullTotalPhys : uint64_t{1} << 30;
}

int64_t machine_process() { return static_cast<int64_t>(GetCurrentProcessId()); }

bool machine_has_library(const char* name) { return LoadLibraryA(name) != nullptr; }

void* machine_symbol(const char* name) {
  std::array<HMODULE, 512> modules{};
  DWORD bytes = 0;
  if (!K32EnumProcessModules(GetCurrentProcess(), modules.data(), sizeof modules, &bytes)) return nullptr;
  for (size_t i = 0; i < modules.size() && i < bytes / sizeof(HMODULE); ++i)
    if (const FARPROC found = GetProcAddress(modules[i], name)) return reinterpret_cast<void*>(found);
  return nullptr;
}

// Large pages are a right there that few users have.
void prefer_large_pages(void* /*memory*/, size_t /*bytes*/) {}

void* take_large_page() { return ::operator new (large_page, std::align_val_t{large_page}); }
void give_back_large_page(void* memory) noexcept { ::operator delete (memory, std::align_val_t{large_page}); }

void around_forks(void (* /*before*/)(), void (* /*after*/)()) {}

} // namespace bccsplat
