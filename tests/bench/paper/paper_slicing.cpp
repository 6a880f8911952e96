// SPDX-License-Identifier: Apache-2.0
// How long slices take by the paper's methods on D4* and on CC, in turn, and what a slice takes as run
// lengths and as bricks.
#include <algorithm>

#include "base/bytes.h"
#include "points/runs.h"
#include "slice/extraction.h"
#include "slice/hyperslice.h"
#include "slice/time_slice.h"
#include "splat/points/points.h"
#include "tests/bench/paper/paper.h"
#include "tests/support/band_limited.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using test::TestContext;

struct Side {
  MemorySamples samples;
  Coefficients coefficients;
  Side(LatticeKind kind, const std::array<uint32_t, 4>& dims, const test::Field4& field)
      : samples(test::sample_field(Lattice4::fit(kind, dims), field)),
        coefficients(samples, 0, make_kernel("paper"), 0, test::large_cache) {}
};

// A slice made by one of the paper's methods; returns its points.
using Cut = double (*)(const Side&, const Hyperplane&, const Context&);

double approximate(const Side& side, const Hyperplane& h, const Context& context) {
  return static_cast<double>(time_slice(side.coefficients, -h[4], {0, 0}, {}, context).points());
}
double accurate(const Side& side, const Hyperplane& h, const Context& context) {
  HypersliceOptions options;
  options.method = SliceMethod::resampled, options.bandwidth = {1, 1, 1, 1};
  options.target = side.samples.lattice().space.bcc ? LatticeKind::bcc : LatticeKind::cc;
  return static_cast<double>(hyperslice(side.coefficients, h, options, {}, context).points());
}
double extracted(const Side& side, const Hyperplane& h, const Context& context) {
  const Extraction e(side.samples, 0, h, plane_axes(h), context);
  return static_cast<double>(e.points());
}

struct NamedCut {
  const char* name;
  Cut cut;
};
constexpr NamedCut cuts[] = {{"4.2, approximate: two layers of a coset", approximate},
                             {"4.2, accurate: equation (6), all within 2 T", accurate},
                             {"4, extraction: points of the 4D lattice", extracted}};

} // namespace

void report_slicing(const Report& report, const std::string& only_lattice) {
  const uint32_t n = report.quick ? 16 : 48;
  const std::array<uint32_t, 4> dims{n, n, n, 24};
  const test::PlaneWaves waves(8, 0.5, 3);
  const Side d4star(LatticeKind::d4star, dims, waves), cc(LatticeKind::cc, dims, waves);
  TestContext context(1);
  const double middle = 11.4;
  std::vector<Row> rows;
  for (const NamedCut& c : cuts)
    for (const auto& [plane, h] :
         {std::pair{"t = const", Hyperplane{0, 0, 0, 1, -middle}},
          {"oblique", Hyperplane{0.5, -0.3, 0.2, 0.8, -0.4 * n * 0.5 - 0.8 * middle}}}) {
      if (c.cut == approximate && h[0] != 0) continue;
      double points[2] = {0, 0};
      const auto body = [&](const Side& side, size_t i) {
        return [&, i] { points[i] = c.cut(side, h, context.get()); };
      };
      if (!only_lattice.empty()) { // for programs that count instructions
        body(only_lattice == "cc" ? cc : d4star, 0)();
        continue;
      }
      const auto [bcc_s, cc_s] = paired_cpu_seconds(body(d4star, 0), body(cc, 1), report.quick ? 1 : 5);
      rows.push_back({word("slice", c.name), word("hyperplane", plane), figure("points CC", points[1], 0),
                      figure("points D4*", points[0], 0), figure("points %", 100 * points[0] / points[1], 1),
                      figure("CC ms", 1e3 * cc_s, 2), figure("D4* ms", 1e3 * bcc_s, 2),
                      figure("time %", 100 * bcc_s / cc_s, 1), figure("CC is slower by", cc_s / bcc_s, 2)});
    }
  if (only_lattice.empty())
    report.table(
        concat("Slices by the paper's methods, with its kernel: ", n, "^3 x 24 plane waves, all sites kept"),
        rows);
}

uint64_t slice_runs(const Slice& slice) {
  ByteWriter runs;
  for (int c = 0; c < slice.lattice.cosets(); ++c) {
    const BrickLayer& layer = slice.coset[c];
    const Int3 n = layer.dims();
    RunEncoder encoder(runs);
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; x += brick_edge) {
          const Brick* brick = layer.brick(x / brick_edge, y / brick_edge, z / brick_edge);
          const int row = z % brick_edge * brick_edge + y % brick_edge;
          encoder.row(brick ? brick->kept[row] : uint16_t{0}, std::min(brick_edge, n[0] - x));
        }
    encoder.finish();
  }
  return runs.size();
}

} // namespace bccsplat::bench
