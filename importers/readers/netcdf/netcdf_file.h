// SPDX-License-Identifier: Apache-2.0
// A NetCDF file as plain data: variables, dimensions, attributes, of all its groups. It is not for concurrent
// use, for the library takes no locks.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "readers/records.h"
#include "readers/value_type.h"

namespace bcc4 {

struct NetcdfDimension {
  int id = 0; // no other dimension of the file has it, whatever its group
  std::string name;
  uint64_t size = 0;
  bool record = false; // unlimited
};

struct NetcdfVariable {
  int group = 0, id = 0;
  std::string name;                  // with its groups: run1/f
  std::string leaf;                  // without: f
  std::optional<Type> type;          // nothing for text, structures and the like
  std::vector<NetcdfDimension> dims; // slowest first
  bool text = false;                 // characters or strings
};

// A coordinate variable says where the samples of a dimension of its name are.
[[nodiscard]] inline bool is_coordinate(const NetcdfVariable& v) {
  return v.dims.size() == 1 && v.dims[0].name == v.leaf;
}

class NetcdfFile {
 public:
  explicit NetcdfFile(const std::string& path);
  ~NetcdfFile();
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] const std::vector<NetcdfVariable>& variables() const { return variables_; }
  [[nodiscard]] const NetcdfVariable* find(const std::string& name) const;
  // Finds what a variable calls `name`: in its own group, or else in the nearest that this one is in.
  [[nodiscard]] const NetcdfVariable* near(const NetcdfVariable& variable, const std::string& name) const;
  // Finds the numbers that tell where the samples along a dimension of the variable are.
  [[nodiscard]] const NetcdfVariable* coordinate(const NetcdfVariable& variable,
                                                 const NetcdfDimension& dim) const;

  // These return attributes; nothing when they are absent or of the other sort.
  [[nodiscard]] std::string text(const NetcdfVariable& variable, const char* name) const;
  [[nodiscard]] std::vector<double> numbers(const NetcdfVariable& variable, const char* name) const;
  [[nodiscard]] std::optional<Type> type_of_numbers(const NetcdfVariable& variable, const char* name) const;
  // Returns all attributes that a record has, text as UTF-8; `of_time` as of in_record().
  [[nodiscard]] Record attributes(const NetcdfVariable& variable, bool of_time = false) const;
  // Returns the value of what was never written, where the file does not switch filling off.
  [[nodiscard]] std::optional<double> default_fill(const NetcdfVariable& variable) const;

  // Reads the hyperslab [start, start + count) in the variable's own type and native byte order.
  void read(const NetcdfVariable& variable, std::span<const size_t> start, std::span<const size_t> count,
            std::span<std::byte> out) const;
  // Returns all of a variable of one dimension, or of a single number, as doubles, as they are stored.
  [[nodiscard]] std::vector<double> line(const NetcdfVariable& variable) const;
  // Returns all of a variable of text: strings over one dimension or characters over two.
  [[nodiscard]] std::vector<std::string> lines(const NetcdfVariable& variable) const;
  // Returns the bytes of the chunks in which the variable is compressed; 0 when it is not.
  [[nodiscard]] uint64_t chunk_bytes(const NetcdfVariable& variable) const;

 private:
  template<class... Parts> void check(int status, const Parts&... doing) const;
  [[nodiscard]] std::vector<std::string> texts(const NetcdfVariable& variable, const char* name) const;
  void add_group(int group, const std::string& folder, std::vector<int> records);
  void add_variable(int group, int id, const std::string& folder, const std::vector<int>& records);

  std::string path_;
  int id_ = -1;
  std::vector<NetcdfVariable> variables_;
};

} // namespace bcc4
