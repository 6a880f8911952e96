// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/coding/residuals.h"

#include "base/bytes.h"

namespace bccsplat {
namespace {

// Signed numbers as unsigned ones, small magnitudes first: 0 -1 1 -2 2 ...
uint64_t zigzag(int64_t v) { return static_cast<uint64_t>(v) << 1 ^ static_cast<uint64_t>(v >> 63); }
int64_t unzigzag(uint64_t v) { return static_cast<int64_t>(v >> 1) ^ -static_cast<int64_t>(v & 1); }

void write_list(ByteWriter& out, std::span<const ResidualSample> list) {
  uint64_t next = 0;
  for (const ResidualSample& s : list) {
    out.write_varint(s.voxel - next);
    next = s.voxel + 1;
  }
  for (const ResidualSample& s : list) out.write_varint(zigzag(s.steps));
}

ResidualList read_list(ByteReader& in, uint32_t count, uint64_t voxels, uint64_t offset) {
  if (count > in.remaining() / 2)
    fail(Code::corrupt, "corrections at offset ", offset, ": ", count, " in ", in.remaining(), " bytes");
  ResidualList list(count);
  uint64_t next = 0;
  for (ResidualSample& s : list) {
    const uint64_t skip = in.read_varint();
    if (next >= voxels || skip >= voxels - next)
      fail(Code::corrupt, "corrections at offset ", offset, ": one beyond the ", voxels,
           " samples of a frame");
    s.voxel = next + skip;
    next = s.voxel + 1;
  }
  for (ResidualSample& s : list) s.steps = unzigzag(in.read_varint());
  return list;
}

} // namespace

std::vector<std::byte> write_corrections(std::span<const ResidualSample> list) {
  ByteWriter out;
  out.write(static_cast<uint32_t>(list.size()));
  write_list(out, list);
  return out.release();
}

ResidualList read_corrections(std::span<const std::byte> decoded, uint64_t voxels, uint64_t offset) {
  ByteReader in(decoded, "corrections", offset);
  const auto count = in.read<uint32_t>();
  ResidualList list = read_list(in, count, voxels, offset);
  in.expect_end();
  return list;
}

std::vector<std::byte> write_residuals(const FrameResiduals& r) {
  ByteWriter out;
  out.write(static_cast<uint32_t>(r.add.size()));
  out.write(static_cast<uint32_t>(r.set.size()));
  write_list(out, r.add);
  write_list(out, r.set);
  return out.release();
}

FrameResiduals read_residuals(std::span<const std::byte> decoded, uint64_t voxels, uint64_t offset) {
  ByteReader in(decoded, "corrections", offset);
  const auto added = in.read<uint32_t>(), set = in.read<uint32_t>();
  FrameResiduals r;
  r.add = read_list(in, added, voxels, offset);
  r.set = read_list(in, set, voxels, offset);
  in.expect_end();
  return r;
}

} // namespace bccsplat
