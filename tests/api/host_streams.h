// SPDX-License-Identifier: Apache-2.0
// Streams of a host over bytes in memory: one that notes what is read of it and may have bytes that are not
// there yet, and one that is written to and may fail. And a series whose file has chunks of some size.
#pragma once

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <mutex>
#include <set>
#include <utility>

#include "support.h"

namespace host {

using Range = std::pair<uint64_t, uint64_t>; // offset, size

// A file far away.
struct FarFile {
  static constexpr uint64_t block = 512; // bytes that arrive together
  explicit FarFile(std::vector<char> file) : bytes(std::move(file)) {}

  std::vector<char> bytes;
  bool blocks = false; // bytes that were not asked for yet are not there, and then on their way
  std::mutex mutex;
  std::set<uint64_t> there;   // blocks
  std::vector<Range> failing; // what cannot be read
  std::vector<Range> reads, refused;

  [[nodiscard]] bccsplat_read_stream stream(uint64_t merge_gap = 0) {
    auto s = sized<bccsplat_read_stream>();
    s.size = bytes.size(), s.read_at = read_at, s.user = this, s.merge_gap = merge_gap;
    return s;
  }
  void fetch(const std::vector<Range>& ranges) {
    for (const auto& [offset, size] : ranges)
      for (uint64_t b = offset / block; b <= (offset + size - 1) / block; ++b) there.insert(b);
  }
  void forget() { reads.clear(), refused.clear(); }

  static int64_t read_at(void* user, uint64_t offset, void* to, uint64_t size) {
    auto& f = *static_cast<FarFile*>(user);
    const std::scoped_lock lock(f.mutex);
    if (offset + size > f.bytes.size()) return -1;
    for (const auto& [begin, count] : f.failing)
      if (offset < begin + count && begin < offset + size) return -1;
    if (f.blocks) {
      const std::set<uint64_t> before = f.there;
      f.fetch({{offset, size}});
      if (f.there.size() > before.size()) {
        f.refused.emplace_back(offset, size);
        std::memset(to, 0x5A, size); // what is there is worth nothing
        return BCCSPLAT_READ_WOULD_BLOCK;
      }
    }
    f.reads.emplace_back(offset, size);
    std::memcpy(to, f.bytes.data() + offset, size);
    return size;
  }
};

[[nodiscard]] inline std::vector<char> file_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Sorted, those that touch or overlap as one.
[[nodiscard]] inline std::vector<Range> merged(std::vector<Range> ranges) {
  std::sort(ranges.begin(), ranges.end());
  std::vector<Range> out;
  for (const auto& [offset, size] : ranges)
    if (!out.empty() && offset <= out.back().first + out.back().second)
      out.back().second = std::max(out.back().second, offset + size - out.back().first);
    else
      out.emplace_back(offset, size);
  return out;
}
[[nodiscard]] inline uint64_t bytes_of(const std::vector<Range>& ranges) {
  uint64_t sum = 0;
  for (const Range& r : merged(ranges)) sum += r.second;
  return sum;
}
// Whether each of some ranges lies in one of others, which are merged.
[[nodiscard]] inline bool covers(const std::vector<Range>& ranges, const std::vector<Range>& some) {
  return std::all_of(some.begin(), some.end(), [&](const Range& s) {
    return std::any_of(ranges.begin(), ranges.end(), [&](const Range& r) {
      return r.first <= s.first && s.first + s.second <= r.first + r.second;
    });
  });
}

// What is written by a host's stream; the call number `fail_at` fails.
struct Sink {
  std::vector<char> bytes{};
  uint64_t calls = 0, fail_at = UINT64_MAX, flushes = 0, fail_flush_at = UINT64_MAX;
  bool part_of_it = false; // the failing call does half its work
  std::function<void()> on_flush{};

