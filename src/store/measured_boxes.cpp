// SPDX-License-Identifier: Apache-2.0
// Divides the frame into cells, looks at some planes of it for what they have, and picks.
#include "store/measured_boxes.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <iterator>
#include <optional>
#include <tuple>
#include <utility>

namespace bccsplat {
namespace {

constexpr size_t cells_a_box = 5;      // between the fewest and the most boxes
constexpr int64_t rows_apart = 2;      // of a plane, those that are looked at for bends
constexpr double golden = 0.618033989; // the fractions of its multiples are spread evenly
constexpr double even_share = 0.05;    // of the picks: anywhere

int bricks_along(const Lattice4& lattice, size_t axis) {
  return (lattice.space.dims(0)[axis] + brick_edge - 1) / brick_edge;
}

// The samples, begin and end, around which a kernel stays within these bricks.
std::pair<int64_t, int64_t> samples_inside(const Lattice4& lattice, size_t axis, int first_brick,
                                           int end_brick) {
  const int64_t n = lattice.dims[axis];
  // The first sample at or behind a site.
  const auto sample = [&](int site) {
    const double position = lattice.plane_position(axis, lattice.space.plane(0, site));
    return std::clamp(static_cast<int64_t>(std::ceil(position)), int64_t{0}, n);
  };
  return {first_brick == 0 ? 0 : sample(first_brick * brick_edge + kernel_sites),
          end_brick >= bricks_along(lattice, axis) ? n : sample(end_brick * brick_edge - kernel_sites)};
}

// How an axis is divided.
struct CellAxis {
  struct Cell {
    int first_brick = 0, end_brick = 0;
    int64_t begin = 0, end = 0; // the samples of its box
  };
  std::vector<Cell> cells;

  // edge: bricks of a cell, or one more; later: all cells but the first begin so many bricks later than they
  // do by themselves.
  CellAxis(const Lattice4& lattice, size_t axis, int edge, int later) {
    const int sites = lattice.space.dims(0)[axis], bricks = bricks_along(lattice, axis);
    const int count = std::max(1, (2 * sites + edge * brick_edge) / (2 * edge * brick_edge));
    for (int i = 0; i < count; ++i) {
      const auto boundary = [&](int at) {
        return std::min(bricks * at / count + (at > 0 ? later : 0), bricks);
      };
      Cell c;
      c.first_brick = boundary(i), c.end_brick = boundary(i + 1);
      std::tie(c.begin, c.end) = samples_inside(lattice, axis, c.first_brick, c.end_brick);
      cells.push_back(c);
    }
  }
  // The number of the box that a sample is in; none: it is between boxes.
  [[nodiscard]] std::optional<size_t> box_of(int64_t sample) const {
    for (size_t i = 0; i < cells.size(); ++i)
      if (sample >= cells[i].begin && sample < cells[i].end) return i;
    return std::nullopt;
  }
};

// What was seen of samples, or the part of it that a box has.
struct Content {
  double bends = 0, changes = 0, filled = 0, samples = 0;
};

struct Cell {
  MeasuredBox box;
  Content content;
  double probability = 0; // to be the next one that is picked
  double times = 0;       // what is in the box, so often
};

// A frame cut into cells.
struct Division {
  std::array<CellAxis, 3> axes;
  std::vector<Cell> cells; // x fastest

  Division(const Lattice4& lattice, int edge, int later)
      : axes{CellAxis(lattice, 0, edge, later), CellAxis(lattice, 1, edge, later),
             CellAxis(lattice, 2, edge, later)} {
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
  }
  // The cells whose boxes have a row; none where it is between boxes.
  [[nodiscard]] std::span<Cell> cells_of_row(int64_t y, int64_t z) {
    const std::optional<size_t> iy = axes[1].box_of(y), iz = axes[2].box_of(z);
    if (!iy || !iz) return {};
    const size_t row = axes[0].cells.size();
    return std::span(cells).subspan((*iz * axes[1].cells.size() + *iy) * row, row);
  }
};

// Sums over a frame and over the boxes of its divisions, from some of its planes.
class ContentSums {
 public:
  // planes_apart: of those that are looked at for bends.
  ContentSums(const std::array<int64_t, 3>& n, int64_t planes_apart, std::vector<Division>& divisions)
      : n_(n), planes_apart_(planes_apart), divisions_(divisions), bends_(static_cast<size_t>(n[0])),
        filled_(static_cast<size_t>(n[0])) {}

