// SPDX-License-Identifier: Apache-2.0
// Parses the fields of a NRRD header line by line and finds the data files it names.
#include "readers/nrrd/nrrd_header.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "readers/data_files.h"
#include "readers/error.h"
#include "readers/header_lines.h"

namespace bcc4 {
namespace {

constexpr size_t kAxesLimit = 16; // as in Teem

// Returns the strings of a list such as "x" "y z": double quotes around each, backslash escapes inside.
std::vector<std::string> quoted_strings(std::string_view text) {
  std::vector<std::string> out;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '"') continue;
    std::string item;
    for (++i; i < text.size() && text[i] != '"'; ++i) {
      if (text[i] == '\\' && i + 1 < text.size()) ++i;
      item += text[i];
    }
    out.push_back(item);
  }
  return out;
}

// What Teem writes without quotes others put in some.
std::string without_quotes(std::string_view text) {
  if (text.size() < 2 || text.front() != '"' || text.back() != '"') return std::string(text);
  const auto texts = quoted_strings(text);
  return texts.size() == 1 ? texts[0] : std::string(text);
}

struct Parser {
  NrrdHeader& h;
  const HeaderLines& lines;
  bool type_given = false, encoding_given = false;
  size_t space_dimension = 0;

  template<class N> N number(std::string_view text) const {
    const auto value = parse_number<N>(trim(text));
    if (!value) lines.refuse("\"", text, "\" is no number");
    return *value;
  }

  std::vector<std::string_view> per_axis(std::string_view value) const {
    auto parts = split(value);
    if (h.axes.empty()) lines.refuse("\"dimension\" must come first");
    if (parts.size() != h.axes.size()) lines.refuse(parts.size(), " entries for ", h.axes.size(), " axes");
    return parts;
  }

  std::optional<double> axis_number(std::string_view text) const {
    if (lower(text) == "nan") return std::nullopt; // unknown
    const double value = number<double>(text);
    return std::isfinite(value) ? std::optional(value) : std::nullopt;
  }

  // Returns whether samples are cells; nothing when that is not known.
  std::optional<bool> centering(const std::string& text) const {
    if (text == "???" || text == "none") return std::nullopt;
    if (text != "cell" && text != "node") lines.refuse("\"", text, "\" is neither cell nor node");
    return text == "cell";
  }

  // Returns the vectors of a list such as "(1,0,0) none (0,2,0)".
  std::vector<std::optional<std::vector<double>>> vectors(std::string_view text) const {
    std::vector<std::optional<std::vector<double>>> out;
    for (size_t i = 0; i < text.size();) {
      if (text[i] == ' ' || text[i] == '\t') {
        ++i;
      } else if (text[i] == '(') {
        const size_t end = text.find(')', i);
        if (end == std::string_view::npos) lines.refuse("a vector is not closed");
        const auto numbers = parse_numbers(split_commas(text.substr(i + 1, end - i - 1)));
        if (!numbers) lines.refuse("\"", text.substr(i, end - i + 1), "\" is no vector");
        for (const double v : *numbers)
          if (!std::isfinite(v)) lines.refuse("a vector is not finite");
        if (numbers->size() != space_dimension)
          lines.refuse("a vector of ", numbers->size(), " in a space of ", space_dimension, " dimensions");
        out.push_back(*numbers);
        i = end + 1;
      } else {
        const size_t end = std::min(text.find_first_of(" \t(", i), text.size());
        if (lower(text.substr(i, end - i)) != "none")
          lines.refuse("\"", text.substr(i, end - i), "\" is no vector");
        out.emplace_back();
        i = end;
      }
    }
    return out;
  }

  void set_space(std::string_view value) {
    static constexpr std::pair<const char*, const char*> shortcuts[] = {
        {"ras", "right-anterior-superior"},      {"las", "left-anterior-superior"},
        {"lps", "left-posterior-superior"},      {"rast", "right-anterior-superior-time"},
        {"last", "left-anterior-superior-time"}, {"lpst", "left-posterior-superior-time"}};
    h.space = lower(value);
    for (const auto& [brief, full] : shortcuts)
      if (h.space == brief) h.space = full;
    space_dimension = h.space.ends_with("-time") ? 4 : 3;
  }