  [[nodiscard]] bccsplat_write_stream stream() {
    auto s = sized<bccsplat_write_stream>();
    s.write_at = write_at, s.flush = flush, s.user = this;
    return s;
  }
  static int64_t write_at(void* user, uint64_t offset, const void* from, uint64_t size) {
    auto& s = *static_cast<Sink*>(user);
    if (s.calls++ == s.fail_at) return s.part_of_it ? static_cast<int64_t>(size / 2) : -1;
    s.bytes.resize(std::max<size_t>(s.bytes.size(), offset + size));
    std::memcpy(s.bytes.data() + offset, from, size);
    return size;
  }
  static int32_t flush(void* user) {
    auto& s = *static_cast<Sink*>(user);
    if (s.flushes++ == s.fail_flush_at) return 1;
    if (s.on_flush) s.on_flush();
    return 0;
  }
};

// Noise, which hardly compresses, so that chunks are worth skipping; NaN in a corner where `holes` is set,
// and elsewhere in each frame where `scattered` is.
struct NoiseSeries {
  uint32_t nx = 112, ny = 34, nz = 32, nt = 14;
  bool holes = false, scattered = false;

  [[nodiscard]] bccsplat_writer_options options() const {
    auto o = sized<bccsplat_writer_options>();
    o.dims[0] = nx, o.dims[1] = ny, o.dims[2] = nz, o.dims[3] = nt;
    if (holes || scattered) o.nonfinite = BCCSPLAT_NONFINITE_HOLE;
    return o;
  }
  [[nodiscard]] std::vector<float> frame(uint32_t t) const {
    std::vector<float> values(size_t{nx} * ny * nz);
    uint32_t state = 12345 + t;
    for (float& v : values) {
      state = state * 1664525 + 1013904223;
      v = static_cast<float>(state >> 25);
    }
    if (holes)
      for (size_t i = 0; i < 9; ++i) values[i] = std::numeric_limits<float>::quiet_NaN();
    if (scattered)
      for (float& v : values)
        if (v < 16) v = std::numeric_limits<float>::quiet_NaN();
    return values;
  }
  // All frames that the writer takes.
  void add_to(bccsplat_writer* writer) const {
    uint64_t begin = 0, end = 0;
    ASSERT_OK(bccsplat_writer_get_part_frames(writer, &begin, &end));
    for (uint64_t t = begin; t < end; ++t) {
      const std::vector<float> values = frame(static_cast<uint32_t>(t));
      auto box = sized<bccsplat_box>();
      box.type = BCCSPLAT_TYPE_F32, box.data = values.data();
      box.dims[0] = nx, box.dims[1] = ny, box.dims[2] = nz;
      ASSERT_OK(bccsplat_writer_add_frame(writer, 0, static_cast<double>(t), &box, 1));
    }
  }
  // Values are stored as bytes.
  [[nodiscard]] static bccsplat_channel_options bytes_channel() {
    auto c = sized<bccsplat_channel_options>();
    c.value_type = BCCSPLAT_TYPE_U8, c.set_mask = BCCSPLAT_CHANNEL_SET_RANGE;
    c.range[0] = -64, c.range[1] = 191;
    return c;
  }
};

// The file of a series in a stream.
[[nodiscard]] inline std::vector<char> written(const Device& device, const NoiseSeries& series,
                                               bccsplat_writer_options options) {
  const auto channel = NoiseSeries::bytes_channel();
  if (!options.channels) options.channels = &channel, options.channel_count = 1;
  Sink sink;
  const bccsplat_write_stream stream = sink.stream();
  bccsplat_writer* w = nullptr;
  EXPECT_OK(bccsplat_writer_create_stream(device.get(), &stream, &options, &w));
  const Writer writer(w);
  if (w) series.add_to(w);
  EXPECT_OK(bccsplat_writer_finish(w, nullptr));
  return std::move(sink.bytes);
}

[[nodiscard]] inline bccsplat_hyperplane plane_of(double a, double b, double c, double d, double e) {
  auto h = sized<bccsplat_hyperplane>();
  h.a = a, h.b = b, h.c = c, h.d = d, h.e = e;
  return h;
}

} // namespace host