  void look_at(const Frame& frame) {
    for (auto& p : planes_) p.resize(n_[0] * n_[1]);
    for (int64_t z = SeenPlanes{planes_apart_, n_[2]}.first(); z < n_[2]; z += planes_apart_) {
      const Region around{{0, 0, std::max<int64_t>(z - 1, 0)}, {n_[0], n_[1], std::min(z + 2, n_[2])}};
      if (frame.boxes_in(around).empty()) { // of parts far apart most planes have none
        for (int64_t y = 0; y < n_[1]; y += rows_apart) add_air(y, z);
        continue;
      }
      for (int64_t i = 0; i < 3; ++i)
        read_plane(frame, std::clamp<int64_t>(z + i - 1, 0, n_[2] - 1), planes_[i]);
      for (int64_t y = 0; y < n_[1]; y += rows_apart) add_row(y, z);
    }
  }
  void look_at_changes(const Frame& frame, EarlierFrames& earlier) {
    constexpr int64_t apart = EarlierFrames::planes_apart;
    for (int64_t z = SeenPlanes{apart, n_[2]}.first(); z < n_[2]; z += apart) {
      read_plane(frame, z, planes_[1]);
      const std::span<const float> expected = earlier.expect(z);
      for (int64_t y = 0; y < n_[1]; ++y) add_changes(y, z, expected.data() + y * n_[0]);
    }
  }
  [[nodiscard]] const Content& frame() const { return frame_; }

 private:
  void read_plane(const Frame& frame, int64_t z, std::vector<float>& to) const {
    const Region plane{{0, 0, z}, {n_[0], n_[1], z + 1}};
    frame.read(frame.boxes_in(plane), plane, to.data(), n_[0], n_[0] * n_[1]);
  }
  void add_row(int64_t y, int64_t z) {
    const int64_t nx = n_[0], up = y > 0 ? -nx : 0, down = y + 1 < n_[1] ? nx : 0;
    const float* const here = planes_[1].data() + y * nx;
    const float* const above = planes_[0].data() + y * nx;
    const float* const below = planes_[2].data() + y * nx;
    const auto add = [&](int64_t x, int64_t west, int64_t east) {
      const float v = here[x];
      const float along = here[west] + here[east] - 2 * v;
      const float across = here[x + up] + here[x + down] - 2 * v, depth = above[x] + below[x] - 2 * v;
      const size_t i = x;
      bends_[i] = finite(along * along + across * across + depth * depth), filled_[i] = v != 0 ? 1.0f : 0.0f;
    };
    add(0, 0, std::min<int64_t>(1, nx - 1));
    for (int64_t x = 1; x + 1 < nx; ++x) add(x, x - 1, x + 1);
    add(nx - 1, std::max<int64_t>(nx - 2, 0), nx - 1);
    add_to_cells(y, z, [&](const Samples& in, Content& to) {
      to.bends += sum(bends_, in), to.filled += sum(filled_, in);
      to.samples += static_cast<double>(in.end - in.begin);
    });
  }
  void add_air(int64_t y, int64_t z) {
    add_to_cells(
        y, z, [](const Samples& in, Content& to) { to.samples += static_cast<double>(in.end - in.begin); });
  }
  // Adds what differs in a row from what is expected of it.
  void add_changes(int64_t y, int64_t z, const float* expected) {
    const float* const here = planes_[1].data() + y * n_[0];
    for (size_t x = 0; x < bends_.size(); ++x) {
      const float change = here[x] - expected[x];
      bends_[x] = finite(change * change);
    }
    add_to_cells(y, z, [&](const Samples& in, Content& to) { to.changes += sum(bends_, in); });
  }

  // Samples of a row.
  struct Samples {
    int64_t begin, end;
  };
  // Calls add(samples, content) for all of a row, and for what each box has of it.
  template<class Add> void add_to_cells(int64_t y, int64_t z, const Add& add) {
    add({0, n_[0]}, frame_);
    for (Division& d : divisions_)
      for (Cell& c : d.cells_of_row(y, z)) add({c.box.samples.begin[0], c.box.samples.end[0]}, c.content);
  }
  static float finite(float v) { return v <= FLT_MAX ? v : 0; }
  // Sums in eight parts, which the compiler makes side by side.
  static double sum(const std::vector<float>& values, const Samples& in) {
    std::array<double, 8> sums{};
    int64_t x = in.begin;
    for (; x + 8 <= in.end; x += 8)
      for (int64_t i = 0; i < 8; ++i) sums[i] += values[x + i];
    for (; x < in.end; ++x) sums[0] += values[x];
    return ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
  }

