// SPDX-License-Identifier: Apache-2.0
// Designs the filters of the six pairs of axes and runs frames through them: pairs in space one after the
// other on a frame, pairs with time as a chain of sliding windows.
#include "fit/resample/lowpass.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/sizes.h"
#include "fit/axis/filter.h"
#include "fit/axis/lowpass_row.h"
#include "fit/frame/scan.h"
#include "fit/frame/turned_region.h"

namespace bccsplat {
namespace {

// Half width of the Kaiser windows along the diagonals in lattice units, their beta, and the edge of a pair's
// octagon, a little beyond sqrt2: a pair is within 2e-4 of 1 in the ball of half the Nyquist frequency,
// within 6e-3 in that of 0.8, and below -45 dB where |f_i| + |f_j| >= 1.8 (tests/bench/notes/fit.md).
constexpr double window = 11, beta = 6.5, edge = 1.45;
constexpr int integration = 1024;  // midpoints of the integral over an octagon
constexpr size_t rows_of_task = 8; // enough work for a task, few enough for all threads to have some

double kaiser(double u) { return std::fabs(u) >= 1 ? 0 : kaiser_window(u, beta); }

// Fourier coefficient (a, b) of the part of the square |f| <= 1 with unit[0] |f_i| + unit[1] |f_j| <= edge.
double octagon(int a, int b, const std::array<double, 2>& unit) {
  constexpr double pi = std::numbers::pi;
  const double end = std::min(1.0, edge / unit[0]);
  double sum = 0;
  for (int k = 0; k < integration; ++k) {
    const double u = end * (k + 0.5) / integration;
    const double v = std::min(1.0, (edge - unit[0] * u) / unit[1]);
    sum += std::cos(pi * u * a) * (b == 0 ? v : std::sin(pi * v * b) / (pi * b));
  }
  return sum * end / integration;
}

int32_t reach_of(double unit) { return static_cast<int32_t>(std::ceil(window * unit)) - 1; }

} // namespace

LowpassPair lowpass_pair(std::array<size_t, 2> axis, std::array<double, 2> unit) {
  LowpassPair pair;
  pair.axis = axis;
  for (size_t k = 0; k < 2; ++k) pair.reach[k] = reach_of(unit[k]);
  std::vector<double> weight;
  double sum = 0;
  for (int32_t a = 0; a <= pair.reach[0]; ++a)
    for (int32_t b = 0; b <= pair.reach[1]; ++b) {
      const double s = a / unit[0] + b / unit[1], d = a / unit[0] - b / unit[1];
      double w = kaiser(s / window) * kaiser(d / window);
      if (w == 0) continue;
      w *= octagon(a, b, unit);
      sum += w * (a == 0 ? 1 : 2) * (b == 0 ? 1 : 2);
      if (a == 0 && b == 0) continue;
      // On an axis two of the four are the same sample.
      pair.tap.push_back({a, b, 0});
      weight.push_back(w * (a == 0 || b == 0 ? 0.5 : 1));
    }
  for (size_t k = 0; k < weight.size(); ++k) pair.tap[k].weight = static_cast<float>(weight[k] / sum);
  return pair;
}

int32_t lowpass_time_reach(const Lattice4& lattice) {
  return lattice.is_static() ? 0 : 3 * reach_of(lattice.nominal_scales()[3]);
}

Lowpass::Lowpass(const Lattice4& lattice, float ringing) : ringing_(ringing) {
  if (!lattice.space.bcc) fail(Code::invalid_argument, "a low-pass is of use on D4* and BCC only");
  const LatticeScales unit = lattice.nominal_scales();
  for (size_t i = 0; i < 3; ++i) {
    n_[i] = lattice.dims[i];
    reach_[i] = reach_of(unit[i]);
    for (int64_t k = -reach_[i]; k < n_[i] + reach_[i]; ++k)
      mirror_[i].push_back(end_index(k, n_[i], lattice.turns(i)));
    for (size_t j = i + 1; j < 3; ++j) space_.push_back(lowpass_pair({i, j}, {unit[i], unit[j]}));
    if (!lattice.is_static()) {
      Stage& stage = time_.emplace_back();
      stage.pair = lowpass_pair({i, 3}, {unit[i], unit[3]});
    }
  }
  periodic_ = lattice.periodic, turning_ = lattice.space.periodic;
  if (periodic_) {
    turn_ = 2 * static_cast<size_t>(lowpass_time_reach(lattice));
    for (Stage& stage : time_) stage.next = stage.pair.reach[1];
  }
  margin_ = reach_[0];
  pitch_ = (n_[0] + 15) / 16 * 16 + 2 * margin_;
}

std::shared_ptr<LowpassFrame> Lowpass::make_frame(const Context& context) const {
  auto frame = std::make_shared<LowpassFrame>();
  const uint64_t rows = checked_product({static_cast<uint64_t>(n_[1]), static_cast<uint64_t>(n_[2])});
  const uint64_t floats = checked_mul(rows, pitch_);
  frame->memory = Reservation(context.memory, checked_mul(floats, sizeof(float)) + rows, "the low-pass");
  frame->value.assign(floats, 0.0f);
  frame->empty.assign(rows, 1);
  return frame;
}

// Margins and the mark of a row whose samples are there.
void Lowpass::close_row(LowpassFrame& frame, size_t row) const {
  float* v = frame.value.data() + row * pitch_ + margin_;
  bool empty = true;
  for (int64_t x = 0; x < n_[0]; ++x) empty = empty && v[x] == 0;
  frame.empty[row] = empty;
  for (int64_t k = 1; k <= margin_; ++k) {
    v[-k] = v[mirror_[0][reach_[0] - k]];
    v[n_[0] - 1 + k] = v[mirror_[0][reach_[0] + n_[0] - 1 + k]];
  }
}

Lowpass::FramePtr Lowpass::read(const Frame& frame, HoleMap holes, const Context& context) const {
  auto dense = make_frame(context);
  auto origin = std::make_shared<LowpassOrigin>();
  const size_t rows = dense->empty.size(), row_bytes = static_cast<size_t>(n_[0] + 7) / 8;
  origin->memory = Reservation(context.memory, rows * row_bytes, "the low-pass");
  origin->air.assign(rows * row_bytes, 0);
  origin->holes = std::move(holes);
  context.tasks.parallel_for((rows + rows_of_task - 1) / rows_of_task, [&](uint64_t task) {
    context.progress.check();
    for (size_t row = task * rows_of_task; row < std::min(rows, (task + 1) * rows_of_task); ++row) {
      const auto y = static_cast<int64_t>(row) % n_[1], z = static_cast<int64_t>(row) / n_[1];
      const Region region{{0, y, z}, {n_[0], y + 1, z + 1}};
      float* v = dense->value.data() + row * pitch_ + margin_;
      frame.read(frame.boxes_in(region), region, v, pitch_, pitch_);
      for (int64_t x = 0; x < n_[0]; ++x)
        if (v[x] == 0) origin->air[row * row_bytes + x / 8] |= static_cast<uint8_t>(1 << (x % 8));
      close_row(*dense, row);
    }
  });
  dense->origin = std::move(origin);
  return dense;
}

Lowpass::FramePtr Lowpass::apply(const LowpassPair& pair, const LowpassFrame& centre, const At& at,
                                 const Context& context) const {
  auto made = make_frame(context);
  made->origin = centre.origin;
  const auto i = pair.axis[0], j = pair.axis[1]; // names that lambdas may use
  const size_t rows = made->empty.size(), count = pair.tap.size();
  const size_t padded = (n_[0] + 15) / 16 * 16;
  std::vector<const LowpassFrame*> frames; // by distance in time + reach
  if (j == 3)
    for (int64_t t = -pair.reach[1]; t <= pair.reach[1]; ++t) frames.push_back(&at(t));
  std::vector<float> weight;
  for (const LowpassPair::Tap& tap : pair.tap) weight.push_back(tap.weight);

  context.tasks.parallel_for((rows + rows_of_task - 1) / rows_of_task, [&](uint64_t task) {
    context.progress.check();
    std::vector<const float*> q(4 * count);
    std::vector<float> out(padded);
    // Addresses are sums of what i and j contribute.
    std::vector<int64_t> along_i(static_cast<size_t>(2 * pair.reach[0] + 1));
    std::vector<const float*> along_j(static_cast<size_t>(2 * pair.reach[1] + 1));
    for (size_t row = task * rows_of_task; row < std::min(rows, (task + 1) * rows_of_task); ++row) {
      const auto y = static_cast<int64_t>(row) % n_[1], z = static_cast<int64_t>(row) / n_[1];
      const std::array<int64_t, 3> p{0, y, z}, stride{1, pitch_, pitch_ * n_[1]};
      // Along x the margins are there, other rows are mirrored.
      const auto shift = [&](size_t axis, int64_t by) {
        if (axis == 0) return by;
        return (mirror_[axis][p[axis] + by + reach_[axis]] - p[axis]) * stride[axis];
      };
      const int64_t start = static_cast<int64_t>(row) * pitch_ + margin_;
      for (int64_t a = -pair.reach[0]; a <= pair.reach[0]; ++a) along_i[a + pair.reach[0]] = shift(i, a);
      bool empty = true;
      for (int64_t b = -pair.reach[1]; b <= pair.reach[1]; ++b) {
        const size_t k = b + pair.reach[1];
        const LowpassFrame& frame = j == 3 ? *frames[k] : centre;
        const int64_t at_b = start + (j == 3 ? 0 : shift(j, b));
        along_j[k] = frame.value.data() + at_b;
        for (const int64_t by : along_i) { // x stays in the row
          if (!empty) break;
          empty = frame.empty[(at_b + (i == 0 ? 0 : by)) / pitch_];
        }
      }
      if (empty) continue; // zeros already
      const float *const *middle_j = along_j.data() + pair.reach[1], **to = q.data();
      const int64_t* middle_i = along_i.data() + pair.reach[0];
      for (const LowpassPair::Tap& tap : pair.tap) {
        *to++ = middle_j[tap.b] + middle_i[tap.a];
        *to++ = middle_j[-tap.b] + middle_i[tap.a];
        *to++ = middle_j[tap.b] + middle_i[-tap.a];
        *to++ = middle_j[-tap.b] + middle_i[-tap.a];
      }
      const float* v = centre.value.data() + row * pitch_ + margin_;
      lowpass_row(v, q.data(), weight.data(), count, padded, out.data());
      std::copy_n(out.data(), n_[0], made->value.data() + row * pitch_ + margin_);
      close_row(*made, row);
    }
  });
  return made;
}

void Lowpass::add(const Frame* frame, HoleMap holes, const Sink& sink, const Context& context) {
  if (!frame && !previous_) {
    missing_.push_back(std::move(holes));
    return;
  }
  if (frame) {
    previous_ = read(*frame, std::move(holes), context);
    for (const LowpassPair& pair : space_) previous_ = apply(pair, *previous_, {}, context);
    push_missing(sink, context);
    push_first(previous_, sink, context);
  } else
    push_first(again(*previous_, std::move(holes), context), sink, context);
}

Lowpass::FramePtr Lowpass::again(const LowpassFrame& frame, HoleMap holes, const Context& context) const {
  auto made = make_frame(context);
  made->value = frame.value;
  made->empty = frame.empty;
  auto origin = std::make_shared<LowpassOrigin>();
  if (frame.origin) origin->air = frame.origin->air;
  origin->air.resize(made->empty.size() * ((n_[0] + 7) / 8), 0xff);
  origin->memory = Reservation(context.memory, origin->air.size(), "the low-pass");
  origin->holes = std::move(holes);
  made->origin = std::move(origin);
  return made;
}

// Frames missing at the start, once it is known what they are to hold.
void Lowpass::push_missing(const Sink& sink, const Context& context) {
  for (HoleMap& holes : missing_) push_first(again(*previous_, std::move(holes), context), sink, context);
  missing_.clear();
}

void Lowpass::push_first(const FramePtr& frame, const Sink& sink, const Context& context) {
  if (head_.size() < turn_) head_.push_back(frame);
  push(0, frame, false, sink, context);
}

void Lowpass::finish(const Sink& sink, const Context& context) {
  if (!missing_.empty()) { // all of them: air
    previous_ = make_frame(context);
    push_missing(sink, context);
  }
  if (periodic_)
    for (size_t i = 0; i < turn_; ++i) push(0, head_[i % head_.size()], false, sink, context);
  else
    push(0, nullptr, true, sink, context);
  previous_ = nullptr;
  head_.clear();
}

void Lowpass::push(size_t stage, FramePtr frame, bool last, const Sink& sink, const Context& context) {
  if (stage == time_.size()) {
    if (frame) hand_out(*frame, sink, context);
    return;
  }
  Stage& s = time_[stage];
  if (frame) s.window.push_back(std::move(frame));
  const int64_t reach = s.pair.reach[1], end = s.first + static_cast<int64_t>(s.window.size());
  for (; s.next < end && (last || s.next + reach < end); ++s.next) {
    // The first frames mirror the same for any number, and the last ones are only made when it is known.
    const auto at = [&](int64_t offset) -> const LowpassFrame& {
      const int64_t number = periodic_ ? s.next + offset : mirror_index(s.next + offset, end);
      return *s.window[number - s.first];
    };
    push(stage + 1, apply(s.pair, at(0), at, context), false, sink, context);
    // What follows the last frame mirrors `reach` + 1 frames before it.
    for (; s.first < s.next - reach; ++s.first) s.window.pop_front();
  }
  if (last) push(stage + 1, nullptr, true, sink, context);
}

void Lowpass::hand_out(const LowpassFrame& filtered, const Sink& sink, const Context& context) const {
  FrameBox box;
  box.type = SourceType::f32;
  box.dims = n_;
  constexpr int64_t size = sizeof(float);
  box.stride = {size, pitch_ * size, pitch_ * n_[1] * size};
  LowpassFrame clean = {filtered.value, {}, nullptr, {}};
  clean.memory = Reservation(context.memory, filtered.value.size() * sizeof(float), "the low-pass");
  box.data = clean.value.data() + margin_;
  const Frame frame({&box, 1}, n_, 0, "the low-pass");
  if (ringing_ > 0) {
    const FrameScan scan = scan_frame(frame, 0, context);
    const size_t row_bytes = static_cast<size_t>(n_[0] + 7) / 8;
    const auto& n = CellRanges::edge;
    const uint64_t planes = scan.cells.count()[2];
    context.tasks.parallel_for(planes, [&](uint64_t plane) {
      context.progress.check();
      Region cell;
      for (int64_t cy = 0; cy < scan.cells.count()[1]; ++cy)
        for (int64_t cx = 0; cx < scan.cells.count()[0]; ++cx) {
          const std::array<int64_t, 3> c{cx, cy, static_cast<int64_t>(plane)};
          Region near;
          for (size_t a = 0; a < 3; ++a) {
            cell.begin[a] = c[a] * n[a], cell.end[a] = std::min(n_[a], (c[a] + 1) * n[a]);
            near.begin[a] = cell.begin[a] - reach_[a], near.end[a] = cell.end[a] + reach_[a];
            if (turning_[a]) continue;
            near.begin[a] = std::max<int64_t>(0, near.begin[a]), near.end[a] = std::min(n_[a], near.end[a]);
          }
          const CellRanges::Cell range = turned_range(scan.cells, near, n_, turning_);
          const float least = ringing_ * std::max({0.0f, -range.low, range.high});
          for (int64_t z = cell.begin[2]; z < cell.end[2]; ++z)
            for (int64_t y = cell.begin[1]; y < cell.end[1]; ++y) {
              const size_t row = z * n_[1] + y;
              float* v = clean.value.data() + row * pitch_ + margin_;
              const uint8_t* air = filtered.origin->air.data() + row * row_bytes;
              for (int64_t x = cell.begin[0]; x < cell.end[0]; ++x)
                if ((air[x / 8] >> (x % 8) & 1) && std::fabs(v[x]) <= least) v[x] = 0;
            }
        }
    });
  }
  sink(frame, filtered.origin->holes);
}

} // namespace bccsplat
