// SPDX-License-Identifier: Apache-2.0
#include "smoke/output.h"

#include <bit>
#include <cstdio>
#include <fstream>
#include <stdexcept>

namespace smoke {

static_assert(std::endian::native == std::endian::little, "raw files are little-endian");

std::filesystem::path frame_path(const std::filesystem::path& folder, const char* name, int frame,
                                 const char* extension) {
  char file[60];
  std::snprintf(file, sizeof file, "%s.%04d.%s", name, frame, extension);
  return folder / file;
}

void write_raw(const std::filesystem::path& path, const Grid& grid) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(grid.samples.data()), grid.samples.size() * sizeof(float));
  file.close();
  if (!file) throw std::runtime_error("cannot write " + path.string());
}

} // namespace smoke