  std::array<int64_t, 3> n_;
  int64_t planes_apart_;
  std::vector<Division>& divisions_;
  std::array<std::vector<float>, 3> planes_;
  std::vector<float> bends_, filled_; // of a row
  Content frame_;
};

[[nodiscard]] bool is_thin(const Region& box, int64_t least_edge) {
  return std::min({box.length(0), box.length(1), box.length(2)}) < least_edge;
}

// Makes what the boxes have parts of what the frame has.
void make_parts(const Content& frame, std::vector<Cell>& cells) {
  for (double Content::*kind : {&Content::bends, &Content::changes, &Content::filled, &Content::samples})
    for (Cell& c : cells) c.content.*kind = frame.*kind > 0 ? c.content.*kind / (frame.*kind) : 0;
}

void find_probabilities(std::vector<Cell>& cells) {
  double sum = 0;
  for (Cell& c : cells) {
    const Content& in = c.content;
    c.probability = (1 - even_share) / 3 * (in.bends + in.changes + in.filled) + even_share * in.samples;
    sum += c.probability;
  }
  for (Cell& c : cells) c.probability = sum > 0 ? c.probability / sum : 1 / static_cast<double>(cells.size());
}

// In even steps, the first one `offset` of a step behind the beginning. Cells stand by what part of them
// changes, so that even steps take all parts of it.
std::vector<Cell> pick_cells(std::vector<Cell> cells, double offset, size_t fewest, size_t most) {
  const auto wanted = static_cast<int>(std::clamp(cells.size() / 2 / cells_a_box, fewest, most));
  std::stable_sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) {
    return a.content.changes * b.probability < b.content.changes * a.probability;
  });
  std::vector<Cell> picks;
  double sum = 0;
  int taken = 0;
  for (const Cell& c : cells) {
    sum += c.probability;
    int times = 0;
    for (; taken < wanted && (taken + offset) / wanted < sum; ++taken) ++times;
    if (times == 0) continue;
    picks.push_back(c);
    picks.back().times = times / (wanted * c.probability);
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
  for (int i = 0; i < rounds; ++i) fit(&Content::bends), fit(&Content::changes), fit(&Content::filled);
}

} // namespace

MeasuredBox whole_frame(const Lattice4& lattice) {
  MeasuredBox box;
  for (size_t a = 0; a < 3; ++a) box.samples.end[a] = lattice.dims[a];
  return box;
}

std::vector<MeasuredBox> choose_measured_boxes(const Lattice4& lattice, uint32_t frame,
                                               std::span<const FrameBox> boxes, double air,
                                               EarlierFrames* earlier, const MeasuredCells& kind) {
  const std::array<int64_t, 3> n{lattice.dims[0], lattice.dims[1], lattice.dims[2]};
  std::vector<Division> divisions{Division(lattice, kind.bricks, 0)};
  if (divisions.front().cells.size() < kind.fewest) return {whole_frame(lattice)};
  if (kind.bricks > 1) divisions.emplace_back(lattice, kind.bricks, 1);
  const Frame samples(boxes, n, air, "a frame to be measured");
  ContentSums sums(n, kind.planes_apart, divisions);
  sums.look_at(samples);
  if (earlier && earlier->knows(frame)) sums.look_at_changes(samples, *earlier);
  std::vector<Cell> cells;
  for (const Division& d : divisions)
    std::copy_if(d.cells.begin(), d.cells.end(), std::back_inserter(cells),
                 [&](const Cell& c) { return !is_thin(c.box.samples, kind.least_edge); });
  make_parts(sums.frame(), cells);
  find_probabilities(cells);
  std::vector<Cell> picks = pick_cells(cells, std::fmod(golden * (frame + 1.0), 1.0), kind.fewest_boxes,
                                       lattice.is_static() ? kind.most_of_still : kind.most_boxes);
  calibrate(picks);
  std::vector<MeasuredBox> chosen;
  for (const Cell& c : picks) {
    chosen.push_back(c.box);
    chosen.back().weight = c.times * c.content.samples;
  }
  return chosen;
}

Region samples_inside(const Lattice4& lattice, const BrickBox& bricks) {
  Region samples;
  for (size_t a = 0; a < 3; ++a)
    std::tie(samples.begin[a], samples.end[a]) = samples_inside(lattice, a, bricks.begin[a], bricks.end[a]);
  return samples;
}

void BoxErrors::Mean::add(const ErrorSum& errors, double times) {
  squares += times * errors.squares.value(), count += times * static_cast<double>(errors.count);
}

double BoxErrors::Mean::squares_of(uint64_t samples) const {
  return count > 0 ? squares / count * static_cast<double>(samples) : 0;
}

void BoxErrors::add(const SampleErrors& errors, double weight) {
  sum_.add(errors);
  const auto mean = [](const ErrorSum& e) {
    return e.count > 0 ? e.squares.value() / static_cast<double>(e.count) : 0;
  };
  squares_ += weight * mean(errors.all), bare_ += weight * mean(errors.bare);
  if (errors.all.count > 0) non_air_.add(errors.non_air, weight / static_cast<double>(errors.all.count));
}

SampleErrors BoxErrors::of_frame() const {
  SampleErrors e = sum_;
  const auto set = [](ErrorSum& errors, double squares) {
    errors.squares = {};
    errors.squares.add(squares);
  };
  set(e.all, squares_ * static_cast<double>(e.all.count));
  set(e.bare, bare_ * static_cast<double>(e.bare.count));
  set(e.non_air, non_air_.squares_of(e.non_air.count));
  return e;
}

} // namespace bccsplat
