// SPDX-License-Identifier: Apache-2.0
// Writes a VolumeInfo as records and reads it back, with a check of every count before anything is allocated.
// The larger records are in metadata_lattice.cpp and metadata_channel.cpp.
#include "formats/bcc4/metadata.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "base/bytes.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/metadata_records.h"
#include "formats/bcc4/page.h"

namespace bccsplat {
namespace {

// Record types rise in a file, and only channel repeats. Readers skip unknown ones from `optional_record` on.
enum RecordType : uint16_t {
  lattice = 1,
  world = 2,
  time_map = 3,
  kernel = 4,
  channel = 5,
  sources = 6,
  attributes = 7,
  domain = 8,
  levels = 9,
  masks = 10,
  corrections = 11,
  tiles = 13,
  residuals = 0x8002,
  part = 0x8003,
  block = 0x800a,
  sums = 0x800b,
  tail = 0x8004,
  errors = 0x8005,
  counts = 0x8007,
  expected = 0x8008,
  coordinates = 0x8009
};
constexpr uint16_t optional_record = 0x8000;
constexpr int tiles_reserved = 7; // bytes of the record

void write_record(ByteWriter& out, RecordType type, const ByteWriter& payload) {
  if (payload.size() > UINT32_MAX)
    fail(Code::limit_exceeded, "metadata: a record of ", payload.size(), " bytes");
  out.write(static_cast<uint16_t>(type));
  out.write(uint16_t{0});
  out.write(static_cast<uint32_t>(payload.size()));
  out.write_bytes(payload.bytes());
  while (out.size() % 8 != 0) out.write(uint8_t{0});
}

void write_sources(ByteWriter& out, const std::vector<SourceInfo>& list) {
  out.write(static_cast<uint32_t>(list.size()));
  for (const SourceInfo& s : list) {
    out.write_string(s.name);
    out.write(s.bytes);
    out.write(s.crc32);
  }
}
void read_sources(ByteReader& in, std::vector<SourceInfo>& list) {
  list.resize(read_count(in, "sources", 16));
  for (SourceInfo& s : list) {
    s.name = read_text(in);
    s.bytes = in.read<uint64_t>();
    s.crc32 = in.read<uint32_t>();
  }
}

void write_attributes(ByteWriter& out, const VolumeInfo& info) {
  out.write(static_cast<uint32_t>(info.attributes.size()));
  for (const auto& [key, value] : info.attributes) {
    out.write_string(key);
    out.write_string(value);
  }
}
void read_attributes(ByteReader& in, VolumeInfo& info) {
  const size_t count = read_count(in, "attributes", 9);
  // Keys that are not unique end it: many short ones take much more than the bytes that they are deflated to.
  std::unordered_set<std::string> keys;
  for (size_t i = 0; i < count; ++i) {
    auto& [key, value] = info.attributes.emplace_back(read_text(in), std::string());
    value = read_text(in);
    if (key.empty() || !keys.insert(key).second)
      fail(Code::corrupt, "attribute key \"", key, "\" is empty or stands twice");
  }
}

void write_tail(ByteWriter& out, const TailInfo& tail) {
  out.write(tail.slabs);
  for (const uint64_t n : tail.clamped) out.write(n);
}
[[nodiscard]] TailInfo read_tail(ByteReader& in, size_t numbers) {
  TailInfo tail;
  tail.slabs = in.read<int32_t>();
  for (size_t i = 0; i < numbers; ++i) tail.clamped.push_back(in.read<uint64_t>());
  return tail;
}

void write_counts(ByteWriter& out, const CountsInfo& counts) {
  out.write(counts.slabs);
  out.write(static_cast<uint32_t>(counts.counts.size()));
  out.write_bytes(counts.counts);
}
[[nodiscard]] CountsInfo read_counts(ByteReader& in) {
  CountsInfo counts;
  counts.slabs = in.read<int32_t>();
  const auto bytes = in.take(in.read<uint32_t>());
  counts.counts.assign(bytes.begin(), bytes.end());
  return counts;
}

[[nodiscard]] bool any_local(const VolumeInfo& info) {
  return std::any_of(info.channels.begin(), info.channels.end(),
                     [](const ChannelInfo& c) { return c.residuals.local; });
}

[[nodiscard]] bool any_masks(const VolumeInfo& info) {
  return std::any_of(info.channels.begin(), info.channels.end(),
                     [](const ChannelInfo& c) { return !c.masks.empty(); });
}

// Returns whether the record of whole frames says anything that record 11 does not.
[[nodiscard]] bool has_residual_record(const VolumeInfo& info) {
  const bool local = any_local(info);
  return std::any_of(info.channels.begin(), info.channels.end(), [&](const ChannelInfo& c) {
    return local ? !c.residuals.frames.empty() : c.residuals != ResidualInfo{};
  });
}

void write_tiles(ByteWriter& out, const VolumeInfo& info) {
  out.write(static_cast<uint8_t>(info.tile_edge));
  for (int i = 0; i < tiles_reserved; ++i) out.write(uint8_t{0});
  for (const ChannelInfo& c : info.channels) out.write(c.wavelet_error);
}
void read_tiles(ByteReader& in, VolumeInfo& info) {
  info.tile_edge = in.read<uint8_t>();
  for (int i = 0; i < tiles_reserved; ++i)
    if (in.read<uint8_t>() != 0) fail(Code::corrupt, "metadata: reserved bytes of tiles are not zero");
  for (LevelInfo& level : info.levels) level.tile_edge = info.tile_edge;
  for (ChannelInfo& c : info.channels) c.wavelet_error = in.read<double>();
}

// Reads records, in the order of their types.
class MetadataReader {
 public:
  MetadataReader(uint64_t offset, const Bcc4Limits& limits) : offset_(offset), limits_(limits) {}

