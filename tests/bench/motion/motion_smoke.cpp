// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/motion/motion_smoke.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "base/error.h"
#include "base/files.h"
#include "base/text.h"

namespace bccsplat::bench {

#ifdef BCCSPLAT_BENCH_SMOKE

std::optional<FitSource> simulated_smoke(uint32_t edge, uint32_t frames) {
  std::string folder = (std::filesystem::temp_directory_path() / "bccsplat-smoke-XXXXXX").string();
  if (!::mkdtemp(folder.data())) fail(Code::io_error, "cannot make a folder ", folder);
  const std::string command = concat("'", BCCSPLAT_BENCH_SMOKE, "' --size ", edge, " --steps ", frames,
                                     " --raw --threads 1 -o '", folder, "' 2>/dev/null");
  if (std::system(command.c_str()) != 0) fail(Code::io_error, "cannot run ", command);
  FitSource smoke{"smoke", {edge, edge, edge, frames}, SourceType::f32, {}};
  smoke.bytes.resize(smoke.frame_bytes() * frames);
  for (uint32_t t = 0; t < frames; ++t) {
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), "/smoke.%04u.raw", t);
    const auto file = open_file_source(folder + name.data());
    file->read_at(0, std::span(smoke.bytes).subspan(t * smoke.frame_bytes(), smoke.frame_bytes()));
  }
  std::filesystem::remove_all(folder);
  return smoke;
}

#else

std::optional<FitSource> simulated_smoke(uint32_t, uint32_t) { return std::nullopt; }

#endif

} // namespace bccsplat::bench
