// SPDX-License-Identifier: Apache-2.0
// One plane of the source after the other is filtered along x and y; those that a plane of the halved frame
// depends on stay in a ring, and are summed along z. Rows that are air take no part.
#include "fit/resample/halved_frame.h"

#include <algorithm>
#include <cmath>

#include "base/sizes.h"
#include "fit/axis/near_source.h"
#include "fit/axis/nonzero_bits.h"
#include "fit/axis/resample_tile.h"
#include "fit/axis/site_axis.h"
#include "fit/beyond/face_table.h"

namespace bccsplat {
namespace {

using Tables = FrameHalver::Tables;

constexpr auto cell_edges = CellRanges::edge;
constexpr int64_t run = 16; // samples of a brick along x, and of a cell
// How far around a sample of the halved frame those of the frame are looked at, in its distances: two samples
// to either side. What is left there is looked around once more when a level is resampled from it, so that
// less than near_source suffices (tests/bench/notes/halos.md).
constexpr double halved_reach = 1.25;

Lattice4 grid_of(const std::array<int64_t, 3>& dims, const AxisFlags& halved, const AxisFlags& turning) {
  std::array<uint32_t, 4> n{1, 1, 1, 1};
  LatticeScales scales{1, 1, 1, 1};
  for (size_t a = 0; a < 3; ++a) {
    n[a] = static_cast<uint32_t>(dims[a]);
    if (halved[a]) scales[a] = 2;
  }
  return Lattice4::fit(LatticeKind::cc, n, scales, 0, {}, false, turning);
}

Tables::Axis axis_of(const Lattice4& grid, size_t a, bool predicted, double noise) {
  Tables::Axis axis;
  const double widening = std::max(1.0, grid.space_step[a]);
  std::vector<double> positions = site_positions(grid, 0, a);
  if (grid.dims[a] == 1) positions.resize(1); // a lattice has two planes
  axis.table = predicted ? face_table(grid, 0, a, widening, noise) : filter_table(widening, positions);
  const int64_t n = grid.dims[a];
  axis.turns = grid.turns(a);
  for (size_t i = 0; i < positions.size(); ++i) {
    axis.near.push_back(near_samples(positions[i], halved_reach * widening, axis.table, i,
                                     nearest_sample(positions[i], n), axis.turns, n));
    std::array<int64_t, 2> inside{n, 0};
    for (int64_t k = axis.table.first[i]; k < axis.table.first[i] + axis.table.taps; ++k) {
      const int64_t sample = end_index(k, n, axis.turns);
      axis.sample.push_back(static_cast<int32_t>(sample));
      inside = {std::min(inside[0], sample), std::max(inside[1], sample + 1)};
    }
    axis.inside.push_back(inside);
  }
  return axis;
}

void add_bricks(Tables& t) {
  const Tables::Axis& axis = t.axis[0];
  const size_t taps = axis.table.taps;
  t.row_begin = 0, t.row_end = t.from[0];
  for (int64_t begin = 0; begin < t.to[0]; begin += run) {
    Tables::BrickX& brick = t.x.emplace_back();
    brick.base = axis.table.first[begin];
    brick.weight.assign(taps * run, 0.0f);
    brick.inside = axis.inside[begin];
    for (int64_t i = 0; i < run; ++i) { // samples beyond the last: its place, no weight
      const size_t at = std::min(begin + i, t.to[0] - 1);
      brick.index[i] = static_cast<int32_t>(axis.table.first[at] - brick.base);
      brick.inside = {std::min(brick.inside[0], axis.inside[at][0]),
                      std::max(brick.inside[1], axis.inside[at][1])};
      for (size_t k = 0; begin + i < t.to[0] && k < taps; ++k)
        brick.weight[k * run + i] = axis.table.weight[at * taps + k];
      t.row_begin = std::min(t.row_begin, axis.table.first[at]);
      t.row_end = std::max(t.row_end, axis.table.first[at] + axis.table.taps);
    }
  }
}

size_t padded(int64_t n) { return (n + run - 1) / run * run; }

// The samples that begin .. end - 1 of the halved frame depend on; what is looked at around them is of these.
std::array<int64_t, 2> inside_of(const Tables::Axis& axis, int64_t begin, int64_t end) {
  std::array<int64_t, 2> found = axis.inside[begin];
  for (int64_t i = begin; i < end; ++i)
    found = {std::min(found[0], axis.inside[i][0]), std::max(found[1], axis.inside[i][1])};
  return found;
}

Region seen_by(const Tables& tables, const Region& made) {
  Region seen;
  if (made.empty()) return seen;
  for (size_t a = 0; a < 3; ++a) {
    const std::array<int64_t, 2> inside = inside_of(tables.axis[a], made.begin[a], made.end[a]);
    seen.begin[a] = inside[0], seen.end[a] = inside[1];
  }
  return whole_cells(seen, tables.from);
}

// What is not made is not given, and the cells there are air, so that nobody looks at them.
void leave_out(const Region& made, const std::array<int64_t, 3>& n, CellRanges& cells) {
  if (made == Region{{}, n}) return;
  for (int64_t z = 0; z < cells.count()[2]; ++z)
    for (int64_t y = 0; y < cells.count()[1]; ++y)
      for (int64_t x = 0; x < cells.count()[0]; ++x) {
        const Region cell{{x * cell_edges[0], y * cell_edges[1], z * cell_edges[2]},
                          {(x + 1) * cell_edges[0], (y + 1) * cell_edges[1], (z + 1) * cell_edges[2]}};
        if (made.empty() || made.cut(cell).empty()) cells.cell[cells.index(x, y, z)] = {0, 0, false};
      }
}

// Rows that are summed, with their weights: those that are not air.
struct Sum {
  std::vector<int32_t> rows;
  std::vector<float> weights;

