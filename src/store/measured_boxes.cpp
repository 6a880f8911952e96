// SPDX-License-Identifier: Apache-2.0
// Divides the frame into cells, looks at some planes of it for what they have, and picks.
#include "store/measured_boxes.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {
namespace {

constexpr int wanted_boxes = 6;        // of a frame
constexpr size_t fewest_cells = 12;    // of a frame that is not taken whole
constexpr int cell_bricks = 2;         // along an axis, or one more
constexpr int kernel_sites = 4;        // a kernel takes at most so many in a row
constexpr int64_t planes_apart = 8;    // of those that are looked at
constexpr int64_t rows_apart = 2;      // likewise
constexpr double golden = 0.618033989; // the fractions of its multiples are spread evenly
constexpr double even_share = 0.05;    // of the picks: anywhere

// How an axis is divided.
struct CellAxis {
  struct Cell {
    int first_brick = 0, end_brick = 0;
    int64_t begin = 0, end = 0; // the samples of its box
  };
  std::vector<Cell> cells;

  CellAxis(const Lattice4& lattice, size_t axis) {
    const int sites = lattice.space.dims(0)[axis], bricks = (sites + brick_edge - 1) / brick_edge;
    const int count = std::max(1, (2 * sites + cell_bricks * brick_edge) / (2 * cell_bricks * brick_edge));
    const int64_t n = lattice.dims[axis];
    // The first sample at or behind a site.
    const auto sample = [&](int site) {
      const double position = lattice.plane_position(axis, lattice.space.plane(0, site));
      return std::clamp(static_cast<int64_t>(std::ceil(position)), int64_t{0}, n);
    };
    for (int i = 0; i < count; ++i) {
      Cell c;
      c.first_brick = bricks * i / count, c.end_brick = bricks * (i + 1) / count;
      c.begin = i == 0 ? 0 : sample(c.first_brick * brick_edge + kernel_sites);
      c.end = i + 1 == count ? n : sample(c.end_brick * brick_edge - kernel_sites);
      cells.push_back(c);
    }
  }
  // The number of the box that a sample is in, or `between`.
  static constexpr size_t between = SIZE_MAX;
  [[nodiscard]] std::vector<size_t> numbers(int64_t samples) const {
    std::vector<size_t> of(static_cast<size_t>(samples), between);
    for (size_t i = 0; i < cells.size(); ++i)
      for (int64_t s = cells[i].begin; s < cells[i].end; ++s) of[static_cast<size_t>(s)] = i;
    return of;
  }
};

// What was seen of samples, or the part of it that a box has.
struct Content {
  double bends = 0, filled = 0, samples = 0;
};

struct Cell {
  MeasuredBox box;
  Content content;
  double probability = 0; // to be the next one that is picked
  double times = 0;       // what is in the box, so often
};

// Sums over a frame and over its boxes, from three planes at a time.
class ContentSums {
 public:
  ContentSums(const std::array<CellAxis, 3>& axes, const std::array<int64_t, 3>& n, std::vector<Cell>& cells)
      : x_(axes[0].numbers(n[0])), y_(axes[1].numbers(n[1])), z_(axes[2].numbers(n[2])), n_(n),
        row_cells_(axes[0].cells.size()), plane_cells_(row_cells_ * axes[1].cells.size()), cells_(cells) {}

  void look_at(const Frame& frame) {
    for (auto& p : planes_) p.resize(static_cast<size_t>(n_[0] * n_[1]));
    for (int64_t z = std::min(planes_apart, n_[2]) / 2; z < n_[2]; z += planes_apart) {
      for (int64_t i = 0; i < 3; ++i) {
        const int64_t at = std::clamp<int64_t>(z + i - 1, 0, n_[2] - 1);
        const Region plane{{0, 0, at}, {n_[0], n_[1], at + 1}};
        frame.read(frame.boxes_in(plane), plane, planes_[static_cast<size_t>(i)].data(), n_[0],
                   n_[0] * n_[1]);
      }
      for (int64_t y = 0; y < n_[1]; y += rows_apart) add_row(y, z);
    }
  }
  [[nodiscard]] const Content& frame() const { return frame_; }

 private:
  void add_row(int64_t y, int64_t z) {
    const int64_t nx = n_[0], up = y > 0 ? -nx : 0, down = y + 1 < n_[1] ? nx : 0;
    const float* const here = planes_[1].data() + y * nx;
    const float* const above = planes_[0].data() + y * nx;
    const float* const below = planes_[2].data() + y * nx;
    const size_t cell_y = y_[static_cast<size_t>(y)], cell_z = z_[static_cast<size_t>(z)];
    const bool in_boxes = cell_y != CellAxis::between && cell_z != CellAxis::between;
    const size_t row = in_boxes ? cell_z * plane_cells_ + cell_y * row_cells_ : 0;
    for (int64_t x = 0; x < nx; ++x) {
      const float v = here[x];
      const float along = here[std::max<int64_t>(x - 1, 0)] + here[std::min(x + 1, nx - 1)] - 2 * v;
      const float across = here[x + up] + here[x + down] - 2 * v, depth = above[x] + below[x] - 2 * v;
      const float bend = along * along + across * across + depth * depth;
      const Content seen{std::isfinite(bend) ? static_cast<double>(bend) : 0, v != 0 ? 1.0 : 0.0, 1};
      add(seen, frame_);
      const size_t cell_x = x_[static_cast<size_t>(x)];
      if (in_boxes && cell_x != CellAxis::between) add(seen, cells_[row + cell_x].content);
    }
  }
  static void add(const Content& seen, Content& to) {
    to.bends += seen.bends, to.filled += seen.filled, to.samples += seen.samples;
  }

