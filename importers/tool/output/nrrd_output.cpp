// SPDX-License-Identifier: Apache-2.0
#include "tool/output/nrrd_output.h"

#include "readers/text.h"

namespace bcc4 {
namespace {

const char* nrrd_type(Type type) {
  switch (type) {
  case Type::u8:
    return "uint8";
  case Type::i8:
    return "int8";
  case Type::u16:
    return "uint16";
  case Type::i16:
    return "int16";
  case Type::u32:
    return "uint32";
  case Type::i32:
    return "int32";
  default:
    return "float";
  }
}

// The format has no escape for line ends.
std::string one_line(const std::string& text) {
  std::string out;
  for (const char c : text)
    if (c != '\n' && c != '\r') out += c;
  return out;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : one_line(text)) out += c == '"' ? std::string("\\\"") : std::string(1, c);
  return out + "\"";
}

// Content and the unit of samples are the rest of the line, without quotes.
std::string field(const char* name, const std::string& text) {
  const std::string line = one_line(text);
  return trim(line).empty() ? "" : concat(name, ": ", line, "\n");
}

// The keys that tell where the samples of an axis stand; nothing without values.
std::string index_values(size_t axis, const std::vector<double>& values) {
  if (values.empty()) return "";
  std::string text = concat("axis ", axis, " index type:=numeric\naxis ", axis, " index values:=");
  for (size_t i = 0; i < values.size(); ++i) text += concat(i > 0 ? " " : "", values[i]);
  return text + "\n";
}

} // namespace

std::vector<std::pair<std::string, std::string>> time_keys(double time, const std::string& unit) {
  std::vector<std::pair<std::string, std::string>> keys{{"time", concat(time)}};
  if (const std::string line = one_line(unit); !line.empty()) keys.emplace_back("time unit", line);
  return keys;
}

std::string nrrd_header_text(const NrrdOutput& o) {
  const bool series = o.sizes.size() == 4;
  std::string text =
      concat("NRRD0005\n# written by bcc4\ntype: ", nrrd_type(o.type), "\ndimension: ", o.sizes.size(), "\n");
  text += field("content", o.content);
  if (o.space.empty())
    text += "space dimension: 3\n";
  else
    text += concat("space: ", o.space, "\n");
  text += "sizes:";
  for (const uint64_t n : o.sizes) text += concat(" ", n);
  text += "\nspace directions:";
  for (size_t a = 0; a < 3; ++a)
    text += concat(" (", o.affine[a], ",", o.affine[4 + a], ",", o.affine[8 + a], ")");
  text += series ? " none" : "";
  text += concat("\nspace origin: (", o.affine[3], ",", o.affine[7], ",", o.affine[11], ")\n");
  text += concat("kinds: domain domain domain", series ? " time" : "", "\n");
  if (!o.spatial_unit.empty()) {
    const std::string u = quoted(o.spatial_unit);
    text += concat("space units: ", u, " ", u, " ", u, "\n");
  }
  if (series)
    text += concat("labels: \"x\" \"y\" \"z\" \"t\"\nunits: \"\" \"\" \"\" ", quoted(o.time_unit), "\n");
  text += field("sample units", o.sample_unit);
  text += "endian: little\nencoding: raw\n";
  for (size_t a = 0; a < 3; ++a) {
    text += index_values(a, o.coordinates[a]);
    const std::string unit = one_line(o.coordinate_units[a]);
    if (!o.coordinates[a].empty() && o.coordinates_down[a])
      text += concat("axis ", a, " index positive:=down\n");
    if (!o.coordinates[a].empty() && !unit.empty()) text += concat("axis ", a, " index unit:=", unit, "\n");
  }
  if (series) text += index_values(3, o.times);
  for (const auto& [key, value] : o.keys) text += concat(key, ":=", value, "\n");
  return text + "\n";
}

} // namespace bcc4