  void clear() { rows.clear(), weights.clear(); }
  void add(size_t row, float weight) {
    if (weight == 0) return;
    rows.push_back(static_cast<int32_t>(row)), weights.push_back(weight);
  }
  void write(const float* from, size_t pitch, float* to) const {
    tile_pass_z(from, pitch, {static_cast<int>(rows.size()), 1, weights.data(), rows.data()}, to);
  }
};

// What all threads read.
struct Job {
  const Tables& tables;
  const Frame& frame;
  const CellRanges& cells;
  float ringing;
  float pivot;       // what samples are filtered as their difference from
  Region made, seen; // of the halved frame, and of the frame
  HalvedFrame& out;

  // Bricks along x of what is made.
  [[nodiscard]] size_t first_brick() const { return made.begin[0] / run; }
  [[nodiscard]] size_t end_brick() const { return (made.end[0] + run - 1) / run; }

  // Samples along x of a row of cells that are not air.
  [[nodiscard]] std::array<int64_t, 2> span(int64_t cy, int64_t cz) const {
    std::array<int64_t, 2> found{INT64_MAX, 0};
    for (int64_t cx = 0; cx < cells.count()[0]; ++cx)
      if (!cells.cell[cells.index(cx, cy, cz)].air())
        found = {std::min(found[0], cx * cell_edges[0]), std::min((cx + 1) * cell_edges[0], tables.from[0])};
    return found;
  }
  [[nodiscard]] int64_t planes_held() const {
    int64_t most = 1;
    for (const auto& inside : tables.axis[2].inside) most = std::max(most, inside[1] - inside[0]);
    return most;
  }
};

// Halves a stretch of planes.
class Pass {
 public:
  explicit Pass(const Job& job)
      : job_(job), pitch_(padded(job.tables.to[0])), row_(padded(job.tables.from[0])),
        planes_(job.planes_held()), rows_(cell_edges[1] * row_ + 32), filtered_(ny() * pitch_),
        extended_((job.tables.row_end - job.tables.row_begin) + row_ + 64), sum_row_(pitch_),
        empty_rows_(ny()), ring_(planes_ * my() * pitch_), empty_(planes_ * my()),
        words_(static_cast<size_t>(job.tables.from[0]) / 64 + 2), plane_bits_(ny() * words_),
        held_bits_(empty_.size() * words_), near_(words_) {}

  static uint64_t bytes(const Job& job) {
    const Tables& t = job.tables;
    const uint64_t pitch = padded(t.to[0]), row = padded(t.from[0]);
    const uint64_t planes = job.planes_held();
    return sizeof(float) * (10 * row + (t.from[1] + planes * t.to[1]) * pitch);
  }

  // Planes begin .. end - 1 of what is made; begin at the edge of a cell.
  void make(int64_t begin, int64_t end, const Context& context) {
    const auto& inside = job_.tables.axis[2].inside;
    int64_t next = inside[begin][0];
    for (int64_t k = begin; k < end; ++k) {
      context.progress.check();
      for (; next < inside[k][1]; ++next) filter_plane(next);
      if ((k - begin) % cell_edges[2] == 0) find_ranges(k);
      for (int64_t j = job_.made.begin[1]; j < job_.made.end[1]; ++j) sum_row(j, k);
    }
  }

