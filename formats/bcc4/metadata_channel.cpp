// SPDX-License-Identifier: Apache-2.0
// Writes and reads the records of what is stored: the channels, the blocks of their masks and corrections,
// and the errors that were measured.
#include <bit>

#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/metadata_records.h"
#include "formats/bcc4/page.h"

namespace bccsplat {
namespace {

constexpr uint64_t measured_error_bytes = 48;
constexpr uint16_t linear_flag = 1;

} // namespace

void write_channel(ByteWriter& out, const ChannelInfo& c) {
  out.write(static_cast<uint8_t>(c.type));
  out.write(static_cast<uint8_t>(c.source_type));
  out.write(c.linear ? linear_flag : uint16_t{0});
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
uint32_t read_channel(ByteReader& in, ChannelInfo& c, uint32_t frames) {
  c.type = static_cast<ValueType>(in.read<uint8_t>());
  c.source_type = static_cast<SourceType>(in.read<uint8_t>());
  const auto flags = in.read<uint16_t>();
  if ((flags & ~linear_flag) != 0) fail(Code::corrupt, "metadata: reserved bits of a channel are not zero");
  c.linear = flags == linear_flag;
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
  c.histogram.resize(read_count(in, "counts", 8, {256, "bins"}));
  for (uint64_t& n : c.histogram) n = in.read<uint64_t>();
  c.percentiles.resize(read_count(in, "percentiles", 16));
  for (Percentile& p : c.percentiles) {
    p.percent = in.read<double>();
    p.value = in.read<double>();
  }
  c.frames.resize(read_count(in, "ranges", 16, {frames, "frames"}));
  for (Range& r : c.frames) r = read_range(in);
  return air_code;
}

void write_blocks(ByteWriter& out, const std::vector<BlockRef>& blocks) {
  out.write(static_cast<uint32_t>(blocks.size()));
  for (const BlockRef& ref : blocks) write_block_ref(out, ref);
}
void read_blocks(ByteReader& in, std::vector<BlockRef>& blocks, uint32_t frames) {
  blocks.resize(read_count(in, "blocks", block_ref_bytes, {frames, "frames"}));
  for (BlockRef& ref : blocks) ref = read_block_ref(in);
}

void write_residual_info(ByteWriter& out, const ResidualInfo& r) {
  out.write(r.step);
  out.write(r.bound);
  write_blocks(out, r.frames);
}
void read_residual_info(ByteReader& in, ResidualInfo& r, uint32_t frames) {
  const auto step = in.read<double>(), bound = in.read<double>();
  if (r.local && (step != r.step || bound != r.bound))
    fail(Code::corrupt, "metadata: two records of corrections differ in step or bound");
  r.step = step, r.bound = bound;
  read_blocks(in, r.frames, frames);
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
void read_correction_info(ByteReader& in, ResidualInfo& r, uint32_t frames) {
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
  read_blocks(in, r.tables, frames);
}

void write_sums(ByteWriter& out, const FrameSums& sums) {
  out.write(sums.corrections);
  out.write(sums.missing);
}
FrameSums read_sums(ByteReader& in) {
  FrameSums sums;
  sums.corrections = in.read<uint64_t>();
  sums.missing = in.read<uint64_t>();
  return sums;
}

void write_errors(ByteWriter& out, const std::vector<MeasuredError>& list) {
  out.write(static_cast<uint32_t>(list.size()));
  for (const MeasuredError& e : list) {
    for (const uint32_t n : {e.channel, e.level, e.kind, e.frames}) out.write(n);
    out.write(e.samples);
    for (const double v : {e.rmse, e.largest, e.range}) out.write(v);
  }
}
void read_errors(ByteReader& in, VolumeInfo& info) {
  constexpr uint64_t kinds = MeasuredError::corrected + 1;
  info.errors.resize(read_count(in, "measured errors", measured_error_bytes,
                                info.channels.size() * info.level_count() * kinds));
  for (MeasuredError& e : info.errors) {
    for (uint32_t* n : {&e.channel, &e.level, &e.kind, &e.frames}) *n = in.read<uint32_t>();
    e.samples = in.read<uint64_t>();
    for (double* v : {&e.rmse, &e.largest, &e.range}) *v = in.read<double>();
  }
}

} // namespace bccsplat