  [[nodiscard]] VolumeInfo read(std::span<const std::byte> decoded) {
    ByteReader in(decoded, "metadata", offset_);
    uint16_t last = 0;
    while (in.remaining() > 0) last = read_record(in, last);
    constexpr unsigned needed = 0xfe; // types 1 to 7
    if ((seen_ & needed) != needed)
      fail(Code::corrupt, "metadata at offset ", offset_, ": a record is missing");
    check();
    return std::move(info_);
  }

 private:
  const uint64_t offset_; // for error texts
  const Bcc4Limits& limits_;
  VolumeInfo info_;
  std::vector<uint32_t> air_codes_; // of the channels
  unsigned seen_ = 0;               // a bit for each type below 16

  uint16_t read_record(ByteReader& in, uint16_t last) {
    const auto type = in.read<uint16_t>();
    const auto reserved = in.read<uint16_t>();
    const auto length = in.read<uint32_t>();
    ByteReader record(in.take(length), "metadata record", offset_ + in.position() - length);
    for (const std::byte b : in.take((8 - in.position() % 8) % 8))
      if (b != std::byte{0})
        fail(Code::corrupt, "metadata at offset ", offset_, ": padding of record ", type, " is not zero");
    if (reserved != 0)
      fail(Code::corrupt, "metadata at offset ", offset_, ": reserved bytes of record ", type);
    if (type < last || (type == last && type != channel))
      fail(Code::corrupt, "metadata at offset ", offset_, ": record ", type, " after record ", last);
    if (!read_needed(type, record) && !read_other(type, record)) {
      if (type < optional_record)
        fail(Code::unsupported_version, "metadata at offset ", offset_, ": unknown record ", type,
             "; update bccsplat");
      return type; // whatever is in it
    }
    record.expect_end();
    if (type < 16) seen_ |= 1u << type;
    return type;
  }

  [[nodiscard]] uint32_t frames() const { return info_.lattice.dims[3]; } // record 1 comes first

  // Records that every file has. False: it is none of them.
  bool read_needed(uint16_t type, ByteReader& record) {
    switch (type) {
    case lattice:
      return read_lattice(record, info_), true;
    case world:
      return read_world(record, info_), true;
    case time_map:
      return read_time(record, info_), true;
    case kernel:
      return info_.recommended_kernel = read_text(record), true;
    case channel:
      if (info_.channels.size() == limits_.channels)
        fail(Code::limit_exceeded, "metadata: more than ", limits_.channels, " channels");
      air_codes_.push_back(read_channel(record, info_.channels.emplace_back(), frames()));
      // At once: what is said of a channel further on may mean nothing of values that are not known.
      return check_channel(info_.channels.back(), Code::corrupt), true;
    case sources:
      return read_sources(record, info_.sources), true;
    case attributes:
      return read_attributes(record, info_), true;
    default:
      return false;
    }
  }

  bool read_other(uint16_t type, ByteReader& record) {
    switch (type) {
    case domain:
      return read_domain(record, info_.lattice), true;
    case levels:
      return read_levels(record, info_), true;
    case masks:
      for (ChannelInfo& c : info_.channels) read_blocks(record, c.masks, frames());
      return true;
    case corrections:
      for (ChannelInfo& c : info_.channels) read_correction_info(record, c.residuals, frames());
      return true;
    case tiles:
      return read_tiles(record, info_), true;
    case residuals:
      for (ChannelInfo& c : info_.channels) read_residual_info(record, c.residuals, frames());
      return true;
    case part:
      info_.part = read_part(record, info_.lattice.dims[3], info_.channels.size(), info_.level_count());
      return true;
    case block:
      info_.part = read_block(record, info_.lattice.dims, info_.channels.size(), info_.level_count());
      return true;
    case tail:
      info_.tail = read_tail(record, info_.channels.size() * (info_.levels.size() + 1));
      return true;
    case errors:
      return read_errors(record, info_), true;
    case counts:
      info_.counts = read_counts(record);
      return true;
    case expected:
      info_.expected_frames = record.read<uint32_t>();
      return true;
    case coordinates:
      read_axes(record, info_);
      if (!info_.has_uneven_axes()) fail(Code::corrupt, "metadata: coordinates of no axis");
      return true;
    case sums:
      for (ChannelInfo& c : info_.channels) c.sums = read_sums(record);
      return true;
    default:
      return false;
    }
  }

