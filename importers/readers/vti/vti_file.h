// SPDX-License-Identifier: Apache-2.0
// One VTK XML ImageData file (.vti): its header and its arrays.
// Format: VTK File Formats, "XML File Formats" (serial ImageData; ascii, binary and appended data, zlib
// blocks).
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

namespace bcc4 {

struct VtiArray {
  std::string name;
  Type type = Type::f32;
  uint64_t components = 1;
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
  void find_appended(pugi::xml_node element);
  void find_time(pugi::xml_node fields);
  void find_arrays(pugi::xml_node piece);
  [[nodiscard]] Bytes decode(pugi::xml_node element, Type type, uint64_t count);
  [[nodiscard]] uint64_t load_count(std::span<const std::byte> at) const;

  std::string path_;
  InputFile file_;
  uint64_t appended_ = 0; // file offset behind the start tag of the appended data, then of the data; 0: none
  std::string text_;      // what the document stands in, without appended data
  pugi::xml_document document_;
  bool appended_base64_ = false;
  bool swap_ = false, compressed_ = false;
  size_t count_size_ = 4; // bytes of a block count or size
  std::array<uint64_t, 3> dims_{};
  Affine affine_{};
  bool cell_data_ = false;
  std::vector<VtiArray> arrays_;
  std::string active_;
  std::optional<double> time_;
};

} // namespace bcc4