 private:
  [[nodiscard]] size_t ny() const { return job_.tables.from[1]; }
  [[nodiscard]] size_t my() const { return job_.tables.to[1]; }
  [[nodiscard]] size_t held(int64_t z) const { return (z % planes_) * my(); }

  // A plane of the source along x, then along y into the ring.
  void filter_plane(int64_t z) {
    const Tables& t = job_.tables;
    std::fill(plane_bits_.begin(), plane_bits_.end(), uint64_t{0});
    for (int64_t y = job_.seen.begin[1]; y < job_.seen.end[1]; y += cell_edges[1]) {
      const int64_t end = std::min(y + cell_edges[1], t.from[1]);
      const auto [low, high] = job_.span(y / cell_edges[1], z / cell_edges[2]);
      std::fill(empty_rows_.begin() + y, empty_rows_.begin() + end, low >= high);
      if (low < high) filter_rows({{low, y, z}, {high, end, z + 1}});
    }
    const Tables::Axis& axis = t.axis[1];
    const size_t taps = axis.table.taps;
    for (size_t j = job_.made.begin[1]; j < static_cast<size_t>(job_.made.end[1]); ++j) {
      sum_.clear();
      for (size_t k = j * taps; k < (j + 1) * taps; ++k)
        if (const size_t y = axis.sample[k]; !empty_rows_[y]) sum_.add(y, axis.table.weight[k]);
      empty_[held(z) + j] = sum_.rows.empty();
      if (!sum_.rows.empty()) sum_.write(filtered_.data(), pitch_, ring_.data() + (held(z) + j) * pitch_);
      join(axis, j, t.from[1], &held_bits_[(held(z) + j) * words_],
           [&](int64_t y) { return &plane_bits_[y * words_]; });
    }
  }

  // Joins the bits of all rows that are around a sample along an axis of n. row: the bits of one.
  template<class Row>
  void join(const Tables::Axis& axis, size_t sample, int64_t n, uint64_t* to, const Row& row) const {
    std::fill_n(to, words_, uint64_t{0});
    for (int64_t i = axis.near[sample][0]; i <= axis.near[sample][1]; ++i) {
      const uint64_t* from = row(end_index(i, n, axis.turns));
      for (size_t w = 0; w < words_; ++w) to[w] |= from[w];
    }
  }

  // Returns which of sixteen samples of a row are near one that is not air, by near_.
  [[nodiscard]] uint16_t near_bits(size_t brick) const {
    const Tables::Axis& axis = job_.tables.axis[0];
    const int64_t n = job_.tables.from[0];
    const auto any = [&](int64_t first, int64_t last) {
      return first <= last &&
             TileBits::any(near_.data(), {static_cast<size_t>(first), static_cast<size_t>(last)});
    };
    uint32_t found = 0;
    for (size_t i = 0; i < run && brick * run + i < axis.near.size(); ++i) {
      const auto& [first, last] = axis.near[brick * run + i];
      const bool here = any(std::max<int64_t>(first, 0), std::min(last, n - 1)) ||
                        any(std::max(first + n, int64_t{0}), n - 1) || any(0, last - n);
      found |= static_cast<uint32_t>(here) << i;
    }
    return static_cast<uint16_t>(found);
  }

  // Some rows of a plane along x; what is beyond their region is air.
  void filter_rows(const Region& region) {
    const Tables& t = job_.tables;
    std::fill(rows_.begin(), rows_.end(), 0.0f);
    const int64_t pitch = row_;
    job_.frame.read(job_.frame.boxes_in(region), region, rows_.data() + region.begin[0], pitch,
                    pitch * cell_edges[1]);
    if (job_.pivot != 0) // then nothing is air
      for (float& v : rows_) v -= job_.pivot;
    for (int64_t y = region.begin[1]; y < region.end[1]; ++y)
      nonzero_bits(rows_.data() + (y - region.begin[1]) * row_, job_.tables.from[0],
                   &plane_bits_[y * words_]);
    constexpr float one = 1;
    constexpr int32_t first = 0;
    const TileRow row{t.row_begin, t.row_end, 0, t.from[0], t.from[0], t.axis[0].turns};
    for (int64_t y = region.begin[1]; y < region.end[1]; ++y) {
      float* out = filtered_.data() + y * pitch_;
      bricks_.clear();
      for (size_t b = job_.first_brick(); b < job_.end_brick(); ++b) {
        const Tables::BrickX& brick = t.x[b];
        if (brick.inside[0] < region.end[0] && brick.inside[1] > region.begin[0])
          bricks_.push_back(
              {brick.weight.data(), brick.index.data(), brick.base - t.row_begin, out + b * run});
        else
          std::fill_n(out + b * run, run, 0.0f);
      }
      tile_pass_yx(rows_.data() + (y - region.begin[1]) * row_, row_, 1, {1, 1, &one, &first}, row,
                   t.axis[0].table.taps, bricks_, 0, extended_.data());
    }
  }