  void field(const std::string& name, std::string_view value) {
    if (name == "type") {
      const auto type = type_by_name(value);
      if (!type) lines.refuse("values of type ", value, " cannot be read; u8 to f64 can");
      h.type = *type;
      type_given = true;
    } else if (name == "dimension") {
      const auto n = number<size_t>(value);
      if (n < 1 || n > kAxesLimit) lines.refuse(n, " axes, 1 to ", kAxesLimit, " are possible");
      if (!h.axes.empty()) lines.refuse("a second \"dimension\"");
      h.axes.resize(n);
    } else if (name == "sizes") {
      const auto parts = per_axis(value);
      for (size_t a = 0; a < parts.size(); ++a) {
        h.axes[a].size = number<uint64_t>(parts[a]);
        if (h.axes[a].size == 0) lines.refuse("axis ", a, " has no samples");
      }
    } else if (name == "encoding") {
      set_encoding(lower(value));
    } else if (name == "endian") {
      const std::string v = lower(value);
      if (v != "little" && v != "big") lines.refuse("endian ", value, " is neither little nor big");
      h.big_endian = v == "big";
      h.endian_given = true;
    } else if (name == "spacings") {
      const auto parts = per_axis(value);
      for (size_t a = 0; a < parts.size(); ++a) h.axes[a].spacing = axis_number(parts[a]);
    } else if (name == "axismins" || name == "axismaxs") {
      const auto parts = per_axis(value);
      for (size_t a = 0; a < parts.size(); ++a)
        (name == "axismins" ? h.axes[a].min : h.axes[a].max) = axis_number(parts[a]);
    } else if (name == "centers" || name == "centerings") {
      const auto parts = per_axis(value);
      for (size_t a = 0; a < parts.size(); ++a) h.axes[a].cells = centering(lower(parts[a]));
    } else if (name == "kinds") {
      const auto parts = per_axis(value);
      for (size_t a = 0; a < parts.size(); ++a)
        if (parts[a] != "???" && lower(parts[a]) != "none") h.axes[a].kind = lower(parts[a]);
    } else if (name == "labels" || name == "units") {
      const auto texts = quoted_strings(value);
      if (texts.size() != h.axes.size())
        lines.refuse(texts.size(), " ", name, " for ", h.axes.size(), " axes");
      for (size_t a = 0; a < texts.size(); ++a)
        (name == "labels" ? h.axes[a].label : h.axes[a].unit) = texts[a];
    } else if (name == "space") {
      set_space(value);
    } else if (name == "spacedimension") {
      space_dimension = number<size_t>(value);
      if (space_dimension < 1 || space_dimension > 8)
        lines.refuse("a space of ", space_dimension, " dimensions");
    } else if (name == "spacedirections") {
      const auto v = vectors(value);
      if (v.size() != h.axes.size()) lines.refuse(v.size(), " directions for ", h.axes.size(), " axes");
      for (size_t a = 0; a < v.size(); ++a) h.axes[a].direction = v[a];
      h.has_directions = true;
    } else if (name == "spaceorigin") {
      const auto v = vectors(value);
      if (v.size() != 1 || !v[0]) lines.refuse("one vector is expected");
      h.origin = v[0];
    } else if (name == "spaceunits") {
      h.space_units = quoted_strings(value);
    } else if (name == "lineskip") {
      h.line_skip = number<uint64_t>(value);
    } else if (name == "byteskip") {
      h.byte_skip = number<int64_t>(value);
      if (h.byte_skip < -1) lines.refuse("byte skip ", h.byte_skip);
    } else if (name == "sampleunits") {
      h.sample_unit = without_quotes(trim(value));
    } else if (name == "content") {
      h.content = without_quotes(trim(value));
    } else if (name == "blocksize") {
      lines.refuse("blocks of bytes have no values to read");
    }
    // Other fields (min, max, thicknesses, measurement frame ...) say nothing that is needed here.
  }

  void set_encoding(const std::string& v) {
    encoding_given = true;
    if (v == "raw")
      h.encoding = Encoding::raw;
    else if (v == "gzip" || v == "gz")
      h.encoding = Encoding::gzip;
    else if (v == "ascii" || v == "text" || v == "txt")
      h.encoding = Encoding::ascii;
    else
      lines.refuse("encoding ", v, " cannot be read; raw, gzip and ascii can");
  }
};

