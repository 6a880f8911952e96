// SPDX-License-Identifier: Apache-2.0
// One VTK XML ImageData file (.vti), or RectilinearGrid (.vtr): its header and its arrays.
// Format: VTK File Formats, "XML File Formats" (serial ImageData and RectilinearGrid; ascii, binary and
// appended data, zlib blocks).
#pragma once

#include <pugixml.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "readers/affine.h"
#include "readers/byte_stream.h"
#include "readers/frame_reader.h"
#include "readers/vti/vti_data.h"

namespace bcc4 {

struct VtiArray {
  std::string name;
  Type type = Type::f32;
  uint64_t components = 1;
  std::string unit;
  pugi::xml_node element;
};

class VtiFile {
 public:
  explicit VtiFile(const std::string& path);
  VtiFile(const VtiFile&) = delete;
  VtiFile& operator=(const VtiFile&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] const std::array<uint64_t, 3>& dims() const { return dims_; }
  [[nodiscard]] const Affine& affine() const { return affine_; }
  // Coordinates of the samples of a rectilinear grid, along the axes where they are uneven.
  [[nodiscard]] const std::array<std::vector<double>, 3>& coordinates() const { return coordinates_; }
  [[nodiscard]] bool rectilinear() const { return rectilinear_; }
  [[nodiscard]] bool cell_data() const { return cell_data_; }
  [[nodiscard]] const std::vector<VtiArray>& arrays() const { return arrays_; }
  // Returns the name of the array marked as the active scalars, "" when none is.
  [[nodiscard]] const std::string& active() const { return active_; }
  [[nodiscard]] std::optional<double> time() const { return time_; }
  // Returns text such as "appended, zlib blocks, Float32".
  [[nodiscard]] std::string storage(const VtiArray& array) const;
  // Returns all values of an array, in native byte order, components fastest.
  [[nodiscard]] Bytes values(const VtiArray& array);

 private:
  void read_geometry(pugi::xml_node image);
  void count_samples(pugi::xml_node image);
  void read_coordinates(pugi::xml_node grid);
  void find_appended(pugi::xml_node element);
  void find_time(pugi::xml_node fields);
  void find_arrays(pugi::xml_node piece);
  // Finds where the bytes of an array are; `text` is room for appended base64.
  [[nodiscard]] VtiSource source_of(pugi::xml_node element, const VtiContent& content, std::string& text);
  [[nodiscard]] Bytes decode(pugi::xml_node element, Type type, uint64_t count);

  std::string path_;
  InputFile file_;
  uint64_t appended_ = 0; // file offset behind the start tag of the appended data, then of the data; 0: none
  std::string text_;      // what the document stands in, without appended data
  pugi::xml_document document_;
  bool appended_base64_ = false;
  VtiCoding coding_;
  std::array<uint64_t, 3> dims_{};
  Affine affine_{};
  bool cell_data_ = false, rectilinear_ = false;
  std::array<std::vector<double>, 3> coordinates_;
  std::vector<VtiArray> arrays_;
  std::string active_;
  std::optional<double> time_;
};

} // namespace bcc4
