#include "splat/points/points.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "splat/points/point_sizes.h"

namespace bccsplat {
namespace {

constexpr size_t vector_overhang = 16; // vectors read in whole, past the last point

// Local sites of a brick, packed as in SplatPoints::position, in the fixed shuffled order.
std::vector<uint16_t> shuffled_sites(bool bcc, int edge) {
  std::vector<uint16_t> sites;
  for (int z = 0; z < edge; ++z)
    for (int y = 0; y < edge; ++y)
      for (int x = 0; x < edge; ++x)
        if (!bcc || ((x & 1) == (y & 1) && (x & 1) == (z & 1)))
          sites.push_back(static_cast<uint16_t>(x | y << 4 | z << 8));
  uint32_t state = 0x9e3779b9u; // xorshift32: the same everywhere
  for (size_t n = sites.size() - 1; n > 0; --n) {
    state ^= state << 13, state ^= state >> 17, state ^= state << 5;
    std::swap(sites[n], sites[state % (n + 1)]);
  }
  return sites;
}

// Where plane h of an axis is stored: the site of its coset, mirrored into the domain; h counts from -margin.
struct Fold {
  std::vector<int32_t> site;
  Fold(const Lattice3& lattice, size_t axis, int margin, int count) {
    for (int n = 0; n < count; ++n) {
      const int h = n - margin;
      const int coset = lattice.bcc ? h & 1 : 0;
      site.push_back(lattice.mirror(axis, coset, lattice.bcc ? (h - coset) / 2 : h));
    }
  }
};

// A few out of many slots, and their numbers in rising order.
class SlotSet {
 public:
  explicit SlotSet(uint64_t slots) : bits_(slots / 64 + 1), before_(bits_.size()) {}
  void add(uint64_t slot) { bits_[slot / 64] |= uint64_t{1} << slot % 64; }
  // All of them, x fastest; numbers count from here on.
  [[nodiscard]] std::vector<uint64_t> list() {
    std::vector<uint64_t> slots;
    for (size_t word = 0; word < bits_.size(); ++word) {
      before_[word] = static_cast<uint32_t>(slots.size());
      for (uint64_t rest = bits_[word]; rest != 0; rest &= rest - 1)
        slots.push_back(64 * word + static_cast<uint64_t>(std::countr_zero(rest)));
    }
    return slots;
  }
  // -1: not among them.
  [[nodiscard]] int64_t number(uint64_t slot) const {
    const uint64_t word = bits_[slot / 64], bit = uint64_t{1} << slot % 64;
    return word & bit ? int64_t{before_[slot / 64]} + std::popcount(word & (bit - 1)) : -1;
  }

 private:
  std::vector<uint64_t> bits_;
  std::vector<uint32_t> before_; // how many stand in earlier words
};

// Slots that bricks of the slice reach, themselves or by their mirror images: nothing is spent on the others.
SlotSet touched_slots(const Slice& slice, const std::array<Fold, 3>& fold, const Int3& dims, int edge) {
  SlotSet touched(static_cast<uint64_t>(dims[0]) * static_cast<uint64_t>(dims[1]) *
                  static_cast<uint64_t>(dims[2]));
  const bool bcc = slice.lattice.bcc;
  for (int coset = 0; coset < (bcc ? 2 : 1); ++coset) {
    const BrickLayer& layer = slice.coset[static_cast<size_t>(coset)];
    std::array<std::vector<std::vector<int>>, 3> reached; // by axis and brick of the slice, rising
    for (size_t a = 0; a < 3; ++a) {
      reached[a].resize(static_cast<size_t>(layer.brick_dims()[a]));
      for (size_t n = bcc ? static_cast<size_t>(coset) : 0; n < fold[a].site.size(); n += bcc ? 2 : 1) {
        std::vector<int>& into = reached[a][static_cast<size_t>(fold[a].site[n] / brick_edge)];
        if (const int at = static_cast<int>(n) / edge; into.empty() || into.back() != at) into.push_back(at);
      }
    }
    for (size_t slot = 0; slot < layer.brick_slots(); ++slot) {
      if (!layer.brick(slot)) continue;
      const Int3 at = layer.slot_position(slot);
      for (const int z : reached[2][static_cast<size_t>(at[2])])
        for (const int y : reached[1][static_cast<size_t>(at[1])])
          for (const int x : reached[0][static_cast<size_t>(at[0])])
            touched.add(
                (static_cast<uint64_t>(z) * static_cast<uint64_t>(dims[1]) + static_cast<uint64_t>(y)) *
                    static_cast<uint64_t>(dims[0]) +
                static_cast<uint64_t>(x));
    }
  }
  return touched;
}

struct BrickPoints {
  SplatBrick brick;
  std::array<CellRange, cells_per_brick> cell{};
  std::array<uint8_t, cells_per_brick> in_cell{}; // points
  std::array<uint8_t, SplatPoints::fine_cells> codes{};
  std::vector<uint16_t> position;
  std::vector<float> coefficient;
};

// The cells of a brick and of those around it, 4 + 2 `most` along each axis.
struct CellCube {
  static constexpr int most = 3, side = 4 + 2 * most;
  std::array<CellRange, side * side * side> cell{};

