// SPDX-License-Identifier: Apache-2.0
// The streams of a host as the core's sources and sinks.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "api/numbers.h"
#include "api/structs.h"
#include "base/files.h"

namespace bccsplat::api {

static_assert(read_would_block == BCCSPLAT_READ_WOULD_BLOCK);

// name: for error texts.
[[nodiscard]] inline std::unique_ptr<ByteSource> source_of(const bccsplat_read_stream* stream,
                                                           std::string name) {
  const auto s = read_struct(stream, "bccsplat_read_stream");
  require_zero(s.reserved, "bccsplat_read_stream.reserved");
  if (s.size > INT64_MAX)
    fail(Code::invalid_argument, "bccsplat_read_stream.size is ", s.size, ", not in 0 .. ", INT64_MAX);
  if (!s.read_at) fail(Code::invalid_argument, "bccsplat_read_stream.read_at is NULL");
  return open_stream_source(
      s.size,
      [s](uint64_t offset, std::span<std::byte> out) {
        return s.read_at(s.user, offset, out.data(), out.size());
      },
      s.merge_gap != 0 ? s.merge_gap : usual_merge_gap, std::move(name));
}

[[nodiscard]] inline std::unique_ptr<ByteSink> sink_of(const bccsplat_write_stream* stream) {
  require(stream, "stream");
  const auto s = read_struct(stream, "bccsplat_write_stream");
  require_zero(s.reserved, "bccsplat_write_stream.reserved");
  if (!s.write_at) fail(Code::invalid_argument, "bccsplat_write_stream.write_at is NULL");
  Flush flush;
  if (s.flush) flush = [s] { return s.flush(s.user) == 0; };
  return create_stream_sink(
      [s](uint64_t offset, std::span<const std::byte> bytes) {
        return s.write_at(s.user, offset, bytes.data(), bytes.size());
      },
      std::move(flush));
}

} // namespace bccsplat::api
