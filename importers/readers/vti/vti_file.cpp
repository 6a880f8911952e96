// SPDX-License-Identifier: Apache-2.0
// Parses the XML of a .vti file up to its appended data and decodes its arrays, written as text, base64 or
// raw bytes, in one piece or in zlib blocks.
#include "readers/vti/vti_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <ranges>

#include "readers/decoders.h"
#include "readers/error.h"
#include "readers/vti/base64.h"
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

// Where the bytes of an array come from: the file or base64 text.
struct Source {
  const std::string& path;
  InputFile* file = nullptr;
  uint64_t offset = 0;
  std::string_view base64{};

  [[nodiscard]] uint64_t left() const {
    if (!file) return base64.size() / 4 * 3 + 3;
    return offset < file->size() ? file->size() - offset : 0;
  }
  Bytes take(uint64_t bytes) {
    if (bytes > left())
      fail_input(path, ": ", bytes, " bytes of data are declared where ", left(), " are left");
    if (!file) return take_base64(base64, bytes, path);
    Bytes out(bytes);
    file->read(offset, out);
    offset += bytes;
    return out;
  }
};

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
  const pugi::xml_node root = document_.document_element(), image = root.child("ImageData");
  if (root.name() != std::string_view("VTKFile") || attribute(root, "type") != "ImageData")
    fail_input(path, ": not a VTK ImageData file (.vti)");
  const std::string_view compressor = attribute(root, "compressor");
  compressed_ = !compressor.empty();
  if (compressed_ && compressor != "vtkZLibDataCompressor")
    fail_input(path, ": compressed with ", compressor, ", which cannot be read; vtkZLibDataCompressor can");
  swap_ = needs_swap(attribute(root, "byte_order") == "BigEndian");
  count_size_ = attribute(root, "header_type") == "UInt64" ? 8 : 4;
  if (!image) fail_input(path, ": no ImageData element");
  const auto pieces = std::ranges::distance(image.children("Piece"));
  if (pieces != 1) fail_input(path, ": ", pieces, " pieces; files of one piece can be read");
  if (appended_ > 0) find_appended(root.child("AppendedData"));
  find_arrays(image.child("Piece"));
  read_geometry(image);
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
    if (attribute(e, "Name") != "TimeValue" || !type) continue;
    const Bytes value = decode(e, *type, 1);
    time_ = visit_type(*type, [&](auto zero) { return load_as<decltype(zero)>(value.data()); });
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
  uint64_t total = 1;
  for (size_t a = 0; a < 3; ++a) {
    const int64_t samples = extent[2 * a + 1] - extent[2 * a] + (cell_data_ ? 0 : 1);
    if (samples < 1) fail_input(path_, ": the extent has no samples along axis ", a);
    dims_[a] = static_cast<uint64_t>(samples);
    if (total > largest_inflated(file_.size()) / dims_[a]) // no type is smaller than a byte
      fail_input(path_, ": an extent of ", attribute(image.child("Piece"), "Extent"), " cannot fit into ",
                 file_.size(), " bytes");
    total *= dims_[a];
    begin[a] = static_cast<double>(extent[2 * a]) + (cell_data_ ? 0.5 : 0);
  }
  affine_ = moved_origin(affine_from_columns(columns, {origin[0], origin[1], origin[2]}), begin);
  if (!(std::abs(determinant(affine_)) > 0)) fail_input(path_, ": Spacing and Direction span no volume");
}

void VtiFile::find_arrays(pugi::xml_node piece) {
  pugi::xml_node data = piece.child("PointData");
  if (!data.child("DataArray")) {
    data = piece.child("CellData");
    cell_data_ = true;
  }
  active_ = attribute(data, "Scalars");
  for (const pugi::xml_node e : data.children("DataArray")) {
    VtiArray array{.name = std::string(attribute(e, "Name")), .element = e};
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
                compressed_ ? ", zlib blocks" : "");
}

uint64_t VtiFile::load_count(std::span<const std::byte> at) const {
  std::byte bytes[8]{};
  std::copy_n(at.begin(), count_size_, bytes);
  if (swap_) std::reverse(bytes, bytes + count_size_);
  uint64_t value = 0;
  if (count_size_ == 4) {
    uint32_t narrow = 0;
    std::memcpy(&narrow, bytes, 4);
    value = narrow;
  } else {
    std::memcpy(&value, bytes, 8);
  }
  return value;
}

