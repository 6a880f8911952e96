// SPDX-License-Identifier: Apache-2.0
#include "base/os/windows/wide.h"

#include <windows.h>

#include <array>

#include "base/text.h"

namespace bccsplat {
namespace {

std::string to_narrow(const wchar_t* text, int length) {
  const int bytes = WideCharToMultiByte(CP_UTF8, 0, text, length, nullptr, 0, nullptr, nullptr);
  std::string out(static_cast<size_t>(bytes), '\0');
  WideCharToMultiByte(CP_UTF8, 0, text, length, out.data(), bytes, nullptr, nullptr);
  return out;
}

std::wstring absolute(const std::wstring& path) {
  const DWORD room = GetFullPathNameW(path.c_str(), 0, nullptr, nullptr);
  std::wstring out(room, L'\0');
  out.resize(GetFullPathNameW(path.c_str(), room, out.data(), nullptr));
  return out;
}

} // namespace

std::wstring to_wide(const std::string& text) {
  const int bytes = static_cast<int>(text.size());
  std::wstring out(static_cast<size_t>(MultiByteToWideChar(CP_UTF8, 0, text.data(), bytes, nullptr, 0)),
                   L'\0');
  MultiByteToWideChar(CP_UTF8, 0, text.data(), bytes, out.data(), static_cast<int>(out.size()));
  return out;
}

std::wstring to_wide_path(const std::string& path) {
  const std::wstring wide = to_wide(path);
  if (wide.size() < MAX_PATH || wide.starts_with(L"\\\\")) return wide;
  return L"\\\\?\\" + absolute(wide);
}

std::string windows_error_text(unsigned long error) {
  std::array<wchar_t, 512> buffer{};
  DWORD length = FormatMessageW(FORMAT_MESSAGE_FROM_SYSTEM | FORMAT_MESSAGE_IGNORE_INSERTS, nullptr, error, 0,
                                buffer.data(), static_cast<DWORD>(buffer.size()), nullptr);
  while (length > 0 && (buffer[length - 1] <= L' ' || buffer[length - 1] == L'.')) --length;
  return length > 0 ? to_narrow(buffer.data(), static_cast<int>(length)) : concat("error ", error);
}

} // namespace bccsplat
