// SPDX-License-Identifier: Apache-2.0
// The cells that rays look at: the bound they follow from, that none that holds the value is left out, and
// how long they are kept.
#include "rays/surface_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

#include "base/error.h"
#include "rays/cell_bound.h"
#include "rays/cell_marker.h"
#include "tests/support/cell_bound_proof.h"
#include "tests/support/splat_scene.h"
#include "tests/support/targets.h"

namespace bccsplat {
namespace {

using namespace test;

constexpr const char* kernels[] = {"radial16+b2", "radial18+b3", "radial20+b3"};

// With coefficients of +-1 that make the most of a place, the difference from the corners comes near the
// bound and never passes it.
TEST(CellBound, HoldsAndIsNear) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (const char* name : kernels) {
    const RadialKernel kernel = make_kernel(name).space;
    for (const int parts : {1, cell_parts, refined_parts}) {
      const CellBound bound = prove_cell_bound(kernel, parts);
      double most = 0;
      for (int trial = 0; trial < 4000; ++trial) {
        Vec3 low, part;
        for (size_t a = 0; a < 3; ++a) {
          low[a] = std::floor(uniform(random) * parts) / parts;
          part[a] = uniform(random);
        }
        double range = 0, middle = 0;
        for (int z = -5; z <= 6; ++z)
          for (int y = -5; y <= 6; ++y)
            for (int x = -5; x <= 6; ++x) {
              if (((x ^ y) & 1) != 0 || ((x ^ z) & 1) != 0) continue;
              const auto weight = [&](const Vec3& at) {
                const Vec3 d = at - Vec3{1.0 * x, 1.0 * y, 1.0 * z};
                return kernel.value(0.5 * dot(d, d));
              };
              double r = weight(low + (1.0 / parts) * part);
              for (size_t c = 0; c < 8; ++c) {
                double share = 1;
                Vec3 corner = low;
                for (size_t a = 0; a < 3; ++a) {
                  share *= (c >> a & 1) != 0 ? part[a] : 1 - part[a];
                  corner[a] += (c >> a & 1) != 0 ? 1.0 / parts : 0;
                }
                r -= share * weight(corner);
              }
              range += std::fabs(r), middle += r;
            }
        EXPECT_LE(range, bound.of_range) << name;
        EXPECT_LE(std::fabs(middle), bound.of_middle) << name;
        most = std::max(most, range);
      }
      EXPECT_GT(most, (parts == 1 ? 0.9 : 0.75) * bound.of_range) << name << ' ' << parts;
    }
  }
}

TEST(CellBound, IsThatOfTheProof) {
  for (const char* name : kernels)
    for (const int parts : {cell_parts, refined_parts}) {
      const Kernel kernel = make_kernel(name);
      const auto bound = cell_bound(kernel, parts);
      ASSERT_TRUE(bound) << name;
      const CellBound proven = prove_cell_bound(kernel.space, parts);
      EXPECT_GE(bound->of_range, proven.of_range) << name << ' ' << parts;
      EXPECT_GE(bound->of_middle, proven.of_middle) << name << ' ' << parts;
      EXPECT_LT(bound->of_range, proven.of_range + 2e-4) << name << ' ' << parts;
      EXPECT_LT(bound->of_middle, proven.of_middle + 2e-4) << name << ' ' << parts;
    }
  EXPECT_FALSE(cell_bound(make_kernel("radial24+b4")));
  EXPECT_FALSE(cell_bound(make_kernel("paper")));
}

// Noise, every sample by itself, with air around it.
Slice noise(const std::array<uint32_t, 3>& dims, const char* kernel, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  return make_slice(
      dims,
      [&, n = dims](double x, double y, double z) {
        const double far = std::max({x / n[0], y / n[1], z / n[2]});
        return far < 0.75 ? uniform(random) : 0.0;
      },
      kernel);
}

// The cells of a slice in which random points lie on both sides of the target.
std::vector<Int3> passed_cells(const Slice& s, double target, int points) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Int3> out;
  std::vector<Vec3> p(static_cast<size_t>(points));
  std::vector<float> value(p.size());
  Int3 c;
  for (c[2] = 0; c[2] < s.lattice.last[2]; ++c[2])
    for (c[1] = 0; c[1] < s.lattice.last[1]; ++c[1])
      for (c[0] = 0; c[0] < s.lattice.last[0]; ++c[0]) {
        for (Vec3& at : p)
          for (size_t a = 0; a < 3; ++a) at[a] = (c[a] + uniform(random)) * s.lattice.plane_distance();
        evaluate(s, p, value, {});
        const auto [low, high] = std::minmax_element(value.begin(), value.end());
        if (*low<target&& * high> target) out.push_back(c);
      }
  return out;
}

