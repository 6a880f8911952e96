// SPDX-License-Identifier: Apache-2.0
// Writes a VolumeInfo as records and reads it back, with a check of every count before anything is allocated.
#include "formats/bcc4/metadata.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/bytes.h"
#include "base/sizes.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/page.h"

namespace bccsplat {
namespace {

// Record types rise in a file, and only channel repeats. Readers skip unknown ones from `optional_record` on.
enum RecordType : uint16_t {
  lattice = 1,
  world = 2,
  time_map = 3,
  store = 4,
  channel = 5,
  sources = 6,
  attributes = 7,
  domain = 8,
  levels = 9,
  masks = 10,
  corrections = 11,
  residuals = 0x8002,
  part = 0x8003,
  tail = 0x8004,
  errors = 0x8005,
  counts = 0x8007,
  expected = 0x8008
};
constexpr uint16_t optional_record = 0x8000;

void write_record(ByteWriter& out, RecordType type, const ByteWriter& payload) {
  if (payload.size() > UINT32_MAX)
    fail(Code::limit_exceeded, "metadata: a record of ", payload.size(), " bytes");
  out.write(static_cast<uint16_t>(type));
  out.write(uint16_t{0});
  out.write(static_cast<uint32_t>(payload.size()));
  out.write_bytes(payload.bytes());
  while (out.size() % 8 != 0) out.write(uint8_t{0});
}

void write_range(ByteWriter& out, const Range& r) {
  out.write(r.low);
  out.write(r.high);
}
[[nodiscard]] Range read_range(ByteReader& in) {
  Range r;
  r.low = in.read<double>();
  r.high = in.read<double>();
  return r;
}
[[nodiscard]] std::string read_text(ByteReader& in) { return in.read_string(in.remaining()); }

// Reads a count of elements of at least `each` bytes; fails when the bytes left cannot hold so many.
[[nodiscard]] size_t read_count(ByteReader& in, uint64_t each) {
  const auto count = in.read<uint32_t>();
  if (count > in.remaining() / each)
    fail(Code::corrupt, "metadata: ", count, " elements in ", in.remaining(), " bytes");
  return count;
}

[[nodiscard]] TailInfo read_tail(ByteReader& in, size_t numbers) {
  TailInfo tail;
  tail.slabs = in.read<int32_t>();
  for (size_t i = 0; i < numbers; ++i) tail.clamped.push_back(in.read<uint64_t>());
  return tail;
}

[[nodiscard]] CountsInfo read_counts(ByteReader& in) {
  CountsInfo counts;
  counts.slabs = in.read<int32_t>();
  const auto bytes = in.take(in.read<uint32_t>());
  counts.counts.assign(bytes.begin(), bytes.end());
  return counts;
}

void write_lattice(ByteWriter& out, const VolumeInfo& info) {
  const Lattice4& l = info.lattice;
  out.write(static_cast<uint8_t>(l.kind));
  out.write(static_cast<uint8_t>(info.slab_layers));
  out.write(static_cast<uint8_t>(l.lead));
  out.write(uint8_t{0});
  for (const uint32_t n : l.dims) out.write(n);
  for (const int32_t n : l.space.last) out.write(n);
  out.write(l.last_layer);
  out.write(uint32_t{0});
  for (const double v : l.space_step) out.write(v);
  out.write(l.time_step);
  out.write(info.scale);
  out.write(info.time_scale);
}
void read_lattice(ByteReader& in, VolumeInfo& info) {
  Lattice4& l = info.lattice;
  l.kind = static_cast<LatticeKind>(in.read<uint8_t>());
  l.space.bcc = l.kind != LatticeKind::cc;
  info.slab_layers = in.read<uint8_t>();
  l.lead = in.read<uint8_t>();
  bool zero = in.read<uint8_t>() == 0;
  for (uint32_t& n : l.dims) n = in.read<uint32_t>();
  for (int32_t& n : l.space.last) n = in.read<int32_t>();
  l.last_layer = in.read<int32_t>();
  zero = in.read<uint32_t>() == 0 && zero;
  if (!zero) fail(Code::corrupt, "metadata: reserved bytes of the lattice are not zero");
  for (double& v : l.space_step) v = in.read<double>();
  l.time_step = in.read<double>();
  info.scale = in.read<double>();
  info.time_scale = in.read<double>();
}

constexpr uint64_t level_lattice_bytes = 64, level_channel_bytes = 48;

void write_level(ByteWriter& out, const StoredLattice& level) {
  const Lattice4& l = level.lattice;
  out.write(static_cast<uint8_t>(level.slab_layers));
  for (int i = 0; i < 3; ++i) out.write(uint8_t{0});
  for (const int32_t n :
       {l.before[0], l.before[1], l.before[2], l.lead, l.behind[0], l.behind[1], l.behind[2]})
    out.write(static_cast<uint8_t>(n));
  out.write(uint8_t{0});
  for (const int32_t n : l.space.last) out.write(n);
  out.write(l.last_layer);
  out.write(uint32_t{0});
  for (const double v : l.space_step) out.write(v);
  out.write(l.time_step);
}
// base: the lattice of record 1, with which it shares its kind, the source samples and the ends of axes.
[[nodiscard]] LevelInfo read_level(ByteReader& in, const Lattice4& base) {
  LevelInfo level;
  Lattice4& l = level.lattice;
  l.kind = base.kind, l.dims = base.dims, l.space.bcc = base.space.bcc;
  l.periodic = base.periodic, l.space.periodic = base.space.periodic;
  level.slab_layers = in.read<uint8_t>();
  bool zero = true;
  for (int i = 0; i < 3; ++i) zero = in.read<uint8_t>() == 0 && zero;
  for (int32_t* n :
       {&l.before[0], &l.before[1], &l.before[2], &l.lead, &l.behind[0], &l.behind[1], &l.behind[2]})
    *n = in.read<uint8_t>();
  zero = in.read<uint8_t>() == 0 && zero;
  for (int32_t& n : l.space.last) n = in.read<int32_t>();
  l.last_layer = in.read<int32_t>();
  zero = in.read<uint32_t>() == 0 && zero;
  if (!zero) fail(Code::corrupt, "metadata: reserved bytes of a level are not zero");
  for (double& v : l.space_step) v = in.read<double>();
  l.time_step = in.read<double>();
  return level;
}

void write_levels(ByteWriter& out, const std::vector<LevelInfo>& list) {
  out.write(static_cast<uint32_t>(list.size()));
  for (const LevelInfo& level : list) write_level(out, level);
  for (const LevelInfo& level : list)
    for (const LevelChannel& c : level.channels) {
      out.write(c.scale);
      for (const uint64_t n : {c.sites_kept, c.holes, c.clamped}) out.write(n);
      write_range(out, c.kept_range);
    }
}
void read_levels(ByteReader& in, VolumeInfo& info) {
  const auto count = in.read<uint32_t>();
  const uint64_t each = level_lattice_bytes + info.channels.size() * level_channel_bytes;
  if (count == 0 || count > most_levels || in.remaining() != count * each)
    fail(Code::corrupt, "metadata: ", count, " levels in ", in.remaining(), " bytes");
  for (uint32_t l = 0; l < count; ++l) info.levels.push_back(read_level(in, info.lattice));
  for (LevelInfo& level : info.levels) {
    level.channels.resize(info.channels.size());
    for (LevelChannel& c : level.channels) {
      c.scale = in.read<double>();
      for (uint64_t* n : {&c.sites_kept, &c.holes, &c.clamped}) *n = in.read<uint64_t>();
      c.kept_range = read_range(in);
    }
  }
}

// How the field goes on beyond the outermost planes of an axis, of record 8.
enum End : uint8_t { mirror, odd, periodic, stencils };

void write_domain(ByteWriter& out, const VolumeInfo& info) {
  const Lattice4& l = info.lattice;
  for (size_t end = 0; end < 8; ++end) out.write(static_cast<uint8_t>(l.turns(end % 4) ? periodic : mirror));
  for (const int32_t n : l.before) out.write(static_cast<uint8_t>(n));
  out.write(static_cast<uint8_t>(l.lead));
  for (const int32_t n : l.behind) out.write(static_cast<uint8_t>(n));
  out.write(uint8_t{0});
  const LatticeScales scales = l.scales();
  for (size_t a = 0; a < 3; ++a) out.write(scales[a]);
  out.write(info.time_scale);
}
void read_domain(ByteReader& in, Lattice4& l) {
  std::array<uint8_t, 8> kinds;
  for (size_t end = 0; end < kinds.size(); ++end) {
    const auto kind = kinds[end] = in.read<uint8_t>();
    if (kind > stencils) fail(Code::corrupt, "metadata: end of kind ", static_cast<int>(kind));
    constexpr std::array<const char*, 4> names{"mirror", "odd", "periodic", "stencils"};
    if (kind != mirror && kind != periodic)
      fail(Code::unsupported_version, "metadata: axis ", "xyzt"[end % 4], " has ends of kind '", names[kind],
           "', which this version cannot draw; update bccsplat");
  }
  for (size_t a = 0; a < 4; ++a) {
    if (kinds[a] != kinds[a + 4])
      fail(Code::corrupt, "metadata: one end of axis ", "xyzt"[a], " is periodic, the other is not");
    (a == 3 ? l.periodic : l.space.periodic[a]) = kinds[a] == periodic;
  }
  for (int32_t& n : l.before) n = in.read<uint8_t>();
  bool right = in.read<uint8_t>() == l.lead;
  for (int32_t& n : l.behind) n = in.read<uint8_t>();
  right = in.read<uint8_t>() == 0 && right;
  for (size_t a = 0; a < 4; ++a) {
    const auto scale = in.read<double>();
    right = right && scale > 0 && std::isfinite(scale);
  }
  if (!right) fail(Code::corrupt, "metadata: layers before frame 0, reserved bytes or scales of the domain");
}

void write_time(ByteWriter& out, const TimeMap& t) {
  out.write(t.first);
  out.write(t.step);
  out.write_string(t.unit);
  out.write_string(t.epoch);
  out.write(static_cast<uint32_t>(t.times.size()));
  for (const double v : t.times) out.write(v);
}
void read_time(ByteReader& in, TimeMap& t) {
  t.first = in.read<double>();
  t.step = in.read<double>();
  t.unit = read_text(in);
  t.epoch = read_text(in);
  t.times.resize(read_count(in, 8));
  for (double& v : t.times) v = in.read<double>();
  t.uniform = t.times.empty();
}

void write_channel(ByteWriter& out, const ChannelInfo& c) {
  out.write(static_cast<uint8_t>(c.type));
  out.write(static_cast<uint8_t>(c.source_type));
  out.write(uint16_t{0});
  out.write(SampleCoder(c).codes().air);
  out.write(c.scale);
  out.write(c.offset);
  out.write(c.air);
  out.write(c.threshold);
  for (const uint64_t n : {c.sites_kept, c.holes, c.clamped, c.cc_relevant}) out.write(n);
  write_range(out, c.source_range);
  write_range(out, c.kept_range);
  write_range(out, c.histogram_range);
  out.write_string(c.name);
  out.write_string(c.quantity);
  out.write_string(c.unit);
  out.write(static_cast<uint32_t>(c.histogram.size()));
  for (const uint64_t n : c.histogram) out.write(n);
  out.write(static_cast<uint32_t>(c.percentiles.size()));
  for (const Percentile& p : c.percentiles) {
    out.write(p.percent);
    out.write(p.value);
  }
  out.write(static_cast<uint32_t>(c.frames.size()));
  for (const Range& r : c.frames) write_range(out, r);
}
// Returns the code of air, which can be checked once the rest is known to be sound.
[[nodiscard]] uint32_t read_channel(ByteReader& in, ChannelInfo& c) {
  c.type = static_cast<ValueType>(in.read<uint8_t>());
  c.source_type = static_cast<SourceType>(in.read<uint8_t>());
  if (in.read<uint16_t>() != 0) fail(Code::corrupt, "metadata: reserved bytes of a channel are not zero");
  const auto air_code = in.read<uint32_t>();
  c.scale = in.read<double>();
  c.offset = in.read<double>();
  c.air = in.read<float>();
  c.threshold = in.read<float>();
  for (uint64_t* n : {&c.sites_kept, &c.holes, &c.clamped, &c.cc_relevant}) *n = in.read<uint64_t>();
  c.source_range = read_range(in);
  c.kept_range = read_range(in);
  c.histogram_range = read_range(in);
  c.name = read_text(in);
  c.quantity = read_text(in);
  c.unit = read_text(in);
  c.histogram.resize(read_count(in, 8));
  for (uint64_t& n : c.histogram) n = in.read<uint64_t>();
  c.percentiles.resize(read_count(in, 16));
  for (Percentile& p : c.percentiles) {
    p.percent = in.read<double>();
    p.value = in.read<double>();
  }
  c.frames.resize(read_count(in, 16));
  for (Range& r : c.frames) r = read_range(in);
  return air_code;
}

void write_blocks(ByteWriter& out, const std::vector<BlockRef>& blocks) {
  out.write(static_cast<uint32_t>(blocks.size()));
  for (const BlockRef& ref : blocks) write_block_ref(out, ref);
}
void read_blocks(ByteReader& in, std::vector<BlockRef>& blocks) {
  blocks.resize(read_count(in, block_ref_bytes));
  for (BlockRef& ref : blocks) ref = read_block_ref(in);
}

void write_residual_info(ByteWriter& out, const ResidualInfo& r) {
  out.write(r.step);
  out.write(r.bound);
  write_blocks(out, r.frames);
}
void read_residual_info(ByteReader& in, ResidualInfo& r) {
  const auto step = in.read<double>(), bound = in.read<double>();
  if (r.local && (step != r.step || bound != r.bound))
    fail(Code::corrupt, "metadata: two records of corrections differ in step or bound");
  r.step = step, r.bound = bound;
  read_blocks(in, r.frames);
}

void write_correction_info(ByteWriter& out, const ResidualInfo& r) {
  out.write(r.step);
  out.write(r.bound);
  out.write(static_cast<uint8_t>(r.shape));
  out.write(static_cast<uint8_t>(r.base.has_value()));
  out.write(uint16_t{0});
  out.write(r.base.value_or(0));
  write_blocks(out, r.tables);
}
void read_correction_info(ByteReader& in, ResidualInfo& r) {
  r.local = true;
  r.step = in.read<double>();
  r.bound = in.read<double>();
  r.shape = static_cast<CorrectionShape>(in.read<uint8_t>());
  const auto has_base = in.read<uint8_t>();
  const auto reserved = in.read<uint16_t>();
  const auto base = in.read<float>();
  if (has_base > 1 || reserved != 0 || (has_base == 0 && std::bit_cast<uint32_t>(base) != 0))
    fail(Code::corrupt, "metadata: reserved bytes of corrections are not zero");
  if (has_base == 1) r.base = base;
  read_blocks(in, r.tables);
}

constexpr uint64_t measured_error_bytes = 48;

void write_errors(ByteWriter& out, const std::vector<MeasuredError>& list) {
  out.write(static_cast<uint32_t>(list.size()));
  for (const MeasuredError& e : list) {
    for (const uint32_t n : {e.channel, e.level, e.kind, e.frames}) out.write(n);
    out.write(e.samples);
    for (const double v : {e.rmse, e.largest, e.range}) out.write(v);
  }
}
void read_errors(ByteReader& in, std::vector<MeasuredError>& list) {
  list.resize(read_count(in, measured_error_bytes));
  for (MeasuredError& e : list) {
    for (uint32_t* n : {&e.channel, &e.level, &e.kind, &e.frames}) *n = in.read<uint32_t>();
    e.samples = in.read<uint64_t>();
    for (double* v : {&e.rmse, &e.largest, &e.range}) *v = in.read<double>();
  }
}

[[nodiscard]] bool any_local(const VolumeInfo& info) {
  return std::any_of(info.channels.begin(), info.channels.end(),
                     [](const ChannelInfo& c) { return c.residuals.local; });
}

[[nodiscard]] bool any_masks(const VolumeInfo& info) {
  return std::any_of(info.channels.begin(), info.channels.end(),
                     [](const ChannelInfo& c) { return !c.masks.empty(); });
}

// Whether the record of whole frames says anything that record 11 does not.
[[nodiscard]] bool has_residual_record(const VolumeInfo& info) {
  const bool local = any_local(info);
  return std::any_of(info.channels.begin(), info.channels.end(), [&](const ChannelInfo& c) {
    return local ? !c.residuals.frames.empty() : c.residuals != ResidualInfo{};
  });
}

} // namespace

uint16_t lowest_reader(const VolumeInfo& info) {
  if (!info.levels.empty() || info.lattice.has_domain() || any_masks(info) || any_local(info) ||
      !info.errors.empty())
    return 3;
  for (const ChannelInfo& c : info.channels)
    if (c.type == ValueType::i32) return 3;
  return info.lattice.lead > 0 ? 2 : 1;
}

std::vector<std::byte> write_metadata(const VolumeInfo& info) {
  ByteWriter out;
  const auto record = [&out](RecordType type, const auto& fill) {
    ByteWriter payload;
    fill(payload);
    write_record(out, type, payload);
  };
  record(lattice, [&](ByteWriter& p) { write_lattice(p, info); });
  record(world, [&](ByteWriter& p) {
    for (size_t r = 0; r < 3; ++r) {
      for (const double v : info.affine.linear[r]) p.write(v);
      p.write(info.affine.offset[r]);
    }
    p.write_string(info.spatial_unit);
  });
  record(time_map, [&](ByteWriter& p) { write_time(p, info.time); });
  record(store, [&](ByteWriter& p) {
    p.write_string(info.coefficient_kernel);
    p.write_string(info.recommended_kernel);
    p.write(static_cast<uint32_t>(info.coefficient_parameters.size()));
    for (const double v : info.coefficient_parameters) p.write(v);
  });
  for (const ChannelInfo& c : info.channels) record(channel, [&](ByteWriter& p) { write_channel(p, c); });
  record(sources, [&](ByteWriter& p) {
    p.write(static_cast<uint32_t>(info.sources.size()));
    for (const SourceInfo& s : info.sources) {
      p.write_string(s.name);
      p.write(s.bytes);
      p.write(s.crc32);
    }
  });
  record(attributes, [&](ByteWriter& p) {
    p.write(static_cast<uint32_t>(info.attributes.size()));
    for (const auto& [key, value] : info.attributes) {
      p.write_string(key);
      p.write_string(value);
    }
  });
  if (info.lattice.has_domain()) record(domain, [&](ByteWriter& p) { write_domain(p, info); });
  if (!info.levels.empty()) record(levels, [&](ByteWriter& p) { write_levels(p, info.levels); });
  if (any_masks(info))
    record(masks, [&](ByteWriter& p) {
      for (const ChannelInfo& c : info.channels) write_blocks(p, c.masks);
    });
  if (any_local(info))
    record(corrections, [&](ByteWriter& p) {
      for (const ChannelInfo& c : info.channels) write_correction_info(p, c.residuals);
    });
  if (has_residual_record(info))
    record(residuals, [&](ByteWriter& p) {
      for (const ChannelInfo& c : info.channels) write_residual_info(p, c.residuals);
    });
  if (info.part) record(part, [&](ByteWriter& p) { write_part(p, *info.part); });
  if (info.tail)
    record(tail, [&](ByteWriter& p) {
      p.write(info.tail->slabs);
      for (const uint64_t n : info.tail->clamped) p.write(n);
    });
  if (!info.errors.empty()) record(errors, [&](ByteWriter& p) { write_errors(p, info.errors); });
  if (info.counts)
    record(counts, [&](ByteWriter& p) {
      p.write(info.counts->slabs);
      p.write(static_cast<uint32_t>(info.counts->counts.size()));
      p.write_bytes(info.counts->counts);
    });
  if (info.expected_frames > 0) record(expected, [&](ByteWriter& p) { p.write(info.expected_frames); });
  return out.release();
}

VolumeInfo read_metadata(std::span<const std::byte> decoded, uint64_t offset, const Bcc4Limits& limits) {
  ByteReader in(decoded, "metadata", offset);
  VolumeInfo info;
  std::vector<uint32_t> air_codes;
  uint16_t last = 0;
  unsigned seen = 0;
  while (in.remaining() > 0) {
    const auto type = in.read<uint16_t>();
    const auto reserved = in.read<uint16_t>();
    const auto length = in.read<uint32_t>();
    ByteReader record(in.take(length), "metadata record", offset + in.position() - length);
    for (const std::byte b : in.take((8 - in.position() % 8) % 8))
      if (b != std::byte{0})
        fail(Code::corrupt, "metadata at offset ", offset, ": padding of record ", type, " is not zero");
    if (reserved != 0)
      fail(Code::corrupt, "metadata at offset ", offset, ": reserved bytes of record ", type);
    if (type < last || (type == last && type != channel))
      fail(Code::corrupt, "metadata at offset ", offset, ": record ", type, " after record ", last);
    last = type;
    switch (type) {
    case lattice:
      read_lattice(record, info);
      break;
    case world:
      for (size_t r = 0; r < 3; ++r) {
        for (double& v : info.affine.linear[r]) v = record.read<double>();
        info.affine.offset[r] = record.read<double>();
      }
      info.spatial_unit = read_text(record);
      break;
    case time_map:
      read_time(record, info.time);
      break;
    case store:
      info.coefficient_kernel = read_text(record);
      info.recommended_kernel = read_text(record);
      info.coefficient_parameters.resize(read_count(record, 8));
      for (double& v : info.coefficient_parameters) v = record.read<double>();
      break;
    case channel:
      if (info.channels.size() == limits.channels)
        fail(Code::limit_exceeded, "metadata: more than ", limits.channels, " channels");
      air_codes.push_back(read_channel(record, info.channels.emplace_back()));
      break;
    case sources:
      info.sources.resize(read_count(record, 16));
      for (SourceInfo& s : info.sources) {
        s.name = read_text(record);
        s.bytes = record.read<uint64_t>();
        s.crc32 = record.read<uint32_t>();
      }
      break;
    case attributes:
      info.attributes.resize(read_count(record, 8));
      for (auto& [key, value] : info.attributes) {
        key = read_text(record);
        value = read_text(record);
      }
      break;
    case domain:
      read_domain(record, info.lattice);
      record.expect_end();
      continue;
    case levels:
      read_levels(record, info);
      record.expect_end();
      continue;
    case masks:
      for (ChannelInfo& c : info.channels) read_blocks(record, c.masks);
      record.expect_end();
      continue;
    case corrections:
      for (ChannelInfo& c : info.channels) read_correction_info(record, c.residuals);
      record.expect_end();
      continue;
    case errors:
      read_errors(record, info.errors);
      record.expect_end();
      continue;
    case tail:
      info.tail = read_tail(record, info.channels.size() * (info.levels.size() + 1));
      record.expect_end();
      continue;
    case counts:
      info.counts = read_counts(record);
      record.expect_end();
      continue;
    case expected:
      info.expected_frames = record.read<uint32_t>();
      record.expect_end();
      continue;
    case residuals:
      for (ChannelInfo& c : info.channels) read_residual_info(record, c.residuals);
      record.expect_end();
      continue;
    case part:
      info.part = read_part(record, info.lattice.dims[3], info.channels.size(), info.level_count());
      record.expect_end();
      continue;
    default:
      if (type < optional_record)
        fail(Code::unsupported_version, "metadata at offset ", offset, ": unknown record ", type,
             "; update bccsplat");
      continue;
    }
    record.expect_end();
    seen |= 1u << type;
  }
  if (seen != 0xfe) fail(Code::corrupt, "metadata at offset ", offset, ": a record is missing");
  check_info(info, Code::corrupt);
  for (size_t c = 0; c < air_codes.size(); ++c)
    if (SampleCoder(info.channels[c]).codes().air != air_codes[c])
      fail(Code::corrupt, "channel ", info.channels[c].name, ": code of air ", air_codes[c]);
  for (int l = 0; l < info.level_count(); ++l)
    if (const uint64_t bricks = slot_count(info.level(l).lattice); bricks > limits.bricks_per_layer)
      fail(Code::limit_exceeded, "a layer of ", bricks, " bricks, the limit is ", limits.bricks_per_layer);
  return info;
}

} // namespace bccsplat
