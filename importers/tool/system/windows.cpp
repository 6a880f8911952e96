// SPDX-License-Identifier: Apache-2.0
#include <windows.h>

#include <fcntl.h>
#include <io.h>
#include <psapi.h>
#include <shellapi.h>

#include <cerrno>
#include <cstdio>

#include "readers/system.h"
#include "readers/text.h"
#include "tool/system.h"

namespace bcc4 {

std::vector<std::string> command_line_words(int argc, char** argv) {
  // What is printed is UTF-8, with the line ends that it has.
  SetConsoleOutputCP(CP_UTF8);
  for (std::FILE* const stream : {stdin, stdout, stderr}) _setmode(_fileno(stream), _O_BINARY);
  int count = 0;
  wchar_t** const wide = CommandLineToArgvW(GetCommandLineW(), &count);
  if (!wide) return {argv, argv + argc};
  std::vector<std::string> words;
  for (int i = 0; i < count; ++i) {
    const std::u8string word = std::filesystem::path(wide[i]).u8string(); // UTF-16 to UTF-8, whatever it is
    words.emplace_back(word.begin(), word.end());
  }
  LocalFree(wide);
  return words;
}

bool stderr_is_terminal() { return _isatty(_fileno(stderr)) != 0; }

int64_t process_number() { return GetCurrentProcessId(); }

std::filesystem::path program_folder() {
  constexpr size_t longest_path = 32768;
  std::wstring path(longest_path, L'\0');
  path.resize(GetModuleFileNameW(nullptr, path.data(), static_cast<DWORD>(path.size())));
  return std::filesystem::path(path).parent_path();
}

bool folder_is_writable(const std::filesystem::path& folder) {
  const std::filesystem::path probe = folder / concat(".bcc4-", process_number());
  const HANDLE file =
      CreateFileW(probe.c_str(), GENERIC_WRITE, 0, nullptr, CREATE_NEW,
                  FILE_ATTRIBUTE_TEMPORARY | FILE_ATTRIBUTE_HIDDEN | FILE_FLAG_DELETE_ON_CLOSE, nullptr);
  if (file == INVALID_HANDLE_VALUE) {
    const DWORD error = GetLastError();
    errno = error == ERROR_PATH_NOT_FOUND || error == ERROR_FILE_NOT_FOUND ? ENOENT : EACCES;
    return false;
  }
  CloseHandle(file);
  return true;
}

uint64_t peak_memory() {
  PROCESS_MEMORY_COUNTERS counters{};
  return K32GetProcessMemoryInfo(GetCurrentProcess(), &counters, sizeof counters)
             ? counters.PeakWorkingSetSize
             : 0;
}

bool is_disk_full(int error) { return error == ENOSPC || error == EFBIG; }

} // namespace bcc4