size_t count_marked(const SurfaceCells& cells) {
  size_t count = 0;
  Int3 c;
  for (c[2] = 0; c[2] < cells.cells[2]; ++c[2])
    for (c[1] = 0; c[1] < cells.cells[1]; ++c[1])
      for (c[0] = 0; c[0] < cells.cells[0]; ++c[0]) count += cells.marked(c) ? 1 : 0;
  return count;
}

TEST(SurfaceCells, HoldWhereTheFieldPassesTheValue) {
  TestContext context(2);
  const auto expect_held = [&](const Slice& s, double target) {
    const auto passed = passed_cells(s, target, 24);
    EXPECT_GT(passed.size(), 20u);
    for_targets([&] {
      SurfaceCells cells = mark_cells(s, target, context.get());
      const auto missed = [&] {
        return std::count_if(passed.begin(), passed.end(), [&](const Int3& c) { return !cells.marked(c); });
      };
      EXPECT_EQ(missed(), 0) << s.kernel.name << ' ' << target << " of " << passed.size();
      refine_cells(s, target, cells, context.get());
      EXPECT_EQ(missed(), 0) << "refined, " << s.kernel.name << ' ' << target << " of " << passed.size();
    });
  };
  // Longer than a stretch of lanes, thinner than a column, and of a few planes; smooth up to the faces.
  for (const std::array<uint32_t, 3>& dims :
       {std::array<uint32_t, 3>{52, 13, 17}, std::array<uint32_t, 3>{9, 30, 14},
        std::array<uint32_t, 3>{3, 2, 40}})
    for (const char* kernel : kernels) {
      const Slice s = noise(dims, kernel, dims[0]);
      for (const double target : {-0.4, 0.02, 0.5}) expect_held(s, target);
      const Slice smooth = make_slice(
          dims,
          [](double x, double y, double z) {
            return std::cos(0.5 * x) * std::cos(0.4 * y) * std::cos(0.3 * z);
          },
          kernel);
      for (const double target : {-0.3, 0.2, 0.6}) expect_held(smooth, target);
    }
}

// The largest value of the field in a cell, and how far it lies above the corners of the cell's eighths.
struct Peak {
  Int3 cell;
  double value, above;
};
Peak find_peak(const Slice& s, const Int3& cell) {
  constexpr int edge = 8; // points along it
  std::vector<Vec3> p;
  size_t corners = 0;
  for (const int steps : {cell_parts, edge}) {
    for (int n = 0; n < (steps + 1) * (steps + 1) * (steps + 1); ++n) {
      const Int3 at{n % (steps + 1), n / (steps + 1) % (steps + 1), n / (steps + 1) / (steps + 1)};
      Vec3 place;
      for (size_t a = 0; a < 3; ++a)
        place[a] = (cell[a] + static_cast<double>(at[a]) / steps) * s.lattice.plane_distance();
      p.push_back(place);
    }
    if (corners == 0) corners = p.size();
  }
  std::vector<float> value(p.size());
  evaluate(s, p, value, {});
  const auto inner = value.begin() + corners;
  const double corner = *std::max_element(value.begin(), inner), most = *std::max_element(inner, value.end());
  return {cell, most, most - corner};
}

