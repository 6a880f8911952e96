// SPDX-License-Identifier: Apache-2.0
#include <fnmatch.h>
#include <unistd.h>

#include <cstdlib>

#include "readers/system.h"

namespace bcc4 {

uint64_t machine_memory() {
  const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
  return pages > 0 && page > 0 ? static_cast<uint64_t>(pages) * static_cast<uint64_t>(page) : 0;
}

std::string make_temporary_folder() {
  std::error_code error;
  std::string name = (std::filesystem::temp_directory_path(error) / "bcc4-XXXXXX").string();
  return !error && mkdtemp(name.data()) ? name : "";
}

bool fits_wildcards(const std::string& wildcards, const std::string& name) {
  return fnmatch(wildcards.c_str(), name.c_str(), FNM_PERIOD) == 0;
}

} // namespace bcc4
