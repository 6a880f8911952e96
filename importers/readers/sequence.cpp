// SPDX-License-Identifier: Apache-2.0
// Finds the files that inputs name, by pattern, glob or list, and the gaps between their numbers.
#include "readers/sequence.h"

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <optional>

#include "readers/byte_stream.h"
#include "readers/error.h"
#include "readers/system.h"

namespace bcc4 {
namespace fs = std::filesystem;
namespace {

struct Pattern {
  std::string before, after;
  size_t width = 1; // digits at least
};

// Finds %d, %4d, %04d or a run of # in the last part of a path.
std::optional<Pattern> find_pattern(const std::string& path) {
  const size_t name = path.find_last_of('/') + 1;
  const size_t hash = path.find('#', name);
  if (hash != std::string::npos) {
    const size_t end = std::min(path.find_first_not_of('#', hash), path.size());
    return Pattern{path.substr(0, hash), path.substr(end), end - hash};
  }
  for (size_t at = path.find('%', name); at != std::string::npos; at = path.find('%', at + 1)) {
    size_t end = at + 1;
    while (end < path.size() && is_digit(path[end])) ++end;
    if (end >= path.size() || path[end] != 'd' || end - at > 3) continue;
    const auto width = parse_number<size_t>(std::string_view(path).substr(at + 1, end - at - 1));
    return Pattern{path.substr(0, at), path.substr(end + 1), std::max<size_t>(1, width.value_or(1))};
  }
  return std::nullopt;
}

bool has_wildcard(const std::string& path) {
  return path.find_first_of("*?[", path.find_last_of('/') + 1) != std::string::npos;
}

template<class Accept> std::vector<std::string> list_folder(const std::string& input, Accept accept) {
  const size_t slash = input.find_last_of('/');
  const std::string prefix = slash == std::string::npos ? "" : input.substr(0, slash + 1);
  std::error_code error;
  std::vector<std::string> found;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(to_path(prefix.empty() ? "." : prefix), error)) {
    const std::string name = to_text(entry.path().filename());
    if (accept(name) && entry.is_regular_file()) found.push_back(prefix + name);
  }
  if (error) fail_input(input, ": the folder cannot be listed (", error.message(), ")");
  std::sort(found.begin(), found.end());
  return found;
}

// Returns a number of exactly `width` digits, or of more without a leading zero; "%d" takes any.
std::optional<int64_t> pattern_number(std::string_view digits, size_t width) {
  if (digits.empty() || !std::all_of(digits.begin(), digits.end(), is_digit)) return std::nullopt;
  if (width > 1 && (digits.size() < width || (digits.size() > width && digits[0] == '0')))
    return std::nullopt;
  return parse_number<int64_t>(digits);
}

std::vector<SequenceFile> match_pattern(const std::string& input, const Pattern& pattern) {
  const size_t name = input.find_last_of('/') + 1;
  const std::string_view before = std::string_view(pattern.before).substr(name);
  std::vector<SequenceFile> files;
  size_t other_padding = 0;
  for (const std::string& path : list_folder(input, [&](std::string_view n) {
         return n.size() > before.size() + pattern.after.size() && n.starts_with(before) &&
                n.ends_with(pattern.after);
       })) {
    const std::string_view digits = std::string_view(path).substr(
        pattern.before.size(), path.size() - pattern.before.size() - pattern.after.size());
    if (const auto number = pattern_number(digits, pattern.width))
      files.push_back({path, *number});
    else
      other_padding += pattern_number(digits, 1).has_value();
  }
  if (files.empty())
    fail_input(input, ": no file has such a name",
               other_padding > 0 ? concat("; ", other_padding, " have fewer digits or other padding: try %d")
                                 : "");
  return files;
}

std::vector<std::string> read_list(const std::string& path) {
  const std::string text = read_text_file(path, 64 << 20);
  const std::string folder = path.substr(0, path.find_last_of('/') + 1);
  std::vector<std::string> paths;
  for (const std::string_view line : split(text, "\r\n")) {
    const std::string_view entry = trim(line);
    if (entry.empty() || entry[0] == '#') continue;
    paths.push_back(entry[0] == '/' ? std::string(entry) : folder + std::string(entry));
  }
  if (paths.empty()) fail_input(path, ": lists no files");
  return paths;
}

void select_frames(Sequence& s, const FrameSelection& selection) {
  if (!selection.given) return;
  const int64_t origin = selection.first == INT64_MIN ? s.files.front().number : selection.first;
  std::erase_if(s.files, [&](const SequenceFile& f) {
    return f.number < selection.first || f.number > selection.last ||
           (f.number - origin) % selection.step != 0;
  });
  if (s.files.empty()) fail_usage("--frames selects none of the files");
}

int64_t common_stride(const std::vector<SequenceFile>& files) {
  int64_t stride = 0;
  for (size_t i = 1; i < files.size(); ++i) stride = std::gcd(stride, files[i].number - files[i - 1].number);
  return std::max<int64_t>(1, stride);
}

void find_gaps(Sequence& s, const FrameSelection& selection) {
  s.stride =
      selection.given && selection.step > 1 ? std::lcm(selection.step, s.natural_stride) : s.natural_stride;
  int64_t first = s.files.front().number, last = s.files.back().number;
  if (selection.given && selection.first != INT64_MIN) first = selection.first;
  if (selection.given && selection.last != INT64_MAX)
    last = first + (selection.last - first) / s.stride * s.stride;
  if ((last - first) / s.stride >= 10'000'000)
    fail_input("frame numbers run from ", first, " to ", last, ": too far apart");
  size_t next = 0;
  for (int64_t number = first; number <= last; number += s.stride) {
    if (next < s.files.size() && s.files[next].number == number)
      ++next;
    else
      s.missing.push_back(number);
  }
}

// Returns the files of a single input that is a pattern, numbered by it; none when it is something else.
std::vector<SequenceFile> find_by_pattern(const std::vector<std::string>& inputs) {
  const auto pattern = inputs.size() == 1 ? find_pattern(inputs[0]) : std::nullopt;
  if (!pattern || fs::exists(to_path(inputs[0]))) return {};
  return match_pattern(inputs[0], *pattern);
}

struct ListedFiles {
  std::vector<std::string> paths;
  bool from_glob = false; // some of them
};

// Returns the inputs as they are, with lists and globs replaced by what they name.
ListedFiles list_files(const std::vector<std::string>& inputs) {
  ListedFiles files;
  for (const std::string& input : inputs) {
    std::error_code ignored;
    if (input.size() > 1 && input[0] == '@') {
      for (const std::string& path : read_list(input.substr(1))) files.paths.push_back(path);
    } else if (has_wildcard(input) && !fs::exists(to_path(input), ignored)) {
      const std::string glob = input.substr(input.find_last_of('/') + 1);
      const auto found = list_folder(input, [&](const std::string& n) { return fits_wildcards(glob, n); });
      if (found.empty()) fail_input(input, ": no file has such a name");
      files.paths.insert(files.paths.end(), found.begin(), found.end());
      files.from_glob = true;
    } else {
      if (find_pattern(input) && !fs::exists(to_path(input), ignored))
        fail_usage(input, ": a frame pattern stands alone, without other inputs");
      files.paths.push_back(input);
    }
  }
  return files;
}

void sort_by_number(std::vector<SequenceFile>& files) {
  std::stable_sort(files.begin(), files.end(),
                   [](const SequenceFile& a, const SequenceFile& b) { return a.number < b.number; });
  for (size_t i = 1; i < files.size(); ++i)
    if (files[i].number == files[i - 1].number)
      fail_input("frame ", files[i].number, " stands in two files: ", files[i - 1].path, " and ",
                 files[i].path);
}

std::string name_of(const SequenceFile& file) { return file.path.substr(file.path.find_last_of('/') + 1); }

std::string sequence_note(const Sequence& s) {
  if (s.files.size() < 2) return "";
  if (s.order == NameOrder::decimals)
    return concat(s.files.size(), " files, sorted by the decimals in their names: ", s.files.front().decimal,
                  " to ", s.files.back().decimal);
  if (s.order == NameOrder::tuple)
    return concat(s.files.size(),
                  " files in the order of the numbers in their names, read from left to right: ",
                  name_of(s.files.front()), " to ", name_of(s.files.back()));
  if (!s.numbered)
    return concat(s.files.size(), " files in the order given (their names do not differ in numbers only)");
  return concat(s.files.size(), " files, sorted by the number in their names: ", s.files.front().number,
                " to ", s.files.back().number, s.stride > 1 ? concat(" by ", s.stride) : "");
}

} // namespace