// A value that a cell reaches at one place alone, above all corners, in the domain's middle and at its faces.
TEST(SurfaceCells, HoldPeaksBetweenCorners) {
  TestContext context(2);
  constexpr size_t most = 60;
  for (const char* kernel : kernels) {
    // A wave of 0.6 of the band limit: its crests stand differently to the cells along every axis.
    const Slice s = make_slice(
        {40, 9, 10}, [](double x, double y, double z) { return std::cos(1.9 * x + 0.11 * y - 0.13 * z); },
        kernel);
    std::vector<Peak> inside, at_faces;
    Int3 c;
    for (c[2] = 0; c[2] < s.lattice.last[2]; ++c[2])
      for (c[1] = 0; c[1] < s.lattice.last[1]; ++c[1])
        for (c[0] = 0; c[0] < s.lattice.last[0]; ++c[0]) {
          bool face = false;
          for (size_t a = 0; a < 3; ++a) face |= c[a] < 1 || c[a] + 1 >= s.lattice.last[a];
          (face ? at_faces : inside).push_back(find_peak(s, c));
        }
    // Crests at the faces are highest there.
    std::sort(inside.begin(), inside.end(), [](const Peak& a, const Peak& b) { return a.above > b.above; });
    std::sort(at_faces.begin(), at_faces.end(),
              [](const Peak& a, const Peak& b) { return a.value > b.value; });
    EXPECT_GT(inside[most].above, 0.01);
    for (const auto* peaks : {&inside, &at_faces}) {
      int missed = 0;
      for (size_t n = 0; n < most; ++n) {
        const Peak& peak = (*peaks)[n];
        const double target = peak.value - 1e-5;
        SurfaceCells cells = mark_cells(s, target, context.get());
        missed += cells.marked(peak.cell) ? 0 : 1;
        refine_cells(s, target, cells, context.get());
        missed += cells.marked(peak.cell) ? 0 : 1;
      }
      EXPECT_EQ(missed, 0) << kernel << (peaks == &inside ? " inside" : " at faces");
    }
  }
}

// Of a smooth field hardly more is marked than is passed, and nothing in air.
TEST(SurfaceCells, AreFew) {
  TestContext context(2);
  const Slice s = make_slice({60, 40, 44}, [](double x, double y, double z) {
    return std::max(0.0, 1 - std::hypot(x - 40, y - 20, z - 22) / 9);
  });
  const auto passed = passed_cells(s, 0.5, 24);
  const SurfaceCells cells = mark_cells(s, 0.5, context.get());
  EXPECT_LT(count_marked(cells), 5 * passed.size() / 2);
  Int3 c;
  for (c[2] = 0; c[2] < cells.cells[2]; ++c[2])
    for (c[1] = 0; c[1] < cells.cells[1]; ++c[1])
      for (c[0] = 0; c[0] < 28; ++c[0]) ASSERT_FALSE(cells.marked(c));
  EXPECT_EQ(count_marked(mark_cells(s, 1.5, context.get())), 0u);
  // No field passes where all of it is the value.
  EXPECT_LT(count_marked(mark_cells(s, 0, context.get())),
            count_marked(mark_all_cells(s, context.get())) / 2);
}

TEST(SurfaceCells, AreTheSameForAnyNumberOfThreads) {
  const Slice s = noise({50, 40, 36}, "default", 5);
  TestContext one(1), many(5);
  SurfaceCells a = mark_cells(s, 0.1, one.get()), b = mark_cells(s, 0.1, many.get());
  EXPECT_TRUE(a.bits == b.bits);
  EXPECT_GT(count_marked(a), 1000u);
  refine_cells(s, 0.1, a, one.get()), refine_cells(s, 0.1, b, many.get());
  EXPECT_TRUE(a.bits == b.bits);
}

// Refined, few are left but those that the field passes; no mark is made.
TEST(SurfaceCells, AreFewerWhenRefined) {
  TestContext context(2);
  for (const char* kernel : kernels) {
    const Slice s = make_slice({37, 30, 33}, marschner_lobb(30, 5), kernel);
    for (const double target : {0.4, 0.6}) {
      const auto passed = passed_cells(s, target, 24);
      const SurfaceCells marked = mark_cells(s, target, context.get());
      SurfaceCells refined = mark_cells(s, target, context.get());
      refine_cells(s, target, refined, context.get());
      for (size_t n = 0; n < marked.bits.size(); ++n) ASSERT_EQ(refined.bits[n] & ~marked.bits[n], 0u);
      EXPECT_LT(5 * count_marked(refined), 4 * count_marked(marked)) << kernel;
      EXPECT_LT(4 * count_marked(refined), 7 * passed.size()) << kernel;
    }
  }
}

