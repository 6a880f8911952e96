// SPDX-License-Identifier: Apache-2.0
// Header text of NRRD files: place, axes, times and coordinates as the fields that Teem reads, the rest as
// keys.
#include "tool/output/nrrd_output.h"

#include "readers/records.h"
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

// The name of an axis of space or of a slice: its source's, but of time that by which readers know it.
std::string label(const VolumeOutput& o, size_t a) {
  const std::string usual = o.axis_names[a].empty() ? std::string(1, "xyz"[a]) : o.axis_names[a];
  const std::string name = text_in(read_record(o.axis_records[a]), "name");
  return name.empty() || usual == "t" ? usual : name;
}

// Names and units of the axes, where there is anything to tell.
std::string axes_text(const VolumeOutput& o) {
  std::string labels, units;
  bool named = o.series || !o.axis_names[0].empty(), any_unit = false;
  for (size_t a = 0; a < 3; ++a) {
    named = named || !o.axis_records[a].empty(), any_unit = any_unit || !o.axis_units[a].empty();
    labels += " " + quoted(label(o, a)), units += " " + quoted(o.axis_units[a]);
  }
  return concat(any_unit ? concat("space units:", units, "\n") : "",
                named ? concat("labels:", labels, o.series ? " \"t\"" : "", "\n") : "",
                o.series ? concat("units: \"\" \"\" \"\" ", quoted(o.time_unit), "\n") : "");
}

// The keys that hold what the source says of axes and values.
std::string record_text(const std::string& of, const std::string& record) {
  return record.empty() ? "" : concat(of, " attributes:=", one_line(record), "\n");
}

} // namespace

std::vector<std::pair<std::string, std::string>> time_keys(double time, const std::string& unit) {
  std::vector<std::pair<std::string, std::string>> keys{{"time", concat(time)}};
  if (const std::string line = one_line(unit); !line.empty()) keys.emplace_back("time unit", line);
  return keys;
}

std::string nrrd_header_text(const VolumeOutput& o) {
  const bool series = o.series;
  std::string text =
      concat("NRRD0005\n# written by bcc4\ntype: ", nrrd_type(o.type), "\ndimension: ", series ? 4 : 3, "\n");
  text += field("content", o.name);
  if (o.space.empty())
    text += "space dimension: 3\n";
  else
    text += concat("space: ", o.space, "\n");
  text += "sizes:";
  for (const uint64_t n : o.dims) text += concat(" ", n);
  text += (series ? concat(" ", o.times.size()) : "") + "\nspace directions:";
  for (size_t a = 0; a < 3; ++a)
    text += concat(" (", o.affine[a], ",", o.affine[4 + a], ",", o.affine[8 + a], ")");
  text += series ? " none" : "";
  text += concat("\nspace origin: (", o.affine[3], ",", o.affine[7], ",", o.affine[11], ")\n");
  text += concat("kinds: domain domain domain", series ? " time" : "", "\n");
  text += axes_text(o);
  text += field("sample units", o.unit);
  text += "endian: little\nencoding: raw\n";
  for (size_t a = 0; a < 3; ++a) {
    text += index_values(a, o.coordinates[a]);
    const std::string unit = one_line(o.axis_units[a]);
    if (!o.coordinates[a].empty() && o.coordinates_down[a])
      text += concat("axis ", a, " index positive:=down\n");
    if (!o.coordinates[a].empty() && !unit.empty()) text += concat("axis ", a, " index unit:=", unit, "\n");
  }
  if (series) text += index_values(3, o.times);
  if (!series && !o.times.empty())
    for (const auto& [key, value] : time_keys(o.times[0], o.time_unit))
      text += concat(key, ":=", value, "\n");
  if (!o.epoch.empty()) text += concat("time epoch:=", one_line(o.epoch), "\n");
  if (!o.calendar.empty()) text += concat("time calendar:=", one_line(o.calendar), "\n");
  for (size_t a = 0; a < o.axis_records.size(); ++a)
    text += record_text(concat("axis ", a), o.axis_records[a]);
  text += record_text("sample", o.record);
  for (const auto& [key, value] : o.keys) text += concat(key, ":=", one_line(value), "\n");
  return text + "\n";
}

} // namespace bcc4
