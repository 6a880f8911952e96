// SPDX-License-Identifier: Apache-2.0
// Looks at some planes of a few moments and sums squares by cells: second differences in pairs of axes and
// along time, first differences at the faces. The frames before and behind a span are looked at as well, to
// know its share.
#include "choose/activity.h"

#include <algorithm>
#include <cmath>

#include "series/frame_planes.h"

namespace bccsplat::series {
namespace {

constexpr uint64_t kPlanesSeen = 32; // of a frame
constexpr uint64_t kMoments = 8;     // of a span of frames
constexpr uint64_t kPerMoment = 3;   // frames: one and those around it

// Four planes of a frame and those of the frames around it, and sums over the cells of an axis.
class ActivityPlanes {
 public:
  ActivityPlanes(const std::array<uint64_t, 4>& dims, const Divisions& axes, double air)
      : nx_(dims[0]), ny_(dims[1]), axes_(axes), air_(air) {
    for (auto* p : {&above, &here, &below, &before, &after, &bend_, &depth_}) p->resize(nx_ * ny_);
  }
  std::vector<double> above, here, below; // planes of the frame
  std::vector<double> before, after;      // the plane `here` in the frames around it

  // Adds the plane `here` to the cells of plane z.
  void add(uint64_t z, Activity& found) {
    for (uint64_t y = 0; y < ny_; ++y)
      for (uint64_t x = 0; x < nx_; ++x) {
        const uint64_t i = y * nx_ + x;
        bend_[i] = across_rows(here, x, y);
        depth_[i] = above[i] + below[i] - 2 * here[i];
      }
    for (uint64_t y = 0; y < ny_; ++y)
      for (uint64_t cell = 0; cell < axes_[0].cells; ++cell) {
        const FrameSpan span = axes_[0].counts(cell);
        double space = 0, time = 0, filled = 0;
        for (uint64_t x = span.first; x < span.end; ++x) {
          const uint64_t i = y * nx_ + x;
          space += square(along_row(bend_, x, y)) + square(along_row(depth_, x, y)) +
                   square(across_rows(depth_, x, y));
          time += square(before[i] + after[i] - 2 * here[i]);
          filled += here[i] != air_ ? 1 : 0;
        }
        const size_t at = cell_of(cell, y, z);
        found.in_space[at] += space, found.in_time[at] += time, found.filled[at] += filled;
      }
    add_kinks(z, found.at_faces);
  }
  // Adds the kinks of a face z = const: of the plane `here`, and `below` the one beside it.
  void add_face(uint64_t z, Shares& kinks) const {
    for (uint64_t y = 0; y < ny_; ++y)
      for (uint64_t x = 0; x < nx_; ++x)
        kinks[cell_of(axes_[0].cell_at(x), y, z)] += square(below[y * nx_ + x] - here[y * nx_ + x]);
  }

 private:
  [[nodiscard]] size_t cell_of(uint64_t cell_x, uint64_t y, uint64_t z) const {
    return (axes_[2].cell_at(z) * axes_[1].cells + axes_[1].cell_at(y)) * axes_[0].cells + cell_x;
  }
  // Adds the kinks at the faces of x and y.
  void add_kinks(uint64_t z, Shares& kinks) const {
    if (axes_[0].cells > 1)
      for (uint64_t y = 0; y < ny_; ++y) {
        const double* const row = here.data() + y * nx_;
        kinks[cell_of(0, y, z)] += square(row[1] - row[0]);
        kinks[cell_of(axes_[0].cells - 1, y, z)] += square(row[nx_ - 2] - row[nx_ - 1]);
      }
    if (axes_[1].cells > 1)
      for (uint64_t x = 0; x < nx_; ++x) {
        const uint64_t cell = axes_[0].cell_at(x), last = (ny_ - 1) * nx_ + x;
        kinks[cell_of(cell, 0, z)] += square(here[nx_ + x] - here[x]);
        kinks[cell_of(cell, ny_ - 1, z)] += square(here[last - nx_] - here[last]);
      }
  }
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
  const Divisions& axes_;
  double air_;
  std::vector<double> bend_, depth_; // second differences across rows and planes
};

// The neighbours of i, mirrored at the ends of an axis.
uint64_t one_before(uint64_t i, uint64_t n) { return i > 0 ? i - 1 : std::min<uint64_t>(1, n - 1); }
uint64_t one_after(uint64_t i, uint64_t n) { return i + 1 < n ? i + 1 : n - std::min<uint64_t>(n, 2); }

// Adds the planes of a channel at a moment, those first that come after `offset` parts of a step.
void add_moment(FrameReader& reader, uint64_t moment, size_t channel, double offset, double air,
                const Divisions& axes, ChannelScan& range, Activity& sum, Watch& watch) {
  const std::array<uint64_t, 4>& dims = reader.description().dims;
  FramePlanes before(reader, one_before(moment, dims[3]), channel);
  FramePlanes frame(reader, moment, channel);
  FramePlanes after(reader, one_after(moment, dims[3]), channel);
  ActivityPlanes planes(dims, axes, air);
  const auto read = [&](FramePlanes& f, uint64_t z, std::vector<double>& plane) {
    f.gather(z, air, plane.data());
    for (double& v : plane) {
      if (!std::isfinite(v)) v = air;
      range.min = std::min(range.min, v), range.max = std::max(range.max, v);
    }
  };
  const uint64_t nz = dims[2], step = std::max<uint64_t>(1, nz / kPlanesSeen);
  for (auto z = static_cast<uint64_t>(offset * static_cast<double>(step)); z < nz; z += step) {
    watch.go_on();
    if (std::isfinite(air) && !frame.may_have(z > 0 ? z - 1 : 0, z + 2) && !before.may_have(z, z + 1) &&
        !after.may_have(z, z + 1)) { // of parts far apart most planes have none
      range.min = std::min(range.min, air), range.max = std::max(range.max, air);
      continue;
    }
    read(frame, one_before(z, nz), planes.above);
    read(frame, z, planes.here);
    read(frame, one_after(z, nz), planes.below);
    read(before, z, planes.before);
    read(after, z, planes.after);
    planes.add(z, sum);
  }
  if (axes[2].cells == 1) return;
  for (const uint64_t face : {uint64_t{0}, nz - 1}) {
    read(frame, face, planes.here);
    read(frame, face == 0 ? 1 : nz - 2, planes.below);
    planes.add_face(face, sum.at_faces);
  }
}

// The mean of some frames, by channel.
struct Mean {
  std::vector<Activity> channels;
  double frames = 0; // that it stands for
  double looked_at = 0;
  Mean(size_t channel_count, size_t cells) : channels(channel_count, Activity(cells)) {}