// Piece by piece the same marks are left as at once, and no piece is larger than asked for.
TEST(SurfaceCells, AreRefinedInPieces) {
  TestContext context(3);
  for (const std::array<uint32_t, 3>& dims :
       {std::array<uint32_t, 3>{37, 30, 33}, std::array<uint32_t, 3>{24, 50, 28}}) {
    const Slice s = make_slice(dims, marschner_lobb(30, 5));
    SurfaceCells whole = mark_cells(s, 0.4, context.get()), pieces = mark_cells(s, 0.4, context.get());
    const uint64_t marks = pieces.count();
    refine_cells(s, 0.4, whole, context.get());
    ASSERT_LT(whole.count(), marks);
    const uint64_t most = marks / 20;
    uint64_t row = 0, looked_at = 0;
    int calls = 0;
    for (; row < row_count(pieces) && calls < 1000; ++calls) {
      const auto before = pieces.bits;
      const uint64_t piece = refine_rows(s, 0.4, pieces, row, most, context.get());
      EXPECT_LE(piece, most);
      uint64_t gone = 0;
      for (size_t n = 0; n < before.size(); ++n) gone += std::popcount(before[n] & ~pieces.bits[n]);
      EXPECT_LE(gone, piece);
      looked_at += piece;
    }
    EXPECT_GE(calls, 20);
    EXPECT_EQ(looked_at, marks);
    EXPECT_TRUE(pieces.bits == whole.bits);
    // A row that has more marks than that waits.
    SurfaceCells full = mark_all_cells(s, context.get());
    row = 0;
    EXPECT_EQ(refine_rows(s, 0.4, full, row, 1, context.get()), 0u);
    EXPECT_EQ(row, 0u);
  }
}

// A later picture looks at a sixth as many marks as earlier ones had rays, what is left over added.
TEST(SurfaceCells, AreRefinedAsTheyAreUsed) {
  const Slice s = make_slice({37, 30, 33}, marschner_lobb(30, 5));
  TestContext context(2);
  KeptSurfaceCells kept;
  const auto cells = kept.find(s, 0.4, context.get());
  SurfaceCells refined = mark_cells(s, 0.4, context.get());
  refine_cells(s, 0.4, refined, context.get());
  const uint64_t marks = cells->count(), least = refined.count();
  EXPECT_GE(marks, count_marked(*cells));
  const uint64_t rays = 6 * marks / 10;
  (void)kept.find(s, 0.4, context.get(), rays);
  EXPECT_EQ(cells->count(), marks); // no picture had rays before
  uint64_t last = marks;
  int pictures = 0;
  for (; last > least && pictures < 30; ++pictures) {
    EXPECT_EQ(kept.find(s, 0.4, context.get(), rays), cells);
    EXPECT_LE(cells->count(), last);
    EXPECT_LE(last - cells->count(), 2 * marks / 10); // of a picture, and what one before had left over
    last = cells->count();
  }
  EXPECT_GE(pictures, 9);
  EXPECT_LE(pictures, 12);
  EXPECT_TRUE(cells->bits == refined.bits);
}

