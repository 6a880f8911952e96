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
  default:
    return "float";
  }
}

// A quoted string of one line; the format has no escape for line ends.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text)
    if (c != '\n' && c != '\r') out += c == '"' ? std::string("\\\"") : std::string(1, c);
  return out + "\"";
}

} // namespace

std::string nrrd_header_text(const NrrdOutput& o) {
  const bool series = o.sizes.size() == 4;
  std::string text =
      concat("NRRD0005\n# written by bcc4\ntype: ", nrrd_type(o.type), "\ndimension: ", o.sizes.size(), "\n");
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
  text += "endian: little\nencoding: raw\n";
  if (series) {
    text += "axis 3 index type:=numeric\naxis 3 index values:=";
    for (size_t i = 0; i < o.times.size(); ++i) text += concat(i > 0 ? " " : "", o.times[i]);
    text += "\n";
  }
  for (const auto& [key, value] : o.keys) text += concat(key, ":=", value, "\n");
  return text + "\n";
}

} // namespace bcc4
