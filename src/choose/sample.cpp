// SPDX-License-Identifier: Apache-2.0
// Divides a series into one or two stretches of time and cells in space, picks cells in even steps along the
// sum of their activity, and calibrates the weights of their boxes so that together they have the activity of
// all. Then it reads the boxes.
#include "choose/sample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "choose/activity.h"

namespace bccsplat::series {
namespace {

constexpr uint64_t kMargin = 5;      // samples around what counts: mirrors are out of sight
constexpr uint64_t kFrameMargin = 4; // the same in time
constexpr uint64_t kFewestBoxes = 3; // of a stretch that has more
constexpr double kEven = 0.1;        // of the picks: spread evenly, whatever is busy

// Takes all frames, or two stretches: one before the middle, and one that ends with the series.
std::vector<SampleStretch> divide_time(uint64_t frames, uint64_t longest) {
  if (frames <= longest) {
    SampleStretch all;
    all.frames = frames, all.counts = all.stands_for = {0, frames};
    return {all};
  }
  const uint64_t length = longest * 5 / 8;
  SampleStretch early, late;
  early.frames = late.frames = length;
  early.first = (frames - length) * 3 / 8, late.first = frames - length;
  early.counts = {early.first + kFrameMargin, early.first + length - kFrameMargin};
  late.counts = {late.first + kFrameMargin, frames};
  late.ends = kFrameMargin;
  const uint64_t border = (early.counts.end + late.counts.first) / 2;
  early.stands_for = {0, border}, late.stands_for = {border, frames};
  return {early, late};
}

void add_shares(const Shares& found, Shares& sum) {
  double all = 0;
  for (const double f : found) all += f;
  if (!(all > 0) || !std::isfinite(all)) return;
  for (size_t i = 0; i < found.size(); ++i) sum[i] += found[i] / all;
}

// A cell that was picked, and how often.
struct Pick {
  size_t cell = 0;
  double times = 0;
};

// The cells by what changes there, from space to time: even steps come by all kinds.
std::vector<size_t> cells_by_kind(const Activity& activity) {
  std::vector<std::pair<double, size_t>> kinds;
  for (size_t i = 0; i < activity.in_time.size(); ++i) {
    const double all = activity.in_space[i] + activity.in_time[i] + activity.at_faces[i];
    kinds.emplace_back(all > 0 ? activity.in_time[i] / all : 0, i);
  }
  std::sort(kinds.begin(), kinds.end());
  std::vector<size_t> cells;
  for (const auto& [kind, cell] : kinds) cells.push_back(cell);
  return cells;
}

// Picks `count` cells in even steps along the sum of their shares, the first one `offset` of a step behind
// its beginning: those that have more are picked more often.
std::vector<Pick> pick_cells(const Shares& shares, const Activity& activity, uint64_t count, double offset) {
  std::vector<Pick> picks;
  double sum = 0;
  size_t taken = 0;
  for (const size_t i : cells_by_kind(activity)) {
    sum += shares[i];
    while (taken < count && (static_cast<double>(taken) + offset) / static_cast<double>(count) < sum) {
      if (picks.empty() || picks.back().cell != i) picks.push_back({i, 0});
      ++picks.back().times;
      ++taken;
    }
  }
  if (picks.empty()) picks.push_back({shares.size() / 2, 1});
  return picks;
}

double part_of(const SampleBox& box, const Divisions& axes) {
  double part = 1;
  for (size_t a = 0; a < 3; ++a) part *= static_cast<double>(box.dims[a]) / static_cast<double>(axes[a].n);
  return part;
}

void place_box(SampleStretch& s, size_t cell, const Divisions& axes) {
  for (size_t a = 0; a < 3; ++a) {
    const uint64_t number = cell % axes[a].cells;
    cell /= axes[a].cells;
    const FrameSpan box = axes[a].box(number), inner = axes[a].counts(number);
    s.box.begin[a] = box.first, s.box.dims[a] = box.end - box.first;
    s.inner.begin[a] = inner.first, s.inner.dims[a] = inner.end - inner.first;
  }
}

// The probability of each cell to be picked.
Shares shares_of(const Activity& activity, const Divisions& axes) {
  Shares all(activity.in_space.size());
  add_shares(activity.in_space, all), add_shares(activity.in_time, all);
  add_shares(activity.at_faces, all);
  Shares shares(all.size());
  add_shares(all, shares);
  const bool any = std::any_of(shares.begin(), shares.end(), [](double s) { return s > 0; });
  for (size_t i = 0; i < shares.size(); ++i) {
    SampleStretch s;
    place_box(s, i, axes);
    const double even = part_of(s.inner, axes);
    shares[i] = any ? (1 - kEven) * shares[i] + kEven * even : even;
  }
  return shares;
}

// A box with what it stands for, of the activity of its stretch.
struct WeighedBox {
  double times = 1; // what is in its cell, so often
  double in_space = 0, in_time = 0, at_faces = 0, filled = 0;
};

// Changes the weights a little so that the boxes stand for all that changes in space, in time and at faces
// (calibration; Deville & Sarndal 1992, with the exponential distance).
void calibrate(std::vector<WeighedBox>& boxes) {
  constexpr int rounds = 100;
  const auto fit = [&](double WeighedBox::*share) {
    double sum = 0, slope = 0;
    for (const WeighedBox& b : boxes) {
      sum += b.times * (b.*share);
      slope += b.times * (b.*share) * (b.*share);
    }
    if (!(slope > 0)) return;
    const auto count = static_cast<double>(boxes.size());
    const double step = std::clamp((1 - sum) / (count * slope), -0.5, 0.5) / 2;
    for (WeighedBox& b : boxes) b.times *= std::exp(step * count * (b.*share));
  };
  for (int i = 0; i < rounds; ++i)
    fit(&WeighedBox::at_faces), fit(&WeighedBox::in_space), fit(&WeighedBox::in_time);
}

// The boxes of one stretch of time, so many that they have about `samples` samples.
std::vector<SampleStretch> pick_boxes(const SampleStretch& time, const Divisions& axes,
                                      const Activity& activity, uint64_t samples, double offset) {
  const Shares shares = shares_of(activity, axes);
  SampleStretch model = time;
  place_box(model, shares.size() / 2, axes);
  const uint64_t one = model.box.samples() * time.frames;
  const uint64_t count = shares.size() == 1 ? 1 : std::max(kFewestBoxes, samples / one);
  std::vector<SampleStretch> boxes;
  std::vector<WeighedBox> weights;
  for (const Pick& pick : pick_cells(shares, activity, count, offset)) {
    SampleStretch s = time;
    place_box(s, pick.cell, axes);
    boxes.push_back(std::move(s));
    weights.push_back({pick.times / static_cast<double>(count) / shares[pick.cell],
                       activity.in_space[pick.cell], activity.in_time[pick.cell],
                       activity.at_faces[pick.cell], activity.filled[pick.cell]});
  }
  calibrate(weights);
  for (size_t i = 0; i < boxes.size(); ++i) {
    boxes[i].weight = weights[i].times * part_of(boxes[i].inner, axes);
    boxes[i].filled = weights[i].times * weights[i].filled;
  }
  return boxes;
}

// The part of a frame in a box, counted from the corner of the box.
Frame crop_frame(const Frame& frame, const SampleBox& box) {
  Frame part;
  for (Box b : frame.boxes) {
    bool any = true;
    for (size_t a = 0; a < 3; ++a) {
      const uint64_t begin = std::max(b.begin[a], box.begin[a]);
      const uint64_t end = std::min(b.begin[a] + b.dims[a], box.begin[a] + box.dims[a]);
      any = any && begin < end;
      if (!any) break;
      b.data += (begin - b.begin[a]) * b.stride_bytes[a];
      b.begin[a] = begin - box.begin[a], b.dims[a] = end - begin;
    }
    if (any) part.boxes.push_back(b);
  }
  return part;
}

void append_box(const Frame& frame, const SampleBox& box, double air, std::vector<float>& values) {
  const Frame part = crop_frame(frame, box);
  const std::array<uint64_t, 4> dims{box.dims[0], box.dims[1], box.dims[2], 1};
  std::vector<double> plane(dims[0] * dims[1]);
  for (uint64_t z = 0; z < dims[2]; ++z) {
    gather_plane(part, dims, z, air, plane.data());
    for (const double v : plane) values.push_back(static_cast<float>(v));
  }
}

// The values of boxes that share their frames.
void read_boxes(FrameReader& reader, const std::vector<double>& air, std::span<SampleStretch> boxes,
                Watch& watch) {
  const SeriesDescription& s = reader.description();
  for (SampleStretch& b : boxes) b.values.resize(s.channels.size());
  for (uint64_t f = 0; f < boxes.front().frames; ++f)
    for (size_t c = 0; c < s.channels.size(); ++c) {
      watch.go_on();
      const uint64_t number = boxes.front().first + f;
      const bool whole = reader.frames_fit();
      const Frame frame = whole ? reader.read(number, c) : Frame{};
      for (SampleStretch& b : boxes)
        append_box(whole ? frame : reader.read_box(number, c, b.box), b.box, air[c], b.values[c]);
    }
}

void widen_ranges(const SampleStretch& box, std::vector<ChannelScan>& ranges) {
  for (size_t c = 0; c < ranges.size(); ++c)
    for (const float v : box.values[c]) {
      if (!std::isfinite(v)) continue;
      ranges[c].min = std::min(ranges[c].min, static_cast<double>(v));
      ranges[c].max = std::max(ranges[c].max, static_cast<double>(v));
    }
}

} // namespace

double SampleStretch::frame_weight(uint64_t frame) const {
  if (frame + ends >= counts.end) return 1;
  return static_cast<double>(stands_for.end - stands_for.first - ends) /
         static_cast<double>(counts.end - counts.first - ends);
}

double SeriesSample::filled() const {
  double sum = 0;
  for (const SampleStretch& s : stretches) sum += s.filled;
  return sum > 0 ? sum : 1;
}

uint64_t SeriesSample::frames() const {
  uint64_t count = 0, first = UINT64_MAX;
  for (const SampleStretch& s : stretches) {
    if (s.first != first) count += s.frames;
    first = s.first;
  }
  return count;
}

SampleSize size_to_choose(const std::array<uint64_t, 4>& dims) {
  constexpr uint64_t part = 128, fewest = uint64_t{1} << 18;
  SampleSize size;
  size.samples = std::clamp(dims[0] * dims[1] * dims[2] * dims[3] / part, fewest, size.samples);
  return size;
}

SeriesSample sample_series(FrameReader& reader, const std::vector<double>& air, const SampleSize& size,
                           Watch& watch) {
  const SeriesDescription& s = reader.description();
  const bool whole = s.dims[0] * s.dims[1] * s.dims[2] * s.dims[3] <= size.samples + size.samples / 4;
  const std::vector<SampleStretch> times = divide_time(s.dims[3], whole ? s.dims[3] : size.frames);
  const uint64_t edge = whole ? UINT64_MAX : size.edge;
  const Divisions axes{Division(s.dims[0], edge, kMargin), Division(s.dims[1], edge, kMargin),
                       Division(s.dims[2], edge, kMargin)};
  SeriesSample sample;
  sample.ranges.resize(s.channels.size());
  for (size_t i = 0; i < times.size(); ++i) {
    const SampleStretch& time = times[i];
    // Other boxes in each stretch.
    const double offset = (static_cast<double>(i) + 0.5) / static_cast<double>(times.size());
    const Activity activity =
        cells_of(axes) == 1 && times.size() == 1
            ? Activity(1)
            : find_activity(reader, air, axes, time.counts, time.stands_for, sample.ranges, watch);
    std::vector<SampleStretch> boxes = pick_boxes(time, axes, activity, size.samples / times.size(), offset);
    read_boxes(reader, air, boxes, watch);
    const double part =
        static_cast<double>(time.stands_for.end - time.stands_for.first) / static_cast<double>(s.dims[3]);
    for (SampleStretch& b : boxes) {
      b.weight *= part, b.filled *= part;
      widen_ranges(b, sample.ranges);
      sample.stretches.push_back(std::move(b));
    }
  }
  return sample;
}

SeriesDescription describe_stretch(const SeriesDescription& series, const SampleStretch& stretch) {
  SeriesDescription s = series;
  std::copy(stretch.box.dims.begin(), stretch.box.dims.end(), s.dims.begin());
  s.dims[3] = stretch.frames;
  const auto first = series.times.values.begin() + stretch.first;
  s.times.values.assign(first, first + stretch.frames);
  for (Channel& c : s.channels) c.type = Type::f32;
  s.sparse = false;
  s.places = {}; // of whole axes
  return s;
}

} // namespace bccsplat::series