// Stretch by stretch, in any order, they are those marked at once; none that nobody comes to is.
TEST(SurfaceCells, WaitUntilTheyAreNeeded) {
  for (const char* kernel : kernels) {
    const Slice ball = make_slice(
        {120, 40, 60},
        [](double x, double y, double z) {
          return std::max(0.0, 1 - std::hypot(x - 70, y - 20, z - 30) / 12);
        },
        kernel);
    const Slice waves = make_slice({70, 44, 40}, marschner_lobb(44, 5), kernel);
    for (const Slice* s : {&ball, &waves}) {
      TestContext context(2);
      const SurfaceCells whole = mark_cells(*s, 0.4, context.get());
      SurfaceCells cells = unmarked_cells(*s, context.get());
      CellMarker marker(*s, 0.4, cells, context.get());
      marker.let_wait();
      EXPECT_EQ(cells.count(), 0u);
      std::mt19937 random(5);
      std::vector<Int3> order;
      Int3 n;
      for (n[2] = 0; n[2] < cells.blocks[2]; ++n[2])
        for (n[1] = 0; n[1] < cells.blocks[1]; ++n[1])
          for (n[0] = 0; n[0] < cells.blocks[0]; ++n[0]) order.push_back(n);
      std::shuffle(order.begin(), order.end(), random);
      size_t empty = 0;
      for (const Int3& block : order) {
        const bool any = marker.need(block, {block[0] + 1, block[1] + 1, block[2] + 1});
        EXPECT_TRUE(any || whole.bits[whole.at(block)] == 0);
        empty += any ? 0 : 1;
        EXPECT_EQ(cells.bits[cells.at(block)], whole.bits[whole.at(block)]);
      }
      EXPECT_GT(empty, s == &ball ? order.size() / 2 : 0);
      EXPECT_EQ(std::count(cells.state.begin(), cells.state.end(), SurfaceCells::waiting), 0);
    }
  }
  // Few rays have them wait, many do not.
  TestContext context(2);
  const Slice s = noise({50, 40, 36}, "default", 5);
  const auto waits = [&](uint64_t rays) {
    return !cells_for_rays(s, 0.1, rays, context.get()).state.empty();
  };
  EXPECT_TRUE(waits(100));
  EXPECT_FALSE(waits(100000));
  EXPECT_FALSE(waits(0));
}

// What rays come to later is looked at again, too.
TEST(SurfaceCells, AreRefinedWhereverRaysCome) {
  const Slice s = make_slice({70, 44, 40}, marschner_lobb(44, 5));
  TestContext context(2);
  KeptSurfaceCells kept;
  const auto cells = kept.find(s, 0.4, context.get(), 1);
  ASSERT_FALSE(cells->state.empty());
  CellMarker marker(s, 0.4, *cells, context.get());
  const Int3 middle{cells->blocks[0] / 2, cells->blocks[1], cells->blocks[2]};
  for (const Int3& end : {middle, cells->blocks}) {
    EXPECT_TRUE(marker.need({}, end));
    const uint64_t marks = cells->count();
    for (int picture = 0; picture < 3; ++picture) (void)kept.find(s, 0.4, context.get(), uint64_t{1} << 24);
    EXPECT_LT(100 * cells->count(), 97 * marks);
  }
}

TEST(SurfaceCells, AreKeptForTwoSurfaces) {
  const Slice s = noise({20, 20, 20}, "default", 1), other = noise({20, 20, 20}, "default", 2);
  TestContext context(2);
  KeptSurfaceCells kept;
  const auto first = kept.find(s, 0.1, context.get());
  const uint64_t one = context.memory.used();
  EXPECT_EQ(one, first->bits.size() * sizeof(uint64_t));
  EXPECT_EQ(kept.find(s, 0.1, context.get()), first);
  const auto second = kept.find(s, 0.2, context.get());
  EXPECT_NE(second, first);
  EXPECT_FALSE(second->bits == first->bits);
  EXPECT_EQ(kept.find(s, 0.1, context.get()), first);
  EXPECT_EQ(kept.find(s, 0.2, context.get()), second);
  EXPECT_NE(kept.find(other, 0.2, context.get()), second);
  EXPECT_EQ(kept.find(s, 0.2, context.get()), second);
  EXPECT_NE(kept.find(s, 0.1, context.get()), first); // was the oldest of three
  kept.forget();
  EXPECT_EQ(context.memory.used(), 2 * one); // what is held here
}

TEST(SurfaceCells, TakeMemoryAndHearCancels) {
  const Slice s = noise({40, 40, 40}, "default", 1);
  const auto code = [&](TestContext& context) {
    try {
      (void)mark_cells(s, 0.1, context.get());
    } catch (const Error& e) {
      return e.code();
    }
    return Code::internal;
  };
  TestContext small(2, 1000), cancelled(2);
  EXPECT_EQ(code(small), Code::memory_budget);
  EXPECT_EQ(small.memory.used(), 0u);
  cancelled.progress.cancel();
  EXPECT_EQ(code(cancelled), Code::cancelled);
  EXPECT_EQ(cancelled.memory.used(), 0u);
}

} // namespace
} // namespace bccsplat
