// SPDX-License-Identifier: Apache-2.0
// Parses the keys of a MetaImage header line by line and finds the data files it names. Format: the
// documentation of MetaIO.
#include "readers/metaimage/metaimage_header.h"

#include <cmath>
#include <utility>

#include "readers/data_files.h"
#include "readers/header_lines.h"

namespace bcc4 {
namespace {

constexpr size_t kAxesLimit = 10; // as in MetaIO

Type element_type(const HeaderLines& lines, std::string_view name) {
  static constexpr std::pair<std::string_view, Type> types[] = {
      {"MET_UCHAR", Type::u8},   {"MET_CHAR", Type::i8},        {"MET_ASCII_CHAR", Type::i8},
      {"MET_USHORT", Type::u16}, {"MET_SHORT", Type::i16},      {"MET_UINT", Type::u32},
      {"MET_INT", Type::i32},    {"MET_ULONG", Type::u32},      {"MET_LONG", Type::i32},
      {"MET_FLOAT", Type::f32},  {"MET_ULONG_LONG", Type::u64}, {"MET_LONG_LONG", Type::i64},
      {"MET_DOUBLE", Type::f64}};
  for (const auto& [known, type] : types)
    if (name == known) return type;
  lines.refuse("ElementType ", name, " cannot be read: scalars MET_UCHAR to MET_DOUBLE can");
}

bool truth(const HeaderLines& lines, std::string_view value) {
  const std::string v = lower(value);
  if (v == "true" || v == "1" || v == "yes") return true;
  if (v == "false" || v == "0" || v == "no") return false;
  lines.refuse("\"", value, "\" is neither True nor False");
}

std::vector<double> numbers(const HeaderLines& lines, std::string_view value) {
  const auto parts = split(value);
  const auto parsed = parse_numbers(parts);
  if (!parsed || parsed->empty()) lines.refuse("\"", value.substr(0, 60), "\" should be numbers");
  for (const double v : *parsed)
    if (!std::isfinite(v)) lines.refuse("a number is not finite");
  return *parsed;
}

template<class Number> Number integer(const HeaderLines& lines, std::string_view value) {
  const auto parsed = parse_number<Number>(value);
  if (!parsed) lines.refuse("\"", value.substr(0, 60), "\" is no whole number in range");
  return *parsed;
}

struct Parser {
  MetaImageHeader& h;
  HeaderLines& lines;
  size_t axes = 0;
  bool typed = false, compressed = false, text = false;

  // Returns an array that must have `count` entries, one per axis or per axis squared.
  std::vector<double> per_axis(std::string_view value, size_t count) const {
    if (axes == 0) lines.refuse("NDims must come first");
    std::vector<double> v = numbers(lines, value);
    if (v.size() != count) lines.refuse(v.size(), " entries for ", axes, " axes");
    return v;
  }

  void set_sizes(std::string_view value) {
    if (!h.sizes.empty()) lines.refuse("a second \"DimSize\"");
    const auto parts = split(value);
    if (parts.size() != axes) lines.refuse("DimSize has ", parts.size(), " entries, NDims is ", axes);
    for (const std::string_view part : parts) {
      h.sizes.push_back(integer<uint64_t>(lines, part));
      if (h.sizes.back() == 0) lines.refuse("an axis has no samples");
    }
  }

  double number(std::string_view value) const {
    const std::vector<double> v = numbers(lines, value);
    if (v.size() != 1) lines.refuse(v.size(), " numbers instead of one");
    return v[0];
  }