Bytes VtiFile::decode(pugi::xml_node e, Type type, uint64_t count) {
  const uint64_t expected = count * type_size(type);
  const std::string_view format = attribute(e, "format");
  const auto refuse_size = [&](uint64_t bytes) {
    fail_input(path_, ": array ", attribute(e, "Name"), " holds ", bytes, " bytes, but ", count, " values x ",
               type_size(type), " bytes = ", expected, " are expected");
  };
  if (format == "ascii") {
    const auto words = split(e.child_value());
    if (words.size() != count) refuse_size(words.size() * type_size(type));
    Bytes out(expected);
    for (size_t i = 0; i < count; ++i)
      if (!parse_value(words[i], type, out.data() + i * type_size(type)))
        fail_input(path_, ": \"", words[i].substr(0, 40), "\" in array ", attribute(e, "Name"), " is no ",
                   type_name(type));
    return out;
  }
  Source source{path_};
  std::string appended_text;
  if (format == "appended") {
    const auto offset = parse_number<uint64_t>(attribute(e, "offset"));
    if (!offset || appended_ == 0 || *offset > file_.size() - appended_)
      fail_input(path_, ": array ", attribute(e, "Name"), " has no data at offset ", attribute(e, "offset"));
    if (appended_base64_) {
      appended_text.resize(file_.size() - appended_ - *offset);
      file_.read(appended_ + *offset, std::as_writable_bytes(std::span(appended_text)));
      appended_text.resize(std::min(appended_text.find('<'), appended_text.size()));
      source.base64 = appended_text;
    } else {
      source.file = &file_;
      source.offset = appended_ + *offset;
    }
  } else if (format == "binary") {
    source.base64 = e.child_value();
  } else {
    fail_input(path_, ": array ", attribute(e, "Name"), " has the unknown format \"", format, "\"");
  }

  Bytes out;
  if (!compressed_) { // one count, then the bytes, in one base64 run
    if (expected > source.left()) refuse_size(source.left());
    const Bytes all = source.take(count_size_ + expected);
    if (load_count(all) != expected) refuse_size(load_count(all));
    out.assign(all.begin() + static_cast<std::ptrdiff_t>(count_size_), all.end());
  } else { // block count, block size, size of the last block, compressed sizes; then the blocks
    std::string_view rewind = source.base64;
    const Bytes head = source.take(3 * count_size_);
    const uint64_t blocks = load_count(head), block = load_count(std::span(head).subspan(count_size_)),
                   last = load_count(std::span(head).subspan(2 * count_size_));
    if (blocks > source.left() / count_size_ || block > largest_inflated(file_.size()) ||
        (blocks > 0 && (blocks - 1) * block + (last ? last : block) != expected) ||
        (blocks == 0 && expected != 0))
      fail_input(path_, ": array ", attribute(e, "Name"), " declares ", blocks, " blocks of ", block,
                 " bytes, but ", expected, " bytes are expected");
    if (expected > largest_inflated(source.left()))
      fail_input(path_, ": ", source.left(), " compressed bytes cannot hold ", expected);
    Bytes sizes;
    if (source.file) {
      sizes = source.take(blocks * count_size_);
    } else { // the whole head is one base64 run
      source.base64 = rewind;
      const Bytes whole = source.take((3 + blocks) * count_size_);
      sizes.assign(whole.begin() + static_cast<std::ptrdiff_t>(3 * count_size_), whole.end());
    }
    uint64_t compressed = 0;
    for (uint64_t b = 0; b < blocks; ++b) {
      const uint64_t size = load_count(std::span(sizes).subspan(b * count_size_));
      if (size > source.left())
        fail_input(path_, ": block ", b, " of array ", attribute(e, "Name"), " is cut off");
      compressed += size;
    }
    const Bytes data = source.take(compressed);
    out.resize(expected);
    uint64_t from = 0, to = 0;
    for (uint64_t b = 0; b < blocks; ++b) {
      const uint64_t size = load_count(std::span(sizes).subspan(b * count_size_));
      const uint64_t room = b + 1 == blocks && last ? last : block;
      if (!inflate_block(std::span(data).subspan(from, size), std::span(out).subspan(to, room)))
        fail_input(path_, ": block ", b, " of array ", attribute(e, "Name"), " is damaged");
      from += size;
      to += room;
    }
  }
  if (swap_) swap_bytes(out, type_size(type));
  return out;
}

Bytes VtiFile::values(const VtiArray& array) {
  return decode(array.element, array.type, dims_[0] * dims_[1] * dims_[2] * array.components);
}

} // namespace bcc4
