// SPDX-License-Identifier: Apache-2.0
// The header of a NRRD file, field by field. Format: Teem's "Definition of NRRD File Format" (NRRD0001 ..
// NRRD0005).
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "readers/byte_stream.h"

namespace bcc4 {

struct NrrdAxis {
  uint64_t size = 0;
  std::string kind; // lower case, "" when unknown
  std::string label;
  std::string unit;
  std::optional<double> spacing, min, max;
  std::optional<bool> cells;                    // samples are cells, or nodes; unknown
  std::optional<std::vector<double>> direction; // world vector; absent or "none": not in space
};

struct NrrdHeader {
  std::string path;
  int version = 0;
  Type type = Type::u8;
  std::vector<NrrdAxis> axes; // fastest first
  Encoding encoding = Encoding::raw;
  bool big_endian = false;
  bool endian_given = false;
  std::string space; // "left-posterior-superior", ...
  std::optional<std::vector<double>> origin;
  std::vector<std::string> space_units;
  bool has_directions = false;
  uint64_t line_skip = 0;
  int64_t byte_skip = 0; // -1: the data are the last bytes of the file
  std::string content;   // what the values are
  std::string sample_unit;
  std::map<std::string, std::string> keys; // key:=value
  bool attached = true;
  uint64_t data_offset = 0;            // of attached data
  std::vector<std::string> data_files; // detached, as full paths
};

// Throws naming the file and the line for anything malformed, unknown encodings included. Data files outside
// the folder of the header are refused.
[[nodiscard]] NrrdHeader read_nrrd_header(const std::string& path);

// Returns one segment per data file (or the attached data), each an equal share of the array.
[[nodiscard]] std::vector<Segment> nrrd_segments(const NrrdHeader& header, uint64_t total_bytes);

} // namespace bcc4