Sequence find_sequence(const std::vector<std::string>& inputs, const FrameSelection& selection) {
  Sequence s;
  s.files = find_by_pattern(inputs);
  s.numbered = !s.files.empty();
  if (s.files.empty()) {
    const ListedFiles listed = list_files(inputs);
    for (const std::string& path : listed.paths)
      s.files.push_back({path, static_cast<int64_t>(s.files.size())});
    s.order = order_by_names(s.files);
    s.numbered = s.order == NameOrder::counter;
    if (listed.from_glob && s.files.size() > 1 && s.order == NameOrder::given)
      fail_input(inputs[0], ": the names of the ", s.files.size(),
                 " files do not differ in numbers only; list the files in order");
  }
  sort_by_number(s.files);
  s.natural_stride = common_stride(s.files);
  if (s.numbered || s.files.size() > 1)
    select_frames(s, selection); // the frames of a single file are selected by its reader
  if (s.numbered) find_gaps(s, selection);
  s.note = sequence_note(s);
  return s;
}

void refuse_unlike(const Sequence& sequence, size_t file, const std::string& what) {
  const auto number = [&](size_t i) { return sequence.files[i].number; };
  fail_input(sequence.files[file].path, ": its ", what, " differ from those of ", sequence.files.front().path,
             ": convert the files to one kind, or take those before it by --frames ", number(0),
             file > 1 ? concat("-", number(file - 1)) : "");
}

std::string range_text(const std::vector<int64_t>& numbers, int64_t stride) {
  std::vector<std::string> ranges;
  for (size_t i = 0; i < numbers.size();) {
    size_t end = i + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + stride) ++end;
    ranges.push_back(end - i == 1
                         ? concat(numbers[i])
                         : concat(numbers[i], "-", numbers[end - 1], stride > 1 ? concat("x", stride) : ""));
    i = end;
    if (ranges.size() == 20 && i < numbers.size()) {
      ranges.push_back(concat(numbers.size() - i, " more"));
      break;
    }
  }
  return join(ranges);
}

bool has_frame_pattern(const std::string& name) { return find_pattern(name).has_value(); }

std::string apply_frame_pattern(const std::string& name, int64_t number) {
  const auto pattern = find_pattern(name);
  if (!pattern) return name;
  std::string digits = concat(number < 0 ? -number : number);
  if (digits.size() < pattern->width) digits.insert(0, pattern->width - digits.size(), '0');
  return concat(pattern->before, number < 0 ? "-" : "", digits, pattern->after);
}

} // namespace bcc4
