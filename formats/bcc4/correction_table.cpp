// SPDX-License-Identifier: Apache-2.0
// Splits the corrections of a frame into bricks, and writes, reads and checks the table of these.
#include "formats/bcc4/correction_table.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "base/bytes.h"

namespace bccsplat {
namespace {

constexpr int64_t edge = correction_edge;

void write_entry(ByteWriter& out, const CorrectionBrick& b) {
  out.write(b.brick);
  for (const float bound : {b.low, b.high}) out.write(bound);
  out.write(b.count);
  write_block_ref(out, b.block);
}

} // namespace

std::vector<std::pair<uint32_t, ResidualList>>
split_corrections(const CorrectionBricks& bricks, std::span<const ResidualSample> frame, Progress& progress) {
  const std::array<int64_t, 3>& n = bricks.samples();
  std::map<uint32_t, ResidualList> lists;
  // Samples of a run lie in one row of one brick, whose list is looked up once.
  ResidualList* list = nullptr;
  int64_t run_begin = 0, run_end = 0, to_local = 0; // voxels of the frame; what makes them the brick's
  for (const ResidualSample& s : frame) {
    const int64_t voxel = s.voxel;
    if (voxel < run_begin || voxel >= run_end) {
      progress.check();
      const int64_t x = voxel % n[0], y = voxel / n[0] % n[1], z = voxel / (n[0] * n[1]);
      run_begin = voxel - x % edge;
      run_end = voxel - x + std::min(x - x % edge + edge, n[0]);
      to_local = (z % edge * edge + y % edge) * edge - run_begin;
      list = &lists[bricks.brick_of(
          {static_cast<int32_t>(x), static_cast<int32_t>(y), static_cast<int32_t>(z)})];
    }
    // The order of the frame is that of each brick.
    list->push_back({static_cast<uint64_t>(voxel + to_local), s.steps});
  }
  return {std::make_move_iterator(lists.begin()), std::make_move_iterator(lists.end())};
}

uint64_t brick_plane_end(const CorrectionBricks& bricks, uint64_t voxel) {
  const uint64_t plane = bricks.samples()[0] * bricks.samples()[1] * edge;
  return (voxel / plane + 1) * plane;
}

void check_corrections(const CorrectionBricks& bricks, const CorrectionBrick& brick,
                       std::span<const ResidualSample> list, double step) {
  const auto bad = [&](const auto&... why) {
    fail(Code::corrupt, "corrections at offset ", brick.block.offset, ": ", why...);
  };
  if (list.size() != brick.count) bad(list.size(), " of them, the table says ", brick.count);
  const Int3 from = bricks.origin(brick.brick);
  for (const ResidualSample& s : list) {
    const int64_t v = s.voxel;
    const std::array<int64_t, 3> at{from[0] + v % edge, from[1] + v / edge % edge,
                                    from[2] + v / (edge * edge)};
    for (size_t a = 0; a < 3; ++a)
      if (at[a] >= bricks.samples()[a]) bad("one beyond the frame");
    const float got = correction_value(s.steps, step);
    if (!(got >= brick.low && got <= brick.high))
      bad(got, " is not between the bounds ", brick.low, " and ", brick.high);
  }
}

void write_correction_table(ByteWriter& out, std::span<const CorrectionBrick> table) {
  out.write(static_cast<uint32_t>(table.size()));
  for (const CorrectionBrick& b : table) write_entry(out, b);
}

std::vector<CorrectionBrick> read_correction_table(std::span<const std::byte> decoded,
                                                   const CorrectionBricks& bricks, uint64_t offset,
                                                   uint64_t file_bytes) {
  ByteReader in(decoded, "table of corrections", offset);
  const auto n = in.read<uint32_t>();
  const auto bad = [&](const auto&... why) {
    fail(Code::corrupt, "table of corrections at offset ", offset, ": ", why...);
  };
  if (n > in.remaining() / table_entry_bytes) bad(n, " bricks in ", in.remaining(), " bytes");
  std::vector<CorrectionBrick> table(n);
  for (size_t i = 0; i < n; ++i) {
    CorrectionBrick& b = table[i];
    b.brick = in.read<uint32_t>();
    b.low = in.read<float>(), b.high = in.read<float>();
    b.count = in.read<uint32_t>();
    b.block = read_block_ref(in);
    if (b.brick >= bricks.count() || (i > 0 && b.brick <= table[i - 1].brick))
      bad("brick ", b.brick, " of ", bricks.count(), ", or they do not rise");
    if (!std::isfinite(b.low) || !std::isfinite(b.high) || b.low > b.high)
      bad("bounds ", b.low, " and ", b.high);
    if (b.count == 0 || b.count > edge * edge * edge) bad(b.count, " corrections in a brick");
    check_block_ref(b.block, "corrections", file_bytes);
  }
  in.expect_end();
  return table;
}

} // namespace bccsplat
