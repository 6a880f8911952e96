// SPDX-License-Identifier: Apache-2.0
// Parses the XML of a .vti file up to its appended data, and finds there or behind it what arrays hold.
#include "readers/vti/vti_file.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <ranges>

#include "readers/error.h"
#include "readers/places.h"
#include "readers/vti/xml.h"

namespace bcc4 {
namespace {

constexpr std::string_view kAppended = "<AppendedData";

// Returns the file's text without its appended data, which are no XML, and puts where they begin into
// `appended`. Bytes are read in chunks, for appended data can be large.
std::string read_header_text(InputFile& file, uint64_t& appended) {
  std::string text;
  for (;;) {
    const size_t before = text.size(), chunk = 1 << 16;
    text.resize(before + chunk);
    const size_t got = file.read_some(before, std::as_writable_bytes(std::span(text)).subspan(before));
    text.resize(before + got);
    const size_t from = before < kAppended.size() ? 0 : before - kAppended.size();
    if (const size_t tag = text.find(kAppended, from); tag != std::string::npos) {
      if (const size_t end = text.find('>', tag); end != std::string::npos && text[end - 1] != '/') {
        appended = end + 1;
        text.resize(end + 1);
        return text + "</AppendedData></VTKFile>";
      }
    }
    if (got < chunk) return text;
  }
}

// "" where there is none.
std::string_view attribute(pugi::xml_node e, const char* key) { return e.attribute(key).value(); }

std::array<int64_t, 6> extent_of(pugi::xml_node e, const char* key, const std::string& path) {
  const auto parts = split(attribute(e, key));
  std::array<int64_t, 6> out{};
  if (parts.size() != 6) fail_input(path, ": ", e.name(), " needs six numbers in ", key);
  for (size_t i = 0; i < 6; ++i) {
    const auto n = parse_number<int32_t>(parts[i]);
    if (!n) fail_input(path, ": \"", parts[i], "\" in ", key, " is no number");
    out[i] = *n;
  }
  return out;
}

std::vector<double> numbers_of(pugi::xml_node e, const char* key, std::vector<double> otherwise,
                               const std::string& path) {
  if (attribute(e, key).empty()) return otherwise;
  const auto numbers = parse_numbers(split(attribute(e, key)));
  if (!numbers || numbers->size() != otherwise.size())
    fail_input(path, ": ", key, " needs ", otherwise.size(), " numbers");
  for (const double n : *numbers)
    if (!std::isfinite(n)) fail_input(path, ": ", key, " is not finite");
  return *numbers;
}

} // namespace

VtiFile::VtiFile(const std::string& path)
    : path_(path), file_(path), text_(read_header_text(file_, appended_)) {
  parse_xml(text_, path_, document_);
  const pugi::xml_node root = document_.document_element();
  rectilinear_ = attribute(root, "type") == "RectilinearGrid";
  const pugi::xml_node image = root.child(rectilinear_ ? "RectilinearGrid" : "ImageData");
  if (attribute(root, "type") == "PImageData")
    fail_input(path,
               ": an image in several files (.pvti), which are not joined: save it as one .vti, such as by "
               "Save Data of ParaView");
  if (root.name() != std::string_view("VTKFile") || (attribute(root, "type") != "ImageData" && !rectilinear_))
    fail_input(path, ": not a VTK ImageData (.vti) or RectilinearGrid (.vtr) file");
  const std::string_view compressor = attribute(root, "compressor");
  coding_.compressed = !compressor.empty();
  if (coding_.compressed && compressor != "vtkZLibDataCompressor")
    fail_input(path, ": compressed with ", compressor, ", which cannot be read; vtkZLibDataCompressor can");
  coding_.swap = needs_swap(attribute(root, "byte_order") == "BigEndian");
  coding_.count_size = attribute(root, "header_type") == "UInt64" ? 8 : 4;
  if (!image) fail_input(path, ": no ", rectilinear_ ? "RectilinearGrid" : "ImageData", " element");
  const auto pieces = std::ranges::distance(image.children("Piece"));
  if (pieces != 1) fail_input(path, ": ", pieces, " pieces; files of one piece can be read");
  if (appended_ > 0) find_appended(root.child("AppendedData"));
  find_arrays(image.child("Piece"));
  count_samples(image);
  rectilinear_ ? read_coordinates(image) : read_geometry(image);
  for (const pugi::xml_node holder : {image, root})
    if (!time_) find_time(holder.child("FieldData"));
}

void VtiFile::find_appended(pugi::xml_node element) {
  appended_base64_ = attribute(element, "encoding") == "base64";
  std::byte blank[256];
  const size_t got = file_.read_some(appended_, blank);
  const auto mark = std::find(blank, blank + got, std::byte{'_'});
  if (mark == blank + got) fail_input(path_, ": no \"_\" before the appended data");
  appended_ += static_cast<uint64_t>(mark - blank) + 1;
}

void VtiFile::find_time(pugi::xml_node fields) {
  for (const pugi::xml_node e : fields.children()) {
    const auto type = type_by_name(attribute(e, "type"));
    const std::string name = lower(attribute(e, "Name"));
    const bool of_visit = name == "time" && attribute(e, "NumberOfTuples") == "1" && !time_;
    if ((name != "timevalue" && !of_visit) || !type) continue;
    const Bytes value = decode(e, *type, 1);
    time_ = visit_type(*type, [&](auto zero) { return load_as<decltype(zero)>(value.data()); });
  }
}

// What no file of this size can hold is refused before anything is read for it.
void VtiFile::count_samples(pugi::xml_node image) {
  const auto extent = extent_of(image.child("Piece"), "Extent", path_);
  uint64_t total = 1;
  for (size_t a = 0; a < 3; ++a) {
    const int64_t samples = extent[2 * a + 1] - extent[2 * a] + (cell_data_ ? 0 : 1);
    if (samples < 1) fail_input(path_, ": the extent has no samples along axis ", a);
    dims_[a] = samples;
    if (total > largest_inflated(file_.size()) / dims_[a]) // no type is smaller than a byte
      fail_input(path_, ": an extent of ", attribute(image.child("Piece"), "Extent"), " cannot fit into ",
                 file_.size(), " bytes");
    total *= dims_[a];
  }
}

void VtiFile::read_geometry(pugi::xml_node image) {
  const auto extent = extent_of(image.child("Piece"), "Extent", path_);
  const auto spacing = numbers_of(image, "Spacing", {1, 1, 1}, path_);
  const auto origin = numbers_of(image, "Origin", {0, 0, 0}, path_);
  const auto direction = numbers_of(image, "Direction", {1, 0, 0, 0, 1, 0, 0, 0, 1}, path_);
  std::array<std::array<double, 3>, 3> columns{};
  for (size_t a = 0; a < 3; ++a)
    for (size_t row = 0; row < 3; ++row) columns[a][row] = direction[row * 3 + a] * spacing[a];
  std::array<double, 3> begin{};
  for (size_t a = 0; a < 3; ++a) begin[a] = static_cast<double>(extent[2 * a]) + (cell_data_ ? 0.5 : 0);
  affine_ = moved_origin(affine_from_columns(columns, {origin[0], origin[1], origin[2]}), begin);
  if (!(std::abs(determinant(affine_)) > 0)) fail_input(path_, ": Spacing and Direction span no volume");
}

// The three arrays of a rectilinear grid tell where its points stand; cells lie half way between two.
void VtiFile::read_coordinates(pugi::xml_node grid) {
  std::array<std::array<double, 3>, 3> columns{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  std::array<double, 3> origin{};
  size_t a = 0;
  for (const pugi::xml_node e : grid.child("Piece").child("Coordinates").children("DataArray")) {
    const auto type = type_by_name(attribute(e, "type"));
    if (a == 3 || !type) fail_input(path_, ": Coordinates should be three arrays of numbers");
    const uint64_t points = dims_[a] + (cell_data_ ? 1 : 0);
    const Bytes bytes = decode(e, *type, points);
    std::vector<double> at(points);
    visit_type(*type, [&](auto zero) {
      using T = decltype(zero);
      for (uint64_t i = 0; i < points; ++i)
        at[i] = static_cast<double>(load_as<T>(bytes.data() + i * sizeof(T))) + 0.0; // not -0
    });
    for (uint64_t i = 0; cell_data_ && i + 1 < points; ++i) at[i] = (at[i] + at[i + 1]) / 2;
    at.resize(dims_[a]);
    if (!strictly_monotonic(at))
      fail_input(path_, ": coordinates along ", "xyz"[a], " do not rise or fall throughout");
    origin[a] = at.front();
    if (at.size() > 1) columns[a][a] = mean_step(at);
    if (at.size() > 1 && !evenly_spaced(at)) coordinates_[a] = at;
    ++a;
  }
  if (a != 3) fail_input(path_, ": Coordinates should be three arrays of numbers");
  affine_ = affine_from_columns(columns, origin);
}

void VtiFile::find_arrays(pugi::xml_node piece) {
  pugi::xml_node data = piece.child("PointData");
  if (!data.child("DataArray")) {
    data = piece.child("CellData");
    cell_data_ = true;
  }
  active_ = attribute(data, "Scalars");
  for (const pugi::xml_node e : data.children("DataArray")) {
    const pugi::xml_node unit = e.find_child_by_attribute("InformationKey", "name", "UNITS_LABEL");
    VtiArray array{.name = std::string(attribute(e, "Name")),
                   .unit = std::string(trim(unit.child_value())),
                   .element = e};
    const auto type = type_by_name(attribute(e, "type"));
    if (!type || *type == Type::f16) continue; // strings and the like
    array.type = *type;
    if (const std::string_view n = attribute(e, "NumberOfComponents"); !n.empty()) {
      const auto components = parse_number<uint64_t>(n);
      if (!components || *components < 1 || *components > 64)
        fail_input(path_, ": array ", array.name, " has ", n, " components");
      array.components = *components;
    }
    arrays_.push_back(std::move(array));
  }
  if (arrays_.empty()) fail_input(path_, ": no array of numbers at its points or cells");
}

std::string VtiFile::storage(const VtiArray& array) const {
  return concat(type_name(array.type), ", ", attribute(array.element, "format"),
                coding_.compressed ? ", zlib blocks" : "");
}

VtiSource VtiFile::source_of(pugi::xml_node e, const VtiContent& content, std::string& text) {
  VtiSource source{path_};
  const std::string_view format = attribute(e, "format");
  if (format == "binary") {
    source.base64 = e.child_value();
    return source;
  }
  if (format != "appended") content.refuse(" has the unknown format \"", format, "\"");
  const auto offset = parse_number<uint64_t>(attribute(e, "offset"));
  if (!offset || appended_ == 0 || *offset > file_.size() - appended_)
    content.refuse(" has no data at offset ", attribute(e, "offset"));
  if (appended_base64_) {
    text.resize(file_.size() - appended_ - *offset);
    file_.read(appended_ + *offset, std::as_writable_bytes(std::span(text)));
    text.resize(std::min(text.find('<'), text.size()));
    source.base64 = text;
  } else {
    source.file = &file_;
    source.offset = appended_ + *offset;
  }
  return source;
}

Bytes VtiFile::decode(pugi::xml_node e, Type type, uint64_t count) {
  const VtiContent content{path_, attribute(e, "Name"), type, count, file_.size()};
  if (attribute(e, "format") == "ascii") return decode_text(e.child_value(), content);
  std::string text; // appended base64
  Bytes out = decode_bytes(source_of(e, content, text), coding_, content);
  if (coding_.swap) swap_bytes(out, type_size(type));
  return out;
}

Bytes VtiFile::values(const VtiArray& array) {
  return decode(array.element, array.type, dims_[0] * dims_[1] * dims_[2] * array.components);
}

} // namespace bcc4
