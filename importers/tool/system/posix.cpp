// SPDX-License-Identifier: Apache-2.0
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>

#include "readers/text.h"
#include "tool/system.h"

namespace bcc4 {

std::vector<std::string> command_line_words(int argc, char** argv) { return {argv, argv + argc}; }

bool stderr_is_terminal() { return isatty(STDERR_FILENO) != 0; }

int64_t process_number() { return getpid(); }

std::filesystem::path program_folder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

bool folder_is_writable(const std::filesystem::path& folder) {
  return ::access(folder.empty() ? "." : folder.c_str(), W_OK | X_OK) == 0;
}

// On Linux ru_maxrss starts from the memory of the process that started this one, and will not do.
uint64_t peak_memory() {
  constexpr uint64_t kilobyte = 1024;
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    const auto words = split(line);
    if (words.size() > 1 && words[0] == "VmHWM:")
      return parse_number<uint64_t>(words[1]).value_or(0) * kilobyte;
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<uint64_t>(usage.ru_maxrss) * kilobyte;
}

bool is_disk_full(int error) { return error == ENOSPC || error == EDQUOT || error == EFBIG; }

} // namespace bcc4