  // The ranges of what the next cells of the halved frame are made of.
  void find_ranges(int64_t k) {
    const Tables& t = job_.tables;
    const auto reach = [&](size_t a, int64_t begin) {
      return inside_of(t.axis[a], begin, std::min(begin + cell_edges[a], t.to[a]));
    };
    const auto z = reach(2, k);
    ranges_.clear();
    for (int64_t j = job_.made.begin[1]; j < job_.made.end[1]; j += cell_edges[1]) {
      const auto y = reach(1, j);
      for (size_t b = job_.first_brick(); b < job_.end_brick(); ++b) {
        const auto& x = t.x[b].inside;
        ranges_.push_back(job_.cells.range({{x[0], y[0], z[0]}, {x[1], y[1], z[1]}}));
      }
    }
  }

  // A row of the halved frame, along z out of the ring.
  void sum_row(int64_t j, int64_t k) {
    const Tables& t = job_.tables;
    const Tables::Axis& axis = t.axis[2];
    const size_t row = j, taps = axis.table.taps;
    sum_.clear();
    for (size_t i = k * taps; i < (static_cast<size_t>(k) + 1) * taps; ++i)
      if (const size_t at = held(axis.sample[i]) + row; !empty_[at]) sum_.add(at, axis.table.weight[i]);
    const Region& made = job_.made;
    const int64_t width = made.length(0), out_row = (k - made.begin[2]) * made.length(1) + j - made.begin[1];
    float* out = job_.out.values.data() + out_row * width;
    const size_t cell_row = job_.out.cells.index(0, j / cell_edges[1], k / cell_edges[2]);
    CellRanges::Cell* cells = &job_.out.cells.cell[cell_row];
    if (sum_.rows.empty()) {
      std::fill_n(out, width, 0.0f);
      for (size_t b = job_.first_brick(); b < job_.end_brick(); ++b) widen(cells[b], 0, 0);
      return;
    }
    sum_.write(ring_.data(), pitch_, sum_row_.data());
    const size_t first = job_.first_brick(), bricks = job_.end_brick() - first;
    const CellRanges::Cell* ranges = &ranges_[(j - made.begin[1]) / cell_edges[1] * bricks];
    join(axis, k, t.from[2], near_.data(), [&](int64_t z) { return &held_bits_[(held(z) + row) * words_]; });
    for (size_t i = 0; i < bricks; ++i) {
      const size_t b = first + i;
      finish_run(sum_row_.data() + b * run, ranges[i], job_.ringing > 0 ? near_bits(b) : uint16_t{0xffff},
                 std::min(run, width - static_cast<int64_t>(i) * run), out + i * run, cells[b]);
    }
  }

  static void widen(CellRanges::Cell& cell, float low, float high) {
    cell.low = std::min(cell.low, low), cell.high = std::max(cell.high, high);
  }

  // Sixteen samples of a row: constants stay what they are, and ringing in air is air.
  void finish_run(float* from, const CellRanges::Cell& range, uint16_t near, size_t count, float* out,
                  CellRanges::Cell& cell) const {
    if (!range.broken && range.low == range.high) {
      std::fill_n(from, run, range.low);
    } else if (!range.broken && (range.low > 0 || range.high < 0)) {
      for (int64_t x = 0; x < run; ++x) from[x] += job_.pivot;
    } else {
      const float limit = job_.ringing * std::max({0.0f, -range.low, range.high});
      for (int64_t x = 0; x < run; ++x)
        if ((near >> x & 1) == 0 || std::fabs(from[x]) <= limit) from[x] = 0;
    }
    std::copy_n(from, count, out);
    std::array<float, run> low, high;
    for (size_t x = 0; x < run; ++x) low[x] = high[x] = from[x < count ? x : 0];
    for (size_t n = run / 2; n > 0; n /= 2)
      for (size_t x = 0; x < n; ++x)
        low[x] = std::min(low[x], low[x + n]), high[x] = std::max(high[x], high[x + n]);
    widen(cell, low[0], high[0]);
  }