  // Takes a field; returns false for a key that does not say how to read the data.
  bool field(const std::string& key, std::string_view value) {
    if (key == "ObjectType") {
      if (lower(value) != "image") lines.refuse("ObjectType ", value, ", not Image");
    } else if (key == "NDims") { // what stands per axis is counted by it
      if (axes != 0) lines.refuse("a second \"NDims\"");
      axes = integer<size_t>(lines, value);
      if (axes < 1 || axes > kAxesLimit) lines.refuse("NDims ", axes, " is not 1 to ", kAxesLimit);
    } else if (key == "DimSize") {
      set_sizes(value);
    } else if (key == "ElementType") {
      h.type = element_type(lines, value);
      typed = true;
    } else if (key == "ElementNumberOfChannels") {
      h.channels = integer<uint64_t>(lines, value);
      if (h.channels < 1 || h.channels > 4096) lines.refuse(h.channels, " channels");
    } else if (key == "BinaryData") {
      text = !truth(lines, value);
    } else if (key == "BinaryDataByteOrderMSB" || key == "ElementByteOrderMSB") {
      h.big_endian = truth(lines, value);
    } else if (key == "CompressedData") {
      compressed = truth(lines, value);
    } else if (key == "HeaderSize") {
      h.skip = integer<int64_t>(lines, value);
      if (h.skip < -1) lines.refuse("HeaderSize ", h.skip);
    } else if (key == "ElementSpacing") {
      h.spacing = per_axis(value, axes);
    } else if (key == "ElementSize") { // the extent of a sample; the distance only where none is given
      if (h.spacing.empty()) h.spacing = per_axis(value, axes);
    } else if (key == "ElementToIntensityFunctionSlope") {
      h.slope = number(value);
      if (h.slope == 0) lines.refuse("a slope of 0 makes all values one");
    } else if (key == "ElementToIntensityFunctionOffset") {
      h.intercept = number(value);
    } else if (key == "Offset" || key == "Origin" || key == "Position") {
      h.origin = per_axis(value, axes);
    } else if (key == "TransformMatrix" || key == "Orientation" || key == "Rotation") {
      h.direction = per_axis(value, axes * axes);
    } else {
      return false;
    }
    return true;
  }

  // Takes the last key of a header: LOCAL, LIST, a format with numbers, or a name.
  void data_file(std::string_view value) {
    const auto words = split(value);
    if (words.empty()) lines.refuse("ElementDataFile names nothing");
    if (lower(words[0]) == "local") {
      h.data_files = {h.path};
      h.data_offset = lines.offset();
    } else if (words[0] == "LIST") {
      std::string line;
      while (lines.next(line))
        if (!trim(line).empty()) h.data_files.push_back(confined_path(h.path, trim(line)));
      if (h.data_files.empty()) lines.refuse("the list of data files is empty");
    } else if (words.size() >= 4 && words[0].find('%') != std::string_view::npos) {
      h.data_files = numbered_data_files(h.path, lines.where(), words);
    } else {
      h.data_files = {confined_path(h.path, value)};
    }
  }
};

} // namespace

MetaImageHeader read_metaimage_header(const std::string& path) {
  MetaImageHeader h;
  h.path = path;
  HeaderLines lines(path, "MetaImage");
  Parser parser{h, lines};
  std::string line;
  while (h.data_files.empty()) {
    if (!lines.next(line)) fail_input(path, ": the MetaImage header names no ElementDataFile");
    if (trim(line).empty()) continue;
    const size_t equals = line.find('=');
    if (equals == std::string::npos) lines.refuse("not KEY = VALUE: \"", line.substr(0, 40), "\"");
    const std::string key(trim(std::string_view(line).substr(0, equals)));
    const std::string_view value = trim(std::string_view(line).substr(equals + 1));
    if (key == "ElementDataFile")
      parser.data_file(value);
    else if (!parser.field(key, value))
      h.other[key] = std::string(value);
  }
  if (h.sizes.empty()) fail_input(path, ": the MetaImage header has no DimSize");
  if (!parser.typed) fail_input(path, ": the MetaImage header has no ElementType");
  if (parser.compressed && parser.text) fail_input(path, ": compressed text cannot be read");
  h.encoding = parser.compressed ? Encoding::gzip : parser.text ? Encoding::ascii : Encoding::raw;
  return h;
}

std::vector<Segment> metaimage_segments(const MetaImageHeader& h, uint64_t total_bytes) {
  const size_t count = h.data_files.size();
  if (total_bytes / type_size(h.type) % count != 0)
    fail_input(h.path, ": ", total_bytes, " bytes do not spread evenly over ", count, " data files");
  std::vector<Segment> segments;
  for (const std::string& file : h.data_files) {
    Segment s{.path = file,
              .bytes = total_bytes / count,
              .encoding = h.encoding,
              .ascii_type = h.type,
              .exact = true};
    s.offset = file == h.path ? h.data_offset : 0;
    if (h.skip > 0) s.offset += h.skip;
    if (h.skip < 0) {
      const uint64_t size = file_size(file);
      if (h.encoding != Encoding::raw) fail_input(h.path, ": HeaderSize -1 is for raw data only");
      if (size < s.bytes) fail_input(file, ": ", size, " bytes cannot hold ", s.bytes, " bytes of data");
      s.offset = size - s.bytes;
    }
    segments.push_back(std::move(s));
  }
  return segments;
}

} // namespace bcc4