std::string without_blanks(std::string_view name) {
  std::string out;
  for (const char c : lower(name))
    if (c != ' ' && c != '\t') out += c;
  return out;
}

} // namespace

NrrdHeader read_nrrd_header(const std::string& path) {
  NrrdHeader h;
  h.path = path;
  HeaderLines lines(path, "NRRD");
  std::string line;
  if (!lines.next(line) || !line.starts_with("NRRD000") || line.size() != 8 || line[7] < '1' || line[7] > '5')
    fail_input(path, ": no NRRD file: it does not begin with NRRD0001 to NRRD0005");
  h.version = line[7] - '0';
  Parser parser{h, lines};
  bool ended = false;
  while (lines.next(line)) {
    if (line.empty()) {
      ended = true;
      break;
    }
    if (line[0] == '#') continue;
    const size_t colon = line.find(':');
    if (colon == std::string::npos)
      lines.refuse("neither a field nor a comment: \"", line.substr(0, 40), "\"");
    if (colon + 1 < line.size() && line[colon + 1] == '=') {
      h.keys[line.substr(0, colon)] = line.substr(colon + 2);
      continue;
    }
    const std::string name = without_blanks(line.substr(0, colon));
    const std::string_view value = trim(std::string_view(line).substr(colon + 1));
    if (name != "datafile") {
      parser.field(name, value);
      continue;
    }
    if (!std::exchange(h.attached, false)) lines.refuse("its data file is named twice");
    const auto words = split(value);
    if (words.empty()) lines.refuse("no data file named");
    if (words[0] == "LIST") {
      while (lines.next(line))
        if (!trim(line).empty()) h.data_files.push_back(confined_path(path, trim(line)));
      if (h.data_files.empty()) lines.refuse("the list of data files is empty");
      ended = true;
      break; // the list is the rest of the file
    }
    if (words.size() >= 4 && words[0].find('%') != std::string_view::npos)
      for (std::string& file : numbered_data_files(path, lines.where(), words))
        h.data_files.push_back(std::move(file));
    else
      h.data_files.push_back(confined_path(path, value));
  }
  if (!parser.type_given) fail_input(path, ": the NRRD header has no type");
  if (h.axes.empty() || h.axes[0].size == 0) fail_input(path, ": the NRRD header has no sizes");
  if (!parser.encoding_given) fail_input(path, ": the NRRD header has no encoding");
  if (h.attached && !ended) fail_input(path, ": the NRRD header does not end with an empty line: no data");
  h.data_offset = lines.offset();
  if (!h.endian_given && h.encoding != Encoding::ascii && type_size(h.type) > 1)
    fail_input(path, ": the NRRD header has no endian, and the values are ", type_name(h.type));
  return h;
}

std::vector<Segment> nrrd_segments(const NrrdHeader& h, uint64_t total_bytes) {
  std::vector<std::string> paths = h.data_files;
  if (h.attached) paths.push_back(h.path);
  if (total_bytes / type_size(h.type) % paths.size() != 0)
    fail_input(h.path, ": ", total_bytes, " bytes do not spread evenly over ", paths.size(), " data files");
  const uint64_t share = total_bytes / paths.size();
  std::vector<Segment> segments;
  for (const std::string& path : paths) {
    InputFile file(path);
    Segment s{.path = path, .bytes = share, .encoding = h.encoding, .ascii_type = h.type, .exact = true};
    s.offset = file.skip_lines(h.attached ? h.data_offset : 0, h.line_skip);
    if (h.byte_skip < 0) {
      if (h.encoding != Encoding::raw) fail_input(h.path, ": byte skip -1 is for raw encoding only");
      if (file.size() < s.offset + share)
        fail_input(path, ": ", file.size(), " bytes cannot hold ", share, " bytes of data");
      s.offset = file.size() - share;
    } else if (h.encoding == Encoding::gzip) {
      s.discard = h.byte_skip;
    } else {
      s.offset += h.byte_skip;
    }
    segments.push_back(std::move(s));
  }
  return segments;
}

} // namespace bcc4
