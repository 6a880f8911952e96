// SPDX-License-Identifier: Apache-2.0
// The header of a MetaImage file and where its data are.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "readers/byte_stream.h"

namespace bcc4 {

struct MetaImageHeader {
  std::string path;
  Type type = Type::u8;
  std::vector<uint64_t> sizes; // fastest first
  uint64_t channels = 1;       // values per element, fastest
  bool big_endian = false;
  Encoding encoding = Encoding::raw;
  double slope = 1, intercept = 0;          // value = slope * stored + intercept
  std::vector<double> spacing;              // one per axis; empty: not given
  std::vector<double> origin;               // likewise
  std::vector<double> direction;            // row a: the world direction of axis a; empty: not given
  std::map<std::string, std::string> other; // keys that do not say how to read the data
  int64_t skip = 0;                    // bytes before the data of each file; -1: the data are the last bytes
  std::vector<std::string> data_files; // the file itself when the data are attached
  uint64_t data_offset = 0;            // of attached data
};

// Throws naming the file and the line for anything malformed. Data files outside the folder of the header are
// refused.
[[nodiscard]] MetaImageHeader read_metaimage_header(const std::string& path);

// Returns one segment per data file, each an equal share of the array.
[[nodiscard]] std::vector<Segment> metaimage_segments(const MetaImageHeader& header, uint64_t total_bytes);

} // namespace bcc4
