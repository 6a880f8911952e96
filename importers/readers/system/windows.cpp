// SPDX-License-Identifier: Apache-2.0
#include <windows.h>

#include <string_view>

#include "readers/system.h"
#include "readers/text.h"

namespace bcc4 {
namespace {

// Takes a set such as [a-z] or [!0] off the wildcards and returns whether it has the character; without an
// end it is the character '['.
bool take_set(std::string_view& wildcards, char c) {
  const size_t first = wildcards.substr(1).starts_with('!') ? 2 : 1;
  const size_t end = wildcards.find(']', first + 1);
  if (end == std::string_view::npos) {
    wildcards.remove_prefix(1);
    return c == '[';
  }
  bool found = false;
  for (size_t i = first; i < end; ++i) {
    const bool range = i + 2 < end && wildcards[i + 1] == '-';
    found |= range ? c >= wildcards[i] && c <= wildcards[i + 2] : c == wildcards[i];
    i += range ? 2 : 0;
  }
  wildcards.remove_prefix(end + 1);
  return found != (first == 2);
}

bool fits(std::string_view wildcards, std::string_view name) {
  while (!wildcards.empty()) {
    if (wildcards[0] == '*') {
      for (size_t skip = 0; skip <= name.size(); ++skip)
        if (fits(wildcards.substr(1), name.substr(skip))) return true;
      return false;
    }
    if (name.empty()) return false;
    if (wildcards[0] == '[') {
      if (!take_set(wildcards, name[0])) return false;
    } else {
      if (wildcards[0] != '?' && wildcards[0] != name[0]) return false;
      wildcards.remove_prefix(1);
    }
    name.remove_prefix(1);
  }
  return name.empty();
}

} // namespace

uint64_t machine_memory() {
  MEMORYSTATUSEX status{};
  status.dwLength = sizeof status;
  return GlobalMemoryStatusEx(&status) ? status.ullTotalPhys : 0;
}

std::string make_temporary_folder() {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  if (error) return "";
  // A name of this process that was not taken when it was made.
  for (uint64_t attempt = GetTickCount64(), end = attempt + 100; attempt < end; ++attempt) {
    const auto path = folder / concat("bcc4-", GetCurrentProcessId(), "-", attempt);
    if (std::filesystem::create_directory(path, error) && !error) return to_text(path);
  }
  return "";
}

bool fits_wildcards(const std::string& wildcards, const std::string& name) {
  return name.starts_with('.') == wildcards.starts_with('.') && fits(wildcards, name);
}

} // namespace bcc4