  std::vector<size_t> x_, y_, z_; // numbers of boxes along each axis
  std::array<int64_t, 3> n_;
  size_t row_cells_, plane_cells_;
  std::vector<Cell>& cells_;
  std::array<std::vector<float>, 3> planes_;
  Content frame_;
};

std::vector<Cell> cells_of(const Lattice4& lattice, const std::array<CellAxis, 3>& axes) {
  std::vector<Cell> cells;
  for (const CellAxis::Cell& z : axes[2].cells)
    for (const CellAxis::Cell& y : axes[1].cells)
      for (const CellAxis::Cell& x : axes[0].cells) {
        const std::array<const CellAxis::Cell*, 3> along{&x, &y, &z};
        MeasuredBox& box = cells.emplace_back().box;
        for (size_t a = 0; a < 3; ++a) {
          const CellAxis::Cell& c = *along[a];
          box.samples.begin[a] = c.begin, box.samples.end[a] = c.end;
          box.bricks.begin[a] = c.first_brick, box.bricks.end[a] = c.end_brick;
        }
        box.bricks = go_round(box.bricks, lattice.space);
      }
  return cells;
}

// Makes what the boxes have parts of what the frame has.
void make_parts(const Content& frame, std::vector<Cell>& cells) {
  for (double Content::*kind : {&Content::bends, &Content::filled, &Content::samples})
    for (Cell& c : cells) c.content.*kind = frame.*kind > 0 ? c.content.*kind / (frame.*kind) : 0;
}

void find_probabilities(std::vector<Cell>& cells) {
  double sum = 0;
  for (Cell& c : cells) {
    const Content& in = c.content;
    c.probability = (1 - even_share) / 2 * (in.bends + in.filled) + even_share * in.samples;
    sum += c.probability;
  }
  for (Cell& c : cells) c.probability = sum > 0 ? c.probability / sum : 1 / static_cast<double>(cells.size());
}

// In even steps, the first one `offset` of a step behind the beginning.
std::vector<Cell> pick_cells(const std::vector<Cell>& cells, double offset) {
  std::vector<Cell> picks;
  double sum = 0;
  int taken = 0;
  for (const Cell& c : cells) {
    sum += c.probability;
    int times = 0;
    for (; taken < wanted_boxes && (taken + offset) / wanted_boxes < sum; ++taken) ++times;
    if (times == 0) continue;
    picks.push_back(c);
    picks.back().times = times / (wanted_boxes * c.probability);
  }
  return picks;
}

// Changes what the picks stand for so that together they have what the frame has (calibration; Deville &
// Sarndal 1992, with the exponential distance).
void calibrate(std::vector<Cell>& picks) {
  constexpr int rounds = 50;
  const auto fit = [&](double Content::*kind) {
    double sum = 0, slope = 0;
    for (const Cell& c : picks) {
      const double part = c.content.*kind;
      sum += c.times * part, slope += c.times * part * part;
    }
    if (!(slope > 0)) return;
    const auto count = static_cast<double>(picks.size());
    const double step = std::clamp((1 - sum) / (count * slope), -0.5, 0.5) / 2;
    for (Cell& c : picks) c.times *= std::exp(step * count * (c.content.*kind));
  };
  for (int i = 0; i < rounds; ++i) fit(&Content::bends), fit(&Content::filled);
}

} // namespace

MeasuredBox whole_frame(const Lattice4& lattice) {
  MeasuredBox box;
  for (size_t a = 0; a < 3; ++a) box.samples.end[a] = lattice.dims[a];
  return box;
}

std::vector<MeasuredBox> choose_measured_boxes(const Lattice4& lattice, uint32_t frame,
                                               std::span<const FrameBox> boxes, float air) {
  const std::array<CellAxis, 3> axes{CellAxis(lattice, 0), CellAxis(lattice, 1), CellAxis(lattice, 2)};
  std::vector<Cell> cells = cells_of(lattice, axes);
  if (cells.size() < fewest_cells) return {whole_frame(lattice)};
  const std::array<int64_t, 3> n{lattice.dims[0], lattice.dims[1], lattice.dims[2]};
  ContentSums sums(axes, n, cells);
  sums.look_at(Frame(boxes, n, air, "a frame to be measured"));
  make_parts(sums.frame(), cells);
  find_probabilities(cells);
  std::vector<Cell> picks = pick_cells(cells, std::fmod(golden * (frame + 1.0), 1.0));
  calibrate(picks);
  std::vector<MeasuredBox> chosen;
  for (const Cell& c : picks) {
    chosen.push_back(c.box);
    chosen.back().weight = c.times * c.content.samples;
  }
  return chosen;
}

void BoxErrors::Mean::add(const ErrorSum& errors, double times) {
  squares += times * errors.squares, count += times * static_cast<double>(errors.count);
}

double BoxErrors::Mean::squares_of(uint64_t samples) const {
  return count > 0 ? squares / count * static_cast<double>(samples) : 0;
}

void BoxErrors::add(const SampleErrors& errors, double weight) {
  sum_.add(errors);
  const auto mean = [](const ErrorSum& e) {
    return e.count > 0 ? e.squares / static_cast<double>(e.count) : 0;
  };
  squares_ += weight * mean(errors.all), bare_ += weight * mean(errors.bare);
  if (errors.all.count > 0) non_air_.add(errors.non_air, weight / static_cast<double>(errors.all.count));
}

SampleErrors BoxErrors::of_frame() const {
  SampleErrors e = sum_;
  e.all.squares = squares_ * static_cast<double>(e.all.count);
  e.bare.squares = bare_ * static_cast<double>(e.bare.count);
  e.non_air.squares = non_air_.squares_of(e.non_air.count);
  return e;
}

} // namespace bccsplat