  void check() const {
    check_info(info_, Code::corrupt);
    for (size_t c = 0; c < air_codes_.size(); ++c)
      if (SampleCoder(info_.channels[c]).codes().air != air_codes_[c])
        fail(Code::corrupt, "channel ", info_.channels[c].name, ": code of air ", air_codes_[c]);
    for (int l = 0; l < info_.level_count(); ++l) {
      const Lattice4& lattice = info_.level(l).lattice;
      for (const int32_t planes :
           {lattice.space.last[0], lattice.space.last[1], lattice.space.last[2], lattice.last_layer})
        if (planes >= limits_.planes)
          fail(Code::limit_exceeded, "a lattice of ", int64_t{planes} + 1,
               " planes or layers along an axis, the limit is ", limits_.planes);
      if (const uint64_t bricks = brick_count(lattice); bricks > limits_.bricks_per_layer)
        fail(Code::limit_exceeded, "a layer of ", bricks, " bricks, the limit is ", limits_.bricks_per_layer);
    }
  }
};

} // namespace

std::vector<std::byte> write_metadata(const VolumeInfo& info) {
  ByteWriter out;
  const auto record = [&out](RecordType type, const auto& fill) {
    ByteWriter payload;
    fill(payload);
    write_record(out, type, payload);
  };
  record(lattice, [&](ByteWriter& p) { write_lattice(p, info); });
  record(world, [&](ByteWriter& p) { write_world(p, info); });
  record(time_map, [&](ByteWriter& p) { write_time(p, info.time); });
  record(kernel, [&](ByteWriter& p) { p.write_string(info.recommended_kernel); });
  for (const ChannelInfo& c : info.channels) record(channel, [&](ByteWriter& p) { write_channel(p, c); });
  record(sources, [&](ByteWriter& p) { write_sources(p, info.sources); });
  record(attributes, [&](ByteWriter& p) { write_attributes(p, info); });
  if (info.lattice.has_domain()) record(domain, [&](ByteWriter& p) { write_domain(p, info); });
  if (!info.levels.empty()) record(levels, [&](ByteWriter& p) { write_levels(p, info); });
  if (any_masks(info))
    record(masks, [&](ByteWriter& p) {
      for (const ChannelInfo& c : info.channels) write_blocks(p, c.masks);
    });
  if (any_local(info))
    record(corrections, [&](ByteWriter& p) {
      for (const ChannelInfo& c : info.channels) write_correction_info(p, c.residuals);
    });
  if (info.tile_edge > 1) record(tiles, [&](ByteWriter& p) { write_tiles(p, info); });
  if (has_residual_record(info))
    record(residuals, [&](ByteWriter& p) {
      for (const ChannelInfo& c : info.channels) write_residual_info(p, c.residuals);
    });
  if (info.part && info.part->block.all_space())
    record(part, [&](ByteWriter& p) { write_part(p, *info.part); });
  if (info.tail) record(tail, [&](ByteWriter& p) { write_tail(p, *info.tail); });
  if (!info.errors.empty()) record(errors, [&](ByteWriter& p) { write_errors(p, info.errors); });
  if (info.counts) record(counts, [&](ByteWriter& p) { write_counts(p, *info.counts); });
  if (info.expected_frames > 0) record(expected, [&](ByteWriter& p) { p.write(info.expected_frames); });
  if (info.has_uneven_axes()) record(coordinates, [&](ByteWriter& p) { write_axes(p, info.axes); });
  if (info.part && !info.part->block.all_space())
    record(block, [&](ByteWriter& p) { write_block(p, *info.part); });
  if (!info.channels.empty() && info.channels.front().sums)
    record(sums, [&](ByteWriter& p) {
      for (const ChannelInfo& c : info.channels) write_sums(p, c.sums.value_or(FrameSums{}));
    });
  return out.release();
}

VolumeInfo read_metadata(std::span<const std::byte> decoded, uint64_t offset, const Bcc4Limits& limits) {
  return MetadataReader(offset, limits).read(decoded);
}

} // namespace bccsplat