  [[nodiscard]] CellRange& at(int x, int y, int z) {
    return cell[static_cast<size_t>(((z + most) * side + y + most) * side + x + most)];
  }
};

// Of the brick in `slot`, out of the cells of all bricks that were made; `edge` cells per brick and axis.
void gather_cells(const std::vector<BrickPoints>& made, const SlotSet& touched, const Int3& dims,
                  uint64_t slot, int edge, CellCube& cube) {
  const int nx = dims[0], ny = dims[1];
  const int at[3] = {static_cast<int>(slot) % nx, static_cast<int>(slot) / nx % ny,
                     static_cast<int>(slot) / (nx * ny)};
  constexpr int most = CellCube::most;
  std::array<std::array<int, CellCube::side>, 3> brick{}, local{};
  for (size_t a = 0; a < 3; ++a)
    for (int n = -most; n < edge + most; ++n) {
      const int global = at[a] * edge + n, b = global >= 0 ? global / edge : -1;
      brick[a][static_cast<size_t>(n + most)] = b < dims[a] ? b : -1;
      local[a][static_cast<size_t>(n + most)] = global - b * edge;
    }
  for (int z = -most; z < edge + most; ++z)
    for (int y = -most; y < edge + most; ++y)
      for (int x = -most; x < edge + most; ++x) {
        const auto i = static_cast<size_t>(x + most), j = static_cast<size_t>(y + most),
                   k = static_cast<size_t>(z + most);
        if (brick[0][i] < 0 || brick[1][j] < 0 || brick[2][k] < 0) continue;
        const int64_t n =
            touched.number(static_cast<uint64_t>((brick[2][k] * ny + brick[1][j]) * nx + brick[0][i]));
        if (n < 0) continue;
        cube.at(x, y, z) = made[static_cast<size_t>(n)]
                               .cell[static_cast<size_t>(local[0][i] | local[1][j] << 2 | local[2][k] << 4)];
      }
}

// Ranges over the cells at most `reach` cells away, one axis after the other.
void widen_cells(CellCube cube, int reach, CellRange* out) {
  const auto over = [reach](auto cell) {
    CellRange range = cell(-reach);
    for (int n = 1 - reach; n <= reach; ++n) {
      const CellRange c = cell(n);
      range = {std::min(range.low, c.low), std::max(range.high, c.high)};
    }
    return range;
  };
  constexpr int most = CellCube::most;
  CellCube along_x, along_y;
  for (int z = -most; z < 4 + most; ++z)
    for (int y = -most; y < 4 + most; ++y)
      for (int x = 0; x < 4; ++x) along_x.at(x, y, z) = over([&](int n) { return cube.at(x + n, y, z); });
  for (int z = -most; z < 4 + most; ++z)
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 4; ++x) along_y.at(x, y, z) = over([&](int n) { return along_x.at(x, y + n, z); });
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 4; ++x)
        out[x | y << 2 | z << 4] = over([&](int n) { return along_y.at(x, y, z + n); });
}

constexpr int code_octaves = 16, code_shift = 20; // three bits of the mantissa are kept

