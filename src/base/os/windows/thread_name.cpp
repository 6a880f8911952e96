// SPDX-License-Identifier: Apache-2.0
#include "base/os/thread_name.h"

#include <windows.h>

#include "base/os/windows/wide.h"

namespace bccsplat {

void name_this_thread(const char* name) {
  using Describe = HRESULT(WINAPI*)(HANDLE, PCWSTR);
  // Windows 10 has it, before there is none.
  const auto describe = reinterpret_cast<Describe>(
      reinterpret_cast<void*>(GetProcAddress(GetModuleHandleW(L"kernel32.dll"), "SetThreadDescription")));
  if (describe) describe(GetCurrentThread(), to_wide(name).c_str());
}

} // namespace bccsplat
