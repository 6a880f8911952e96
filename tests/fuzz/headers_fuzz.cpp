// SPDX-License-Identifier: Apache-2.0
// Fuzzed bytes as a file of a foreign format: its header, and the first and last frame.
// Input: one byte for the format, raw only: sizes and options; then the file.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "fuzz_target.h"
#include "readers/error.h"
#include "readers/open_series.h"

namespace {

namespace fs = std::filesystem;

constexpr size_t largest_input = 64 << 10;
constexpr uint64_t largest_frame = 2 << 20; // bytes; larger ones are only described

// A folder of this process, on a memory disk where there is one.
const fs::path& folder() {
  struct Folder {
    fs::path path;
    Folder() {
      const fs::path top = fs::exists("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path();
      path = top / ("bccsplat-fuzz-" + std::to_string(::getpid()));
      fs::create_directories(path);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    ~Folder() {
      std::error_code ignored;
      fs::remove_all(path, ignored);
    }
  };
  static const Folder once;
  return once.path;
}

constexpr const char* names[] = {"in.nrrd", "in.nhdr", "in.nii", "in.vti", "in.pvd", "in.raw", "in.nii.gz"};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size > largest_input) return 0;
  fuzz::Input input(data, size);
  const std::string name = names[input.below(std::size(names))];
  bcc4::ReaderOptions options;
  options.max_memory = 64 << 20;
  if (name == "in.raw") {
    const uint32_t given = input.take<uint8_t>();
    options.dims = {input.take<uint16_t>(), input.take<uint8_t>(), input.take<uint8_t>(),
                    input.take<uint8_t>()};
    options.dtype = static_cast<bcc4::Type>(input.below(11));
    if (given & 1) options.big_endian = (given & 2) != 0;
    if (given & 4) options.skip = input.take<uint16_t>();
    if (given & 8) options.axes = std::string{"xyzt"[input.below(4)], "yxzt"[input.below(4)], 'z', 't'};
    if (given & 16) options.dt = input.take<double>();
    if (given & 32) options.times = std::vector<double>{input.take<double>(), input.take<double>()};
  }
  const fs::path path = folder() / name;
  {
    std::ofstream out(path, std::ios::binary | std::ios::trunc);
    const auto rest = input.rest();
    out.write(reinterpret_cast<const char*>(rest.data()), rest.size());
  }
  options.inputs = {path.string()};
  try {
    const auto reader = bcc4::open_series(options);
    const bcc4::SeriesDescription& s = reader->description();
    fuzz::expect(s.times.values.size() == s.dims[3], "one time per frame");
    for (size_t i = 1; i < s.times.values.size(); ++i)
      fuzz::expect(s.times.values[i] > s.times.values[i - 1], "times rise");
    fuzz::expect(!s.channels.empty(), "a series has a channel");
    for (size_t c = 0; c < s.channels.size(); ++c) {
      const uint64_t plane = s.dims[0] * s.dims[1];
      if (plane > largest_frame / 8 || plane * s.dims[2] > largest_frame / 8) continue;
      for (const uint64_t f : {uint64_t{0}, s.dims[3] - 1}) {
        const bcc4::Frame frame = reader->read(f, c);
        std::vector<double> values(plane);
        for (uint64_t z = 0; z < s.dims[2]; ++z)
          bcc4::gather_plane(frame, s.dims, z, s.channels[c].air, values.data());
      }
    }
  } catch (const bcc4::Error& e) {
    fuzz::expect(*e.what() != 0, "an error without a text");
  }
  return 0;
}