  void add(FrameReader& reader, FrameSpan span, const std::vector<double>& air, const Divisions& axes,
           std::vector<ChannelScan>& ranges, Watch& watch) {
    if (span.first >= span.end) return;
    const uint64_t length = span.end - span.first;
    const uint64_t moments = std::clamp<uint64_t>(length / kPerMoment, 1, kMoments);
    for (uint64_t m = 0; m < moments; ++m)
      for (size_t c = 0; c < channels.size(); ++c)
        add_moment(reader, span.first + length * (2 * m + 1) / (2 * moments), c,
                   static_cast<double>(m) / static_cast<double>(moments), air[c], axes, ranges[c],
                   channels[c], watch);
    frames += static_cast<double>(length), looked_at += static_cast<double>(moments);
  }
  // Returns the share of a channel summed over all frames that the measured ones stand for.
  [[nodiscard]] double sum(size_t channel, Shares Activity::*kind) const {
    double all = 0;
    for (const double share : channels[channel].*kind) all += share;
    return looked_at > 0 ? all * frames / looked_at : 0;
  }
};

} // namespace

Division::Division(uint64_t samples, uint64_t longest, uint64_t border) : n(samples) {
  if (n <= longest) return;
  margin = border;
  const uint64_t inner = longest - 2 * margin;
  cells = (n + inner - 1) / inner;
}

FrameSpan Division::box(uint64_t cell) const {
  const uint64_t length = std::min(n, (n + cells - 1) / cells + 2 * margin);
  const uint64_t first = begin(cell) - std::min(begin(cell), margin);
  const uint64_t end = std::min(n, first + length);
  return {end - length, end};
}

Activity find_activity(FrameReader& reader, const std::vector<double>& air, const Divisions& axes,
                       FrameSpan here, FrameSpan all, std::vector<ChannelScan>& ranges, Watch& watch) {
  const size_t channels = reader.description().channels.size(), cells = cells_of(axes);
  Mean inside(channels, cells), outside(channels, cells);
  outside.add(reader, {all.first, here.first}, air, axes, ranges, watch);
  inside.add(reader, here, air, axes, ranges, watch);
  outside.add(reader, {here.end, all.end}, air, axes, ranges, watch);
  Activity activity(cells);
  for (Shares Activity::*kind :
       {&Activity::in_space, &Activity::in_time, &Activity::at_faces, &Activity::filled}) {
    double counted = 0;
    Shares& shares = activity.*kind;
    for (size_t c = 0; c < channels; ++c) {
      const double sum = inside.sum(c, kind) + outside.sum(c, kind);
      const double of_all = sum / (inside.frames + outside.frames) * inside.looked_at;
      if (!(of_all > 0) || !std::isfinite(of_all)) continue;
      ++counted;
      for (size_t i = 0; i < cells; ++i) shares[i] += (inside.channels[c].*kind)[i] / of_all;
    }
    for (double& s : shares) s /= std::max(1.0, counted);
  }
  return activity;
}

} // namespace bccsplat::series
