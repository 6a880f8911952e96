#include "tool/import/sample.h"

#include <algorithm>
#include <cmath>

#include "tool/interrupt.h"

namespace bcc4 {
namespace {

constexpr uint64_t kMargin = 5;      // samples around what counts: mirrors are out of sight
constexpr uint64_t kFrameMargin = 5; // the same in time
constexpr double kEven = 0.1;        // of the picks: spread evenly, whatever is busy
constexpr uint64_t kPlanesSeen = 32; // of a frame, to find what is busy
constexpr uint64_t kMoments = 3;     // of a stretch, for the same, but not of every frame
constexpr uint64_t kFramesPerMoment = 8;

// Cells of about equal size that divide an axis of n samples, and their boxes.
struct Division {
  uint64_t n = 1, cells = 1, margin = 0;
  Division(uint64_t samples, uint64_t longest, uint64_t border) : n(samples) {
    if (n <= longest) return;
    margin = border;
    const uint64_t inner = longest - 2 * margin;
    cells = (n + inner - 1) / inner;
  }
  [[nodiscard]] uint64_t begin(uint64_t cell) const { return n * cell / cells; }
  [[nodiscard]] uint64_t cell_at(uint64_t i) const { return ((i + 1) * cells - 1) / n; }
  [[nodiscard]] FrameSpan counts(uint64_t cell) const { return {begin(cell), begin(cell + 1)}; }
  [[nodiscard]] FrameSpan box(uint64_t cell) const {
    const FrameSpan inner = counts(cell);
    return {inner.first - std::min(inner.first, margin), std::min(n, inner.end + margin)};
  }
};

// Stretches of time, evenly spread: two, or all frames.
std::vector<SampleStretch> divide_time(uint64_t frames, uint64_t longest) {
  if (frames <= longest) {
    SampleStretch all;
    all.frames = frames, all.counts = {0, frames};
    return {all};
  }
  std::vector<SampleStretch> two(2);
  const uint64_t length = longest * 3 / 4;
  for (uint64_t i = 0; i < 2; ++i) {
    SampleStretch& s = two[i];
    s.frames = length;
    s.first = (frames - length) * (2 * i + 1) / 4;
    s.counts = {s.first + kFrameMargin, s.first + length - kFrameMargin};
  }
  return two;
}

// What a part has of the changes of a frame, cell by cell; all together 1.
using Shares = std::vector<double>;

// Changes from sample to sample where a coarse lattice loses them, in two axes at once, and from one frame to
// the next: its errors rise with them. What is not air: there are the errors of rounding.
struct Activity {
  Shares in_space, in_time, filled;
  explicit Activity(size_t cells) : in_space(cells), in_time(cells), filled(cells) {}
};

// Three planes of a frame and one of the next, and sums over the cells of an axis.
class ActivityPlanes {
 public:
  ActivityPlanes(const std::array<uint64_t, 4>& dims, const std::array<Division, 3>& axes, double air)
      : nx_(dims[0]), ny_(dims[1]), axes_(axes), air_(air) {
    for (auto* p : {&before, &here, &behind, &next, &bend_, &depth_}) p->resize(nx_ * ny_);
  }
  std::vector<double> before, here, behind, next;

  // Adds the plane `here` to the cells of plane z.
  void add(uint64_t z, Activity& found) {
    for (uint64_t y = 0; y < ny_; ++y)
      for (uint64_t x = 0; x < nx_; ++x) {
        const uint64_t i = y * nx_ + x;
        bend_[i] = across_rows(here, x, y);
        depth_[i] = before[i] + behind[i] - 2 * here[i];
      }
    for (uint64_t y = 0; y < ny_; ++y)
      for (uint64_t cell = 0; cell < axes_[0].cells; ++cell) {
        const FrameSpan span = axes_[0].counts(cell);
        double space = 0, time = 0, filled = 0;
        for (uint64_t x = span.first; x < span.end; ++x) {
          const uint64_t i = y * nx_ + x;
          space += square(along_row(bend_, x, y)) + square(along_row(depth_, x, y)) +
                   square(across_rows(depth_, x, y));
          time += square(next[i] - here[i]);
          filled += here[i] != air_ ? 1 : 0;
        }
        const size_t at =
            (axes_[2].cell_at(z) * axes_[1].cells + axes_[1].cell_at(y)) * axes_[0].cells + cell;
        found.in_space[at] += space, found.in_time[at] += time, found.filled[at] += filled;
      }
  }

