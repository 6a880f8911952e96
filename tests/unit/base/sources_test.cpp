// SPDX-License-Identifier: Apache-2.0
// What is asked for beyond the end of a source is refused, wherever its bytes are.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "base/machine.h"
#include "base/text.h"

namespace bccsplat {
namespace {

Code code_of(const ByteSource& source, uint64_t offset, size_t size) {
  std::vector<std::byte> out(size);
  try {
    source.read_at(offset, out);
  } catch (const Error& e) {
    return e.code();
  }
  return Code::ok;
}

TEST(ByteSources, RefuseWhatIsBeyondTheirEnd) {
  const std::string path =
      (std::filesystem::temp_directory_path() / concat("bccsplat sources ", machine_process())).string();
  std::array<std::byte, 16> bytes{};
  const auto sink = create_file_sink(path, true);
  sink->write_at(0, bytes);
  sink->commit();
  std::vector<std::unique_ptr<ByteSource>> sources = open_file_sources({path}, 1);
  sources.push_back(open_file_source(path));
  sources.push_back(open_memory_source(bytes));
  sources.push_back(open_stream_source(16, [&](uint64_t offset, std::span<std::byte> out) {
    const size_t size = offset < 16 ? std::min<size_t>(out.size(), 16 - offset) : 0;
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(std::min<uint64_t>(offset, 16)), size,
                out.begin());
    return static_cast<int64_t>(size);
  }));
  for (const auto& source : sources) {
    EXPECT_EQ(code_of(*source, 0, 16), Code::ok) << source->name();
    EXPECT_EQ(code_of(*source, 16, 0), Code::ok) << source->name();
    EXPECT_EQ(code_of(*source, 10, 7), Code::truncated) << source->name();
    EXPECT_EQ(code_of(*source, 17, 1), Code::truncated) << source->name();
    // Offsets and their ends that no file has.
    EXPECT_EQ(code_of(*source, INT64_MAX - 3, 8), Code::truncated) << source->name();
    EXPECT_EQ(code_of(*source, UINT64_MAX - 3, 8), Code::truncated) << source->name();
  }
  sources.clear();
  std::filesystem::remove(path);
}

} // namespace
} // namespace bccsplat
