// SPDX-License-Identifier: Apache-2.0
// What the tests of the readers share: a folder of their own, files, and frames as plain arrays.
#pragma once

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "readers/frame_reader.h"
#include "readers/open_series.h"
#include "tool/exit.h"

namespace bcc4::test {

// A folder named after the test, emptied at the start and removed at the end.
class Scratch {
 public:
  Scratch() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ =
        std::filesystem::temp_directory_path() / concat("bcc4-", info->test_suite_name(), "-", info->name(),
                                                        "-", testing::UnitTest::GetInstance()->random_seed());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~Scratch() { std::filesystem::remove_all(folder_); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  // Writes a file and returns its path.
  std::string file(const std::string& name, const std::string& content) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(path(name), std::ios::binary) << content;
    return path(name);
  }

 private:
  std::filesystem::path folder_;
};

template<class T> std::string bytes_of(const std::vector<T>& values, bool swapped = false) {
  std::string out(values.size() * sizeof(T), '\0');
  std::memcpy(out.data(), values.data(), out.size());
  if (swapped)
    for (size_t i = 0; i < out.size(); i += sizeof(T))
      std::reverse(out.begin() + i, out.begin() + (i + sizeof(T)));
  return out;
}

inline std::string gzipped(const std::string& data) {
  z_stream z{};
  deflateInit2(&z, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&z, static_cast<uLong>(data.size())) + 64, '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
  z.avail_in = static_cast<uInt>(data.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

// Returns a frame as nx * ny * nz values, x fastest.
inline std::vector<double> dense(FrameReader& reader, uint64_t frame, size_t channel = 0) {
  const SeriesDescription& d = reader.description();
  const uint64_t plane = d.dims[0] * d.dims[1];
  std::vector<double> out(plane * d.dims[2]);
  const Frame f = reader.read(frame, channel);
  for (uint64_t z = 0; z < d.dims[2]; ++z)
    gather_plane(f, d.dims, z, d.channels[channel].air, out.data() + z * plane);
  return out;
}

// The error of opening (and reading all frames of) something that must not work.
struct Refusal {
  Exit exit = Exit::ok;
  std::string text;
};
inline Refusal refusal(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& e) {
    return {exit_of(e.code()), e.what()};
  }
  return {Exit::ok, "nothing was refused"};
}
inline Refusal refusal(const ReaderOptions& options) {
  return refusal([&] {
    const auto reader = open_series(options);
    for (uint64_t f = 0; f < reader->description().dims[3]; ++f)
      for (size_t c = 0; c < reader->description().channels.size(); ++c) (void)reader->read(f, c);
  });
}
#define EXPECT_REFUSED(refused, code, part)                                                                  \
  do {                                                                                                       \
    const auto r_ = (refused);                                                                               \
    EXPECT_EQ(static_cast<int>(r_.exit), static_cast<int>(code)) << r_.text;                                 \
    EXPECT_NE(r_.text.find(part), std::string::npos) << r_.text;                                             \
  } while (false)

inline ReaderOptions inputs(std::vector<std::string> paths) {
  ReaderOptions o;
  o.inputs = std::move(paths);
  return o;
}

} // namespace bcc4::test
