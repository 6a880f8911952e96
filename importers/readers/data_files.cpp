// SPDX-License-Identifier: Apache-2.0
#include "readers/data_files.h"

#include <filesystem>

#include "readers/error.h"
#include "readers/system.h"

namespace bcc4 {

std::optional<std::string> path_below(const std::string& header, std::string_view name) {
  namespace fs = std::filesystem;
  const fs::path folder = to_path(header).parent_path();
  fs::path relative = to_path(std::string(name));
  if (relative.is_absolute())
    relative = relative.lexically_normal().lexically_relative(
        fs::absolute(folder.empty() ? fs::path(".") : folder).lexically_normal());
  bool outside = relative.empty();
  for (const fs::path& part : relative) outside |= part == "..";
  if (outside) return std::nullopt;
  return to_text(folder / relative);
}

std::string confined_path(const std::string& header, std::string_view name) {
  if (const auto path = path_below(header, name)) return *path;
  fail_input(header, ": names the data file ", name,
             ", which is not below the header's own folder: move it there");
}

namespace {

std::string with_number(const std::string& where, std::string_view format, int64_t number) {
  const size_t at = format.find('%');
  size_t end = at == std::string_view::npos ? at : at + 1;
  const bool zeros = end < format.size() && format[end] == '0';
  size_t width = 0;
  while (end < format.size() && format[end] >= '0' && format[end] <= '9' && width < 100)
    width = width * 10 + (format[end++] - '0');
  if (end >= format.size() || (format[end] != 'd' && format[end] != 'u' && format[end] != 'i') || width > 64)
    fail_input(where, "\"", format, "\" is no file name format such as slice.%03d");
  std::string digits = concat(number);
  if (digits.size() < width) digits.insert(0, width - digits.size(), zeros ? '0' : ' ');
  return concat(format.substr(0, at), digits, format.substr(end + 1));
}

} // namespace

std::vector<std::string> numbered_data_files(const std::string& header, const std::string& where,
                                             const std::vector<std::string_view>& words) {
  if (words.size() < 4) fail_input(where, "data files by number want a format and first, last, step");
  const auto first = parse_number<int64_t>(words[1]), last = parse_number<int64_t>(words[2]),
             step = parse_number<int64_t>(words[3]);
  constexpr int64_t limit = int64_t{1} << 40; // keeps last - first and n + step in range
  const auto wild = [&](const std::optional<int64_t>& n) { return !n || *n > limit || *n < -limit; };
  if (wild(first) || wild(last) || wild(step) || *step == 0 || (*step > 0) != (*last >= *first))
    fail_input(where, "data files by number want a format and three numbers: first, last, step");
  if ((*last - *first) / *step >= 1'000'000) fail_input(where, "more than a million data files");
  std::vector<std::string> paths;
  // Names that differ by their digits lie in one folder, which is looked at once.
  const std::string name = with_number(where, words[0], *first), whole = confined_path(header, name);
  const auto folder = std::string_view(whole).substr(0, whole.size() - name.size());
  for (int64_t n = *first; *step > 0 ? n <= *last : n >= *last; n += *step)
    paths.push_back(concat(folder, with_number(where, words[0], n)));
  return paths;
}

} // namespace bcc4