  const Job& job_;
  size_t pitch_, row_; // floats of a row of the halved frame and of the source
  int64_t planes_;     // of the ring
  std::vector<float> rows_, filtered_, extended_, sum_row_;
  std::vector<uint8_t> empty_rows_;
  std::vector<float> ring_;
  std::vector<uint8_t> empty_;                          // rows of the ring
  size_t words_;                                        // of the bits of a row; the last one is 0
  std::vector<uint64_t> plane_bits_, held_bits_, near_; // of a plane's rows, of the ring's, of a row's sites
  std::vector<CellRanges::Cell> ranges_; // of what a row of cells of the halved frame is made of
  std::vector<TileBrickX> bricks_;
  Sum sum_;
};

// Returns what to filter the differences from: the weights sum to 1, and floats would lose what varies little
// around a large value.
float pivot_of(const CellRanges& cells) {
  CellRanges::Cell all;
  for (const CellRanges::Cell& c : cells.cell) {
    if (c.broken) return 0;
    all.low = std::min(all.low, c.low), all.high = std::max(all.high, c.high);
  }
  if (all.low > 0 && all.high <= 2 * all.low) return all.low;
  if (all.high < 0 && all.low >= 2 * all.high) return all.high;
  return 0;
}

} // namespace

FrameHalver::FrameHalver(const std::array<int64_t, 3>& dims, const AxisFlags& halved,
                         const AxisFlags& predicted, const AxisFlags& turning, bool local)
    : from_(dims), predicted_(predicted), local_(local),
      grid_(grid_of(dims, halved, turning)), made_{{}, this->dims()} {}

std::array<int64_t, 3> FrameHalver::dims() const {
  const Int3 n = grid_.space.dims(0);
  std::array<int64_t, 3> dims;
  for (size_t a = 0; a < 3; ++a) dims[a] = from_[a] == 1 ? 1 : n[a];
  return dims;
}

const Tables& FrameHalver::tables_of(const FaceLevels& faces) {
  const auto [found, is_new] = tables_.try_emplace(faces);
  Tables& t = found->second;
  if (!is_new) return t;
  t.from = from_, t.to = dims();
  for (size_t a = 0; a < 3; ++a) t.axis[a] = axis_of(grid_, a, predicted_[a], end_noises[faces[a]]);
  add_bricks(t);
  return t;
}

Region FrameHalver::seen() { return seen_by(tables_of(usual_face_levels), made_); }

HalvedFrame FrameHalver::halve(const Frame& frame, const CellRanges& cells, const FaceLevels& faces,
                               float ringing, const Context& context) {
  const Tables& tables = tables_of(faces);
  const std::array<int64_t, 3>& n = tables.to;
  HalvedFrame out;
  const std::array<int64_t, 3> made{made_.length(0), made_.length(1), made_.length(2)};
  const uint64_t samples = checked_product(
      {static_cast<uint64_t>(made[0]), static_cast<uint64_t>(made[1]), static_cast<uint64_t>(made[2])});
  out.memory = Reservation(context.memory, checked_mul(samples, sizeof(float)) + samples / 64,
                           "a frame that coarser levels are made of");
  out.values.resize(samples);
  out.cells = CellRanges(n);
  const float pivot = local_ ? 0 : pivot_of(cells);
  const Job job{tables, frame, cells, ringing, pivot, made_, seen_by(tables, made_), out};
  // Stretches of whole cells; each filters the planes around it anew.
  const int64_t stretch = std::max<int64_t>(made[2] / context.tasks.threads() / 8 + 1, 2) * cell_edges[2];
  context.tasks.parallel_for((made[2] + stretch - 1) / stretch, [&](uint64_t i) {
    const Reservation memory(context.memory, Pass::bytes(job), "halving a frame");
    const int64_t begin = made_.begin[2] + static_cast<int64_t>(i) * stretch;
    Pass(job).make(begin, std::min(begin + stretch, made_.end[2]), context);
  });
  leave_out(made_, n, out.cells);
  const FrameBox box{out.values.data(), SourceType::f32, made_.begin, made, {0, 0, 0}};
  out.frame.emplace(std::span(&box, 1), n, 0.0f, "a halved frame");
  out.frame->set_given(made_);
  return out;
}

} // namespace bccsplat
