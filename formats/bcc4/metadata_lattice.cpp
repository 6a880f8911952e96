// SPDX-License-Identifier: Apache-2.0
// Writes and reads the records of where a field is: the lattice, its coarser levels, what lies beyond its
// faces, its place in the world and its times.
#include <array>
#include <cmath>

#include "formats/bcc4/metadata_records.h"

namespace bccsplat {
namespace {

constexpr uint32_t counts_down = 1; // flag of an axis
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

// How the field goes on beyond the outermost planes of an axis, of record 8.
enum End : uint8_t { mirror, odd, periodic, stencils };

} // namespace

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

void write_levels(ByteWriter& out, const VolumeInfo& info) {
  out.write(static_cast<uint32_t>(info.levels.size()));
  for (const LevelInfo& level : info.levels) write_level(out, level);
  for (const LevelInfo& level : info.levels)
    for (size_t i = 0; i < level.channels.size(); ++i) {
      const LevelChannel& c = level.channels[i];
      out.write(info.channels.at(i).scale);
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
    for (size_t i = 0; i < level.channels.size(); ++i) {
      LevelChannel& c = level.channels[i];
      const ChannelInfo& channel = info.channels[i];
      if (const auto scale = in.read<double>(); scale != channel.scale)
        fail(Code::corrupt, "metadata: a level with scale ", scale, " of channel ", channel.name,
             ", which has ", channel.scale);
      for (uint64_t* n : {&c.sites_kept, &c.holes, &c.clamped}) *n = in.read<uint64_t>();
      c.kept_range = read_range(in);
    }
  }
}

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

void write_world(ByteWriter& out, const VolumeInfo& info) {
  for (size_t r = 0; r < 3; ++r) {
    for (const double v : info.affine.linear[r]) out.write(v);
    out.write(info.affine.offset[r]);
  }
  out.write_string(info.spatial_unit);
}
void read_world(ByteReader& in, VolumeInfo& info) {
  for (size_t r = 0; r < 3; ++r) {
    for (double& v : info.affine.linear[r]) v = in.read<double>();
    info.affine.offset[r] = in.read<double>();
  }
  info.spatial_unit = read_text(in);
}

void write_axes(ByteWriter& out, const std::array<AxisInfo, 3>& axes) {
  for (const AxisInfo& a : axes) {
    out.write_string(a.unit);
    out.write(a.down ? counts_down : uint32_t{0});
    out.write(static_cast<uint32_t>(a.coordinates.size()));
    for (const double v : a.coordinates) out.write(v);
  }
}
void read_axes(ByteReader& in, VolumeInfo& info) {
  for (size_t axis = 0; axis < 3; ++axis) {
    AxisInfo& a = info.axes[axis];
    a.unit = read_text(in);
    const auto flags = in.read<uint32_t>();
    if ((flags & ~counts_down) != 0) fail(Code::corrupt, "metadata: flags ", flags, " of an axis");
    a.down = flags != 0;
    a.coordinates.resize(read_count(in, "coordinates", sizeof(double), {info.lattice.dims[axis], "samples"}));
    for (double& v : a.coordinates) v = in.read<double>();
  }
}

void write_time(ByteWriter& out, const TimeMap& t) {
  out.write(t.first);
  out.write(t.step);
  out.write_string(t.unit);
  out.write_string(t.epoch);
  out.write(static_cast<uint32_t>(t.times.size()));
  for (const double v : t.times) out.write(v);
}
void read_time(ByteReader& in, VolumeInfo& info) {
  TimeMap& t = info.time;
  t.first = in.read<double>();
  t.step = in.read<double>();
  t.unit = read_text(in);
  t.epoch = read_text(in);
  t.times.resize(read_count(in, "times", 8, {info.lattice.dims[3], "frames"}));
  for (double& v : t.times) v = in.read<double>();
  t.uniform = t.times.empty();
}

} // namespace bccsplat
