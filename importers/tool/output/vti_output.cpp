// SPDX-License-Identifier: Apache-2.0
#include "tool/output/vti_output.h"

#include <cmath>

#include "readers/text.h"

namespace bcc4 {
namespace {

const char* vtk_type(Type type) {
  switch (type) {
  case Type::u8:
    return "UInt8";
  case Type::i8:
    return "Int8";
  case Type::u16:
    return "UInt16";
  case Type::i16:
    return "Int16";
  case Type::u32:
    return "UInt32";
  case Type::i32:
    return "Int32";
  default:
    return "Float32";
  }
}

// Text inside an attribute or an element.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (static_cast<unsigned char>(c) >= ' ')
      out += c;
  }
  return out;
}

std::string extent_text(const VolumeOutput& o) {
  return concat("0 ", o.dims[0] - 1, " 0 ", o.dims[1] - 1, " 0 ", o.dims[2] - 1);
}

// Origin, spacing and, where the axes are not those of the world, their directions.
std::string place_text(const VolumeOutput& o) {
  const Affine& m = o.affine;
  std::array<double, 3> step{};
  bool turned = false;
  for (size_t a = 0; a < 3; ++a) {
    step[a] = std::hypot(m[a], m[4 + a], m[8 + a]);
    turned = turned || m[4 * a + a] != step[a];
  }
  std::string text = concat("Origin=\"", m[3], " ", m[7], " ", m[11], "\" Spacing=\"", step[0], " ", step[1],
                            " ", step[2], "\"");
  if (!turned) return text;
  text += " Direction=\"";
  for (size_t row = 0; row < 3; ++row)
    for (size_t a = 0; a < 3; ++a)
      text += concat(row + a > 0 ? " " : "", m[4 * row + a] == 0 ? 0 : m[4 * row + a] / step[a]);
  return text + "\"";
}

std::string unit_text(const VolumeOutput& o) {
  if (o.unit.empty()) return "";
  return concat("<InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">", escaped(o.unit),
                "</InformationKey>");
}

} // namespace

VtiText vti_text(const VolumeOutput& o) {
  const std::string name = escaped(o.name), extent = extent_text(o);
  std::string head =
      concat("<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" "
             "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  <ImageData WholeExtent=\"",
             extent, "\" ", place_text(o), ">\n");
  if (!o.times.empty())
    head +=
        concat("    <FieldData>\n      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
               "format=\"ascii\">",
               o.times[0], "</DataArray>\n    </FieldData>\n");
  head += concat("    <Piece Extent=\"", extent, "\">\n      <PointData Scalars=\"", name,
                 "\">\n        <DataArray type=\"", vtk_type(o.type), "\" Name=\"", name,
                 "\" format=\"appended\" offset=\"0\">", unit_text(o), "</DataArray>\n      </PointData>\n",
                 "    </Piece>\n  </ImageData>\n  <AppendedData encoding=\"raw\">\n_");
  uint64_t bytes = o.dims[0] * o.dims[1] * o.dims[2] * type_size(o.type);
  constexpr uint64_t bits = 8, byte = 0xff;
  for (size_t i = 0; i < sizeof bytes; ++i, bytes >>= bits) head += static_cast<char>(bytes & byte);
  return {head, "\n  </AppendedData>\n</VTKFile>\n"};
}

std::string collection_text(const std::vector<std::pair<std::string, double>>& files) {
  std::string text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
                     "byte_order=\"LittleEndian\">\n  <Collection>\n";
  for (const auto& [name, time] : files)
    text +=
        concat("    <DataSet timestep=\"", time, "\" group=\"\" part=\"0\" file=\"", escaped(name), "\"/>\n");
  return text + "  </Collection>\n</VTKFile>\n";
}

} // namespace bcc4
