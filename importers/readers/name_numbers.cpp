// SPDX-License-Identifier: Apache-2.0
// Cuts names into numbers and what is between them. Names that differ in one whole number count frames. Of
// those that differ in more it is looked whether they are decimals or tuples, such as dates.
#include "readers/name_numbers.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <string_view>

#include "readers/error.h"

namespace bcc4 {
namespace {

using Names = std::vector<std::string_view>;

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

size_t digits_end(std::string_view name, size_t at) {
  while (at < name.size() && is_digit(name[at])) ++at;
  return at;
}

// Is there a point at `at` between two digits?
bool is_point(std::string_view name, size_t at) {
  return at > 0 && at + 1 < name.size() && name[at] == '.' && is_digit(name[at - 1]) &&
         is_digit(name[at + 1]);
}

// Where a number ends that begins at `at`. One of several points in a row is none of a decimal: 2023.07.15.
size_t decimal_end(std::string_view name, size_t at) {
  size_t end = digits_end(name, at);
  const bool behind_point = at > 0 && is_point(name, at - 1);
  if (!behind_point && is_point(name, end)) {
    const size_t fraction = digits_end(name, end + 1);
    if (!is_point(name, fraction)) end = fraction;
  }
  if (end + 1 >= name.size() || (name[end] != 'e' && name[end] != 'E')) return end;
  const bool is_signed = name[end + 1] == '-' || name[end + 1] == '+';
  if (!is_signed && end == digits_end(name, at)) return end; // s1e05 is no number
  const size_t digits = end + 1 + is_signed;
  const size_t exponent = digits_end(name, digits);
  return exponent > digits && (exponent == name.size() || !is_letter(name[exponent])) ? exponent : end;
}

enum class Reading { whole, decimal };

struct Part {
  std::string_view text;
  bool number;
};

std::vector<Part> parts_of(std::string_view name, Reading reading) {
  std::vector<Part> parts;
  for (size_t at = 0; at < name.size();) {
    const bool number = is_digit(name[at]);
    size_t end = at;
    if (!number)
      while (end < name.size() && !is_digit(name[end])) ++end;
    else
      end = reading == Reading::whole ? digits_end(name, at) : decimal_end(name, at);
    parts.push_back({name.substr(at, end - at), number});
    at = end;
  }
  return parts;
}

// The numbers in which names differ that are alike but for numbers: rows[file][number], from left to right.
struct Differences {
  std::vector<std::vector<std::string_view>> rows;
  std::vector<bool> fractions; // by number: the digits behind a point of whole numbers
  [[nodiscard]] size_t count() const { return rows.empty() ? 0 : rows[0].size(); }
};

// Returns no rows for names that differ in more than numbers.
Differences find_differences(const Names& names, Reading reading) {
  std::vector<std::vector<Part>> all;
  for (const std::string_view name : names) all.push_back(parts_of(name, reading));
  const std::vector<Part>& first = all[0];
  std::vector<size_t> varying;
  for (size_t k = 0; k < first.size(); ++k) {
    bool differs = false;
    for (const std::vector<Part>& parts : all) {
      if (parts.size() != first.size() || parts[k].number != first[k].number) return {};
      differs = differs || parts[k].text != first[k].text;
    }
    if (differs && !first[k].number) return {};
    if (differs) varying.push_back(k);
  }
  Differences d;
  for (const size_t k : varying)
    d.fractions.push_back(k >= 2 && first[k - 1].text == "." && first[k - 2].number);
  for (const std::vector<Part>& parts : all) {
    d.rows.emplace_back();
    for (const size_t k : varying) d.rows.back().push_back(parts[k].text);
  }
  return d;
}

// Have all files a first number of as many digits?
bool of_one_width(const Differences& d) {
  return std::all_of(d.rows.begin(), d.rows.end(),
                     [&](const auto& row) { return row[0].size() == d.rows[0][0].size(); });
}

using Tuples = std::vector<std::vector<int64_t>>;

// Returns none when a number is too long.
std::optional<Tuples> whole_numbers(const Differences& d) {
  Tuples tuples;
  for (const auto& row : d.rows) {
    tuples.emplace_back();
    for (const std::string_view text : row) {
      const auto number = parse_number<int64_t>(text);
      if (!number) return std::nullopt;
      tuples.back().push_back(*number);
    }
  }
  return tuples;
}

// Decimals written to one width or without zeros at their ends: others, as 1.9 and 1.10, are counted.
bool are_decimals(const std::vector<std::string_view>& texts) {
  bool any = false, one_width = true, trailing_zero = false;
  std::optional<size_t> width;
  for (const std::string_view text : texts) {
    const std::string_view digits = text.substr(0, text.find_first_of("eE"));
    const size_t point = digits.find('.');
    const size_t w = point == std::string_view::npos ? 0 : digits.size() - point - 1;
    any = any || w > 0 || digits.size() < text.size();
    one_width = one_width && w == width.value_or(w);
    width = w;
    trailing_zero = trailing_zero || (w > 1 && digits.back() == '0');
  }
  return any && (one_width || !trailing_zero);
}

struct Decimals {
  std::vector<double> values;
  bool exponents = false;
};

// Returns none for names that do not differ in one decimal.
std::optional<Decimals> decimals_of(const Names& names) {
  const Differences d = find_differences(names, Reading::decimal);
  if (d.count() != 1) return std::nullopt;
  std::vector<std::string_view> texts;
  for (const auto& row : d.rows) texts.push_back(row[0]);
  const auto values = parse_numbers(texts);
  if (!values || !are_decimals(texts)) return std::nullopt;
  return Decimals{*values, std::any_of(texts.begin(), texts.end(), [](std::string_view text) {
                    return text.find_first_of("eE") != std::string_view::npos;
                  })};
}

template<class Key> bool rises(const std::vector<Key>& keys) {
  return std::adjacent_find(keys.begin(), keys.end(), [](const Key& a, const Key& b) { return !(a < b); }) ==
         keys.end();
}

// Sorts files by keys, which are sorted, too.
template<class Key> void sort_by(std::vector<Key>& keys, std::vector<SequenceFile>& files) {
  std::vector<size_t> order(files.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return keys[a] < keys[b]; });
  std::vector<Key> sorted_keys;
  std::vector<SequenceFile> sorted;
  for (const size_t i : order) sorted_keys.push_back(keys[i]), sorted.push_back(files[i]);
  for (size_t i = 1; i < files.size(); ++i)
    if (sorted_keys[i] == sorted_keys[i - 1])
      fail_input("one moment stands in two files: ", sorted[i - 1].path, " and ", sorted[i].path,
                 ": leave one out");
  keys = std::move(sorted_keys), files = std::move(sorted);
}

NameOrder order_by_decimals(std::vector<double> decimals, std::vector<SequenceFile>& files) {
  sort_by(decimals, files);
  for (size_t i = 0; i < files.size(); ++i)
    files[i].number = static_cast<int64_t>(i), files[i].decimal = decimals[i];
  return NameOrder::decimals;
}

// Returns the last numbers of tuples.
std::vector<int64_t> last_of(const Tuples& tuples) {
  std::vector<int64_t> last;
  for (const auto& tuple : tuples) last.push_back(tuple.back());
  return last;
}

NameOrder count_by(const std::vector<int64_t>& numbers, std::vector<SequenceFile>& files) {
  for (size_t i = 0; i < files.size(); ++i) files[i].number = numbers[i];
  return NameOrder::counter;
}

bool in_even_steps(const std::vector<int64_t>& numbers) {
  for (size_t i = 2; i < numbers.size(); ++i)
    if (numbers[i] - numbers[i - 1] != numbers[1] - numbers[0]) return false;
  return true;
}

NameOrder order_by_tuples(Tuples tuples, std::vector<SequenceFile>& files) {
  if (!rises(tuples) && rises(last_of(tuples))) return count_by(last_of(tuples), files);
  sort_by(tuples, files);
  const std::vector<int64_t> last = last_of(tuples);
  if (rises(last) && in_even_steps(last)) return count_by(last, files);
  for (size_t i = 0; i < files.size(); ++i) files[i].number = static_cast<int64_t>(i);
  return NameOrder::tuple;
}

} // namespace

NameOrder order_by_names(std::vector<SequenceFile>& files) {
  if (files.size() < 2) return NameOrder::given;
  const std::vector<SequenceFile> paths = files; // which the names lie in
  Names names;
  for (const SequenceFile& f : paths)
    names.push_back(std::string_view(f.path).substr(f.path.find_last_of('/') + 1));
  const Differences d = find_differences(names, Reading::whole);
  const auto tuples = d.count() > 0 ? whole_numbers(d) : std::nullopt;
  const auto decimals = decimals_of(names);
  const bool one = tuples && d.count() == 1, exponents = decimals && decimals->exponents;
  if (one && !exponents && (!d.fractions[0] || of_one_width(d))) return count_by(last_of(*tuples), files);
  // Numbers of versions rise as tuples and not as decimals: 1.9, 2.2, 2.11.
  if (decimals && (exponents || !tuples || !rises(*tuples) || rises(decimals->values)))
    return order_by_decimals(decimals->values, files);
  if (one) return count_by(last_of(*tuples), files);
  return tuples ? order_by_tuples(*tuples, files) : NameOrder::given;
}

} // namespace bcc4
