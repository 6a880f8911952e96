// SPDX-License-Identifier: Apache-2.0
// The contents of the metadata's records, each written and read back by a pair of functions (bcc4.md, section
// 3). What is read is checked only for what would keep it from being read: counts, reserved bytes, unknown
// kinds.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/error.h"
#include "formats/bcc4/counts.h"
#include "formats/bcc4/info.h"

namespace bccsplat {

[[nodiscard]] inline std::string read_text(ByteReader& in) { return in.read_string(in.remaining()); }
inline void write_range(ByteWriter& out, const Range& r) {
  out.write(r.low);
  out.write(r.high);
}
[[nodiscard]] inline Range read_range(ByteReader& in) {
  Range r;
  r.low = in.read<double>();
  r.high = in.read<double>();
  return r;
}

// Writes where the field is: metadata_lattice.cpp.
void write_lattice(ByteWriter& out, const VolumeInfo& info);
void read_lattice(ByteReader& in, VolumeInfo& info);
void write_levels(ByteWriter& out, const VolumeInfo& info);
void read_levels(ByteReader& in, VolumeInfo& info); // after the lattice and the channels
void write_domain(ByteWriter& out, const VolumeInfo& info);
void read_domain(ByteReader& in, Lattice4& l);
void write_world(ByteWriter& out, const VolumeInfo& info);
void read_world(ByteReader& in, VolumeInfo& info);
void write_axes(ByteWriter& out, const std::array<AxisInfo, 3>& axes);
void read_axes(ByteReader& in, VolumeInfo& info);
void write_time(ByteWriter& out, const TimeMap& t);
void read_time(ByteReader& in, VolumeInfo& info);

// Writes what is stored of a channel: metadata_channel.cpp. `frames` are those of the series.
void write_channel(ByteWriter& out, const ChannelInfo& c);
// Returns the code of air, which can be checked once the rest is known to be sound.
[[nodiscard]] uint32_t read_channel(ByteReader& in, ChannelInfo& c, uint32_t frames);
void write_blocks(ByteWriter& out, const std::vector<BlockRef>& blocks);
void read_blocks(ByteReader& in, std::vector<BlockRef>& blocks, uint32_t frames);
void write_residual_info(ByteWriter& out, const ResidualInfo& r);
void read_residual_info(ByteReader& in, ResidualInfo& r, uint32_t frames);
void write_correction_info(ByteWriter& out, const ResidualInfo& r);
void read_correction_info(ByteReader& in, ResidualInfo& r, uint32_t frames);
void write_sums(ByteWriter& out, const FrameSums& sums);
[[nodiscard]] FrameSums read_sums(ByteReader& in);
void write_errors(ByteWriter& out, const std::vector<MeasuredError>& list);
void read_errors(ByteReader& in, VolumeInfo& info);

} // namespace bccsplat