 private:
  static double square(double v) { return v * v; }
  // Second differences, mirrored at the ends.
  [[nodiscard]] double along_row(const std::vector<double>& v, uint64_t x, uint64_t y) const {
    const double* const row = v.data() + y * nx_;
    return nx_ == 1 ? 0 : row[x == 0 ? 1 : x - 1] + row[x + 1 == nx_ ? nx_ - 2 : x + 1] - 2 * row[x];
  }
  [[nodiscard]] double across_rows(const std::vector<double>& v, uint64_t x, uint64_t y) const {
    if (ny_ == 1) return 0;
    const uint64_t up = y == 0 ? 1 : y - 1, down = y + 1 == ny_ ? ny_ - 2 : y + 1;
    return v[up * nx_ + x] + v[down * nx_ + x] - 2 * v[y * nx_ + x];
  }

  uint64_t nx_, ny_;
  const std::array<Division, 3>& axes_;
  double air_;
  std::vector<double> bend_, depth_; // second differences across rows and planes
};

void add_shares(const Shares& found, Shares& sum) {
  double all = 0;
  for (const double f : found) all += f;
  if (!(all > 0) || !std::isfinite(all)) return;
  for (size_t i = 0; i < found.size(); ++i) sum[i] += found[i] / all;
}

// Adds a channel of a frame and, where it is not the last, of the frame after it. Channels count alike.
void add_activity(const Frame& frame, const Frame* next, const std::array<uint64_t, 4>& dims,
                  const std::array<Division, 3>& axes, double air, ChannelScan& range, Activity& sum) {
  Activity found(sum.in_space.size());
  ActivityPlanes planes(dims, axes, air);
  const uint64_t nz = dims[2], step = std::max<uint64_t>(1, nz / kPlanesSeen);
  const auto read = [&](const Frame& f, uint64_t z, std::vector<double>& plane) {
    gather_plane(f, dims, z, air, plane.data());
    for (double& v : plane) {
      if (!std::isfinite(v)) v = air;
      range.min = std::min(range.min, v), range.max = std::max(range.max, v);
    }
  };
  for (uint64_t z = 0; z < nz; z += step) {
    stop_if_interrupted();
    read(frame, z == 0 ? std::min<uint64_t>(1, nz - 1) : z - 1, planes.before);
    read(frame, z, planes.here);
    read(frame, z + 1 == nz ? nz - std::min<uint64_t>(nz, 2) : z + 1, planes.behind);
    read(next ? *next : frame, z, planes.next);
    planes.add(z, found);
  }
  add_shares(found.in_space, sum.in_space), add_shares(found.in_time, sum.in_time);
  add_shares(found.filled, sum.filled);
}

// A cell that was picked, and how often.
struct Pick {
  size_t cell = 0;
  double times = 0;
};

// Picks `count` cells in even steps along the sum of their shares: those that have more are picked rather.
std::vector<Pick> pick_cells(const std::vector<double>& shares, uint64_t count) {
  std::vector<Pick> picks;
  double sum = 0;
  size_t taken = 0;
  for (size_t i = 0; i < shares.size(); ++i) {
    sum += shares[i];
    while (taken < count && (static_cast<double>(taken) + 0.5) / static_cast<double>(count) < sum) {
      if (picks.empty() || picks.back().cell != i) picks.push_back({i, 0});
      ++picks.back().times;
      ++taken;
    }
  }
  if (picks.empty()) picks.push_back({shares.size() / 2, 1});
  return picks;
}

double part_of(const SampleBox& box, const std::array<Division, 3>& axes) {
  double part = 1;
  for (size_t a = 0; a < 3; ++a) part *= static_cast<double>(box.dims[a]) / static_cast<double>(axes[a].n);
  return part;
}

void place_box(SampleStretch& s, size_t cell, const std::array<Division, 3>& axes) {
  for (size_t a = 0; a < 3; ++a) {
    const uint64_t number = cell % axes[a].cells;
    cell /= axes[a].cells;
    const FrameSpan box = axes[a].box(number), inner = axes[a].counts(number);
    s.box.begin[a] = box.first, s.box.dims[a] = box.end - box.first;
    s.inner.begin[a] = inner.first, s.inner.dims[a] = inner.end - inner.first;
  }
}

// The probability of each cell to be picked.
Shares shares_of(const Activity& activity, const std::array<Division, 3>& axes) {
  Shares both(activity.in_space.size());
  add_shares(activity.in_space, both), add_shares(activity.in_time, both);
  Shares shares(both.size());
  add_shares(both, shares);
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
  double in_space = 0, in_time = 0, filled = 0;
};

// Changes the weights a little so that the boxes stand for all that changes in space and in time
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
  for (int i = 0; i < rounds; ++i) fit(&WeighedBox::in_space), fit(&WeighedBox::in_time);
}

// The boxes of one stretch of time, so many that they have about `samples` samples.
std::vector<SampleStretch> pick_boxes(const SampleStretch& time, const std::array<Division, 3>& axes,
                                      const Activity& activity, uint64_t samples) {
  const Shares shares = shares_of(activity, axes);
  Shares in_space(shares.size()), in_time(shares.size()), filled(shares.size());
  add_shares(activity.in_space, in_space), add_shares(activity.in_time, in_time);
  add_shares(activity.filled, filled);
  SampleStretch model = time;
  place_box(model, shares.size() / 2, axes);
  const uint64_t one = model.box.samples() * time.frames;
  const uint64_t count = shares.size() == 1 ? 1 : std::max<uint64_t>(1, (samples + one / 2) / one);
  std::vector<SampleStretch> boxes;
  std::vector<WeighedBox> weights;
  for (const Pick& pick : pick_cells(shares, count)) {
    SampleStretch s = time;
    place_box(s, pick.cell, axes);
    boxes.push_back(std::move(s));
    weights.push_back({pick.times / static_cast<double>(count) / shares[pick.cell], in_space[pick.cell],
                       in_time[pick.cell], filled[pick.cell]});
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
void read_boxes(FrameReader& reader, const std::vector<double>& air, std::span<SampleStretch> boxes) {
  const SeriesDescription& s = reader.description();
  for (SampleStretch& b : boxes) b.values.resize(s.channels.size());
  for (uint64_t f = 0; f < boxes.front().frames; ++f)
    for (size_t c = 0; c < s.channels.size(); ++c) {
      stop_if_interrupted();
      const Frame frame = reader.read(boxes.front().first + f, c);
      for (SampleStretch& b : boxes) append_box(frame, b.box, air[c], b.values[c]);
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

size_t cells_of(const std::array<Division, 3>& axes) { return axes[0].cells * axes[1].cells * axes[2].cells; }

Activity find_activity(FrameReader& reader, const std::vector<double>& air, const SampleStretch& time,
                       const std::array<Division, 3>& axes, std::vector<ChannelScan>& ranges) {
  const SeriesDescription& s = reader.description();
  Activity activity(cells_of(axes));
  if (cells_of(axes) == 1) return activity;
  const uint64_t moments = std::clamp<uint64_t>(time.frames / kFramesPerMoment, 1, kMoments);
  for (uint64_t m = 0; m < moments; ++m) {
    const uint64_t moment = time.first + time.frames * (2 * m + 1) / (2 * moments);
    for (size_t c = 0; c < s.channels.size(); ++c) {
      const Frame frame = reader.read(moment, c);
      const bool last = moment + 1 >= s.dims[3];
      const Frame next = last ? Frame{} : reader.read(moment + 1, c);
      add_activity(frame, last ? nullptr : &next, s.dims, axes, air[c], ranges[c], activity);
    }
  }
  return activity;
}

} // namespace

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

SeriesSample sample_series(FrameReader& reader, const std::vector<double>& air, const SampleSize& size) {
  const SeriesDescription& s = reader.description();
  const bool whole = s.dims[0] * s.dims[1] * s.dims[2] * s.dims[3] <= size.samples + size.samples / 4;
  const std::vector<SampleStretch> times = divide_time(s.dims[3], whole ? s.dims[3] : size.frames);
  const uint64_t edge = whole ? UINT64_MAX : size.edge;
  const std::array<Division, 3> axes{Division(s.dims[0], edge, kMargin), Division(s.dims[1], edge, kMargin),
                                     Division(s.dims[2], edge, kMargin)};
  SeriesSample sample;
  sample.ranges.resize(s.channels.size());
  for (const SampleStretch& time : times) {
    const Activity activity = find_activity(reader, air, time, axes, sample.ranges);
    std::vector<SampleStretch> boxes = pick_boxes(time, axes, activity, size.samples / times.size());
    read_boxes(reader, air, boxes);
    for (SampleStretch& b : boxes) {
      b.weight /= static_cast<double>(times.size());
      b.filled /= static_cast<double>(times.size());
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
  const auto first = series.times.values.begin() + static_cast<std::ptrdiff_t>(stretch.first);
  s.times.values.assign(first, first + static_cast<std::ptrdiff_t>(stretch.frames));
  for (Channel& c : s.channels) c.type = Type::f32;
  s.sparse = false;
  return s;
}

} // namespace bcc4
