// SPDX-License-Identifier: Apache-2.0
// An OpenVDB file: what its scalar grids are, and their voxels as boxes. Only the vdb files know OpenVDB.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "readers/affine.h"
#include "readers/frame_reader.h"
#include "readers/vdb/vdb_metadata.h"

namespace bcc4 {

// A box in the index space of the grid; `end` is exclusive, and the box is empty when end <= begin.
struct VdbBounds {
  std::array<int32_t, 3> begin{INT32_MAX, INT32_MAX, INT32_MAX};
  std::array<int32_t, 3> end{INT32_MIN, INT32_MIN, INT32_MIN};
  [[nodiscard]] bool empty() const { return end[0] <= begin[0]; }
  void unite(const VdbBounds& other);
};

struct VdbGridInfo {
  std::string name;
  std::string own_name; // without the number that tells it from others
  std::string grid_class;
  std::string tree_type;
  Type type = Type::f32;      // of the voxels handed out
  Type precision = Type::f32; // f16 for float grids saved as halves
  bool level_set = false;
  double background = 0;          // only when asked for
  VdbBounds bounds;               // of the active voxels
  std::optional<uint64_t> active; // how many they are
  Affine affine{};                // grid index -> world
  VdbTold told{};
};

class VdbFile {
 public:
  explicit VdbFile(const std::string& path);
  ~VdbFile();
  VdbFile(const VdbFile&) = delete;
  VdbFile& operator=(const VdbFile&) = delete;

  [[nodiscard]] const std::string& path() const;
  // Returns the names of all grids, one that is there twice with its number: "density[1]".
  [[nodiscard]] std::vector<std::string> names();
  // Returns the names of the grids that can be read: scalars that are no points.
  [[nodiscard]] std::vector<std::string> scalar_names();
  // Reads the metadata only, unless the file does not say its bounds. With `fog` level sets are read as fog,
  // 1 inside, falling to 0 at the surface. Throws for unknown names (with the nearest), points, vectors and
  // non-linear transforms.
  [[nodiscard]] VdbGridInfo read_info(const std::string& name, bool with_background, bool fog);
  // Reads the voxels of a grid as dense boxes relative to `origin` within `dims`; at most `memory_limit`
  // bytes. Throws when its background is another.
  [[nodiscard]] Frame read_frame(const std::string& name, const std::array<int32_t, 3>& origin,
                                 const std::array<uint64_t, 4>& dims, double background,
                                 uint64_t memory_limit, bool fog);

 private:
  class Archive;
  std::unique_ptr<Archive> archive_;
};

} // namespace bcc4
