// SPDX-License-Identifier: Apache-2.0
#include "tool/import/sources.h"

#include <zlib.h>

#include <algorithm>
#include <filesystem>

#include "readers/byte_stream.h"
#include "readers/system.h"
#include "tool/interrupt.h"

namespace bcc4 {
namespace {

constexpr uint64_t kHashedBytes = uint64_t{1} << 32; // sources in all up to this size get a CRC-32

uint32_t file_crc(const std::string& path) {
  InputFile file(path);
  Bytes chunk(1 << 20);
  uLong crc = crc32(0, nullptr, 0);
  for (uint64_t at = 0; at < file.size();) {
    stop_if_interrupted();
    const size_t got = file.read_some(at, chunk);
    if (got == 0) break;
    crc = crc32(crc, reinterpret_cast<const Bytef*>(chunk.data()), static_cast<uInt>(got));
    at += got;
  }
  return static_cast<uint32_t>(crc);
}

} // namespace

std::vector<PlannedSource> sources_of(const SeriesDescription& s, std::span<const PlannedSource> known) {
  uint64_t total = 0;
  for (const SourceFile& f : s.files) total += f.bytes;
  std::vector<PlannedSource> sources;
  for (const SourceFile& f : s.files) {
    PlannedSource source{to_text(to_path(f.path).filename()), f.bytes, 0};
    const auto same = std::find_if(known.begin(), known.end(), [&](const PlannedSource& k) {
      return k.name == source.name && k.bytes == source.bytes && k.crc32 != 0;
    });
    if (total <= kHashedBytes) source.crc32 = same != known.end() ? same->crc32 : file_crc(f.path);
    sources.push_back(std::move(source));
  }
  return sources;
}

} // namespace bcc4