// A float's highest bits, exponent and mantissa.
uint32_t float_steps(float x) { return std::bit_cast<uint32_t>(x) >> code_shift; }

} // namespace

uint8_t SplatPoints::code(float c) const {
  const auto steps = static_cast<int>(float_steps(std::fabs(c) * code_unit));
  const auto zero = static_cast<int>(float_steps(std::ldexp(1.0f, -code_octaves)));
  return static_cast<uint8_t>(std::clamp(steps - zero, 0, most_code));
}

float SplatPoints::code_begin(int n) const {
  return std::bit_cast<float>((float_steps(std::ldexp(1.0f, -code_octaves)) + static_cast<uint32_t>(n))
                              << code_shift) /
         code_unit;
}

SplatPoints make_points(const Slice& slice, const Context& context) {
  SplatPoints points;
  const Lattice3& lattice = slice.lattice;
  points.plane_distance = lattice.plane_distance();
  points.margin = static_cast<int>(std::ceil((slice.kernel.space.radius + 2) / points.plane_distance));
  points.margin += points.margin & 1; // even: local planes keep their parity
  points.edge = lattice.bcc ? 16 : 8;
  Int3 planes;
  for (size_t a = 0; a < 3; ++a) {
    planes[a] = lattice.last[a] + 1 + 2 * points.margin;
    points.dims[a] = (planes[a] + points.edge - 1) / points.edge;
  }
  const std::array<Fold, 3> fold{Fold(lattice, 0, points.margin, planes[0]),
                                 Fold(lattice, 1, points.margin, planes[1]),
                                 Fold(lattice, 2, points.margin, planes[2])};
  const std::vector<uint16_t> sites = shuffled_sites(lattice.bcc, points.edge);

  // The power of two that brings what the field holds below 1; coefficients go somewhat further.
  const double air = static_cast<double>(slice.air),
               largest = std::max(std::fabs(slice.bounds[0] - air), std::fabs(slice.bounds[1] - air));
  if (largest > 1e-30 && largest < 1e30) points.code_unit = std::ldexp(1.0f, -std::ilogb(largest) - 1);

  SlotSet touched = touched_slots(slice, fold, points.dims, points.edge);
  const std::vector<uint64_t> slots = touched.list();
  std::vector<BrickPoints> made(slots.size());
  context.tasks.parallel_for(made.size(), [&](uint64_t number) {
    context.progress.check();
    const uint64_t slot = slots[number];
    const auto nx = static_cast<uint64_t>(points.dims[0]), ny = static_cast<uint64_t>(points.dims[1]);
    const int origin[3] = {static_cast<int>(slot % nx) * points.edge,
                           static_cast<int>(slot / nx % ny) * points.edge,
                           static_cast<int>(slot / (nx * ny)) * points.edge};
    BrickPoints& out = made[number];
    SplatBrick& b = out.brick;
    b.low.fill(255);
    const BrickLayer* layer[2] = {&slice.coset[0], &slice.coset[lattice.bcc ? 1 : 0]};
    for (const uint16_t s : sites) {
      const int local[3] = {s & 15, s >> 4 & 15, s >> 8 & 15};
      if (origin[0] + local[0] >= planes[0] || origin[1] + local[1] >= planes[1] ||
          origin[2] + local[2] >= planes[2])
        continue;
      const auto site = [&](size_t a) { return fold[a].site[static_cast<size_t>(origin[a] + local[a])]; };
      const float c = layer[lattice.bcc ? local[0] & 1 : 0]->value(site(0), site(1), site(2));
      if (c == 0) continue;
      uint8_t& code = out.codes[fine_cell(s)];
      code = std::max(code, points.code(c));
      out.position.push_back(s);
      out.coefficient.push_back(c);
      for (size_t a = 0; a < 3; ++a) {
        b.low[a] = std::min(b.low[a], static_cast<uint8_t>(local[a]));
        b.high[a] = std::max(b.high[a], static_cast<uint8_t>(local[a]));
      }
      const auto cell_number = static_cast<size_t>(local[0] >> 2 | local[1] >> 2 << 2 | local[2] >> 2 << 4);
      CellRange& cell = out.cell[cell_number];
      if (out.in_cell[cell_number]++ == 0) cell = {c, c};
      cell = {std::min(cell.low, c), std::max(cell.high, c)};
      b.coefficient[0] = std::min(b.coefficient[0], c);
      b.coefficient[1] = std::max(b.coefficient[1], c);
    }
    for (size_t n = 0; n < cells_per_brick; ++n)
      if (out.in_cell[n] < (lattice.bcc ? 16 : 64))
        out.cell[n] = {std::min(out.cell[n].low, 0.0f), std::max(out.cell[n].high, 0.0f)};
    b.count = static_cast<uint32_t>(out.position.size());
    for (size_t a = 0; a < 3; ++a) b.plane[a] = origin[a] - points.margin;
  });

  uint64_t total = 0, kept = 0;
  for (const BrickPoints& b : made) total += b.brick.count, kept += b.brick.count ? 1u : 0u;
  if (total > UINT32_MAX)
    fail(Code::limit_exceeded, "render: a slice of ", total, " points; at most 2^32 - 1 are drawn");
  points.memory = Reservation(
      context.memory,
      total * (sizeof(float) + sizeof(uint16_t)) +
          kept * (sizeof(SplatBrick) + 3 * cells_per_brick * sizeof(CellRange) + SplatPoints::fine_cells),
      "the points of a slice");
  points.position.resize(total + vector_overhang);
  points.coefficient.resize(total + vector_overhang);
  points.bricks.resize(kept);
  std::vector<size_t> kept_numbers; // among made
  kept_numbers.reserve(kept);
  uint32_t first = 0;
  for (size_t number = 0; number < made.size(); ++number) {
    if (made[number].brick.count == 0) continue;
    made[number].brick.first = std::exchange(first, first + made[number].brick.count);
    kept_numbers.push_back(number);
  }
  for (auto& cells : points.cells) cells.resize(kept * cells_per_brick);
  points.codes.resize(kept * SplatPoints::fine_cells);
  context.tasks.parallel_for(kept, [&](uint64_t n) {
    const size_t number = kept_numbers[n];
    const uint64_t slot = slots[number];
    BrickPoints& b = made[number];
    SplatBrick& brick = points.bricks[n] = b.brick;
    const auto nx = static_cast<size_t>(points.dims[0]), ny = static_cast<size_t>(points.dims[1]);
    const int at[3] = {static_cast<int>(slot % nx), static_cast<int>(slot / nx % ny),
                       static_cast<int>(slot / (nx * ny))};
    for (int z = std::max(0, at[2] - 1); z <= std::min(points.dims[2] - 1, at[2] + 1); ++z)
      for (int y = std::max(0, at[1] - 1); y <= std::min(points.dims[1] - 1, at[1] + 1); ++y)
        for (int x = std::max(0, at[0] - 1); x <= std::min(points.dims[0] - 1, at[0] + 1); ++x) {
          const int64_t other = touched.number((static_cast<size_t>(z) * ny + static_cast<size_t>(y)) * nx +
                                               static_cast<size_t>(x));
          if (other < 0) continue;
          const SplatBrick& beside = made[static_cast<size_t>(other)].brick;
          brick.reach[0] = std::min(brick.reach[0], beside.coefficient[0]);
          brick.reach[1] = std::max(brick.reach[1], beside.coefficient[1]);
        }
    std::copy(b.position.begin(), b.position.end(), points.position.begin() + brick.first);
    std::copy(b.coefficient.begin(), b.coefficient.end(), points.coefficient.begin() + brick.first);
    b.position = {}, b.coefficient = {};
    std::copy(b.codes.begin(), b.codes.end(),
              points.codes.begin() + static_cast<std::ptrdiff_t>(n * SplatPoints::fine_cells));
    CellCube cube;
    gather_cells(made, touched, points.dims, slot, points.edge / 4, cube);
    for (size_t r = 0; r < SplatPoints::cell_reach.size(); ++r)
      widen_cells(cube, SplatPoints::cell_reach[r], points.cells[r].data() + n * cells_per_brick);
  });
  points.count = static_cast<uint32_t>(total);
  return points;
}

} // namespace bccsplat
