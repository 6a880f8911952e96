// SPDX-License-Identifier: Apache-2.0
// Tells channels of labels, cuts them through samples, and makes masks of them.
#include "volume/labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "base/error.h"
#include "field/masks.h"
#include "formats/bcc4/labels_attribute.h"
#include "shade/value_survey.h"
#include "slice/even_slice.h"
#include "volume/label_samples.h"
#include "volume/value_counts.h"

namespace bccsplat {
namespace {

constexpr double half = 0.5; // values nearer to a label than that are it

// Returns the axis that a plane is normal to; none: it lies aslant.
std::optional<size_t> axis_of(const Hyperplane& plane) {
  std::optional<size_t> axis;
  for (size_t a = 0; a < 4; ++a) {
    if (plane[a] == 0) continue;
    if (axis) return std::nullopt;
    axis = a;
  }
  return axis;
}

size_t count_of(const Grid& grid) {
  size_t count = 1;
  for (const int32_t n : grid.dims) count *= static_cast<size_t>(n);
  return count;
}

// The samples of a volume that a box of its index space holds.
Grid samples_in(const OpenVolume& volume, const std::optional<IndexBox>& box) {
  Grid grid;
  for (size_t a = 0; a < 3; ++a) {
    const double last = volume.info().lattice.dims[a] - 1;
    const double first = box ? std::clamp(std::floor(box->begin[a]), 0.0, last) : 0;
    const double end = box ? std::clamp(std::ceil(box->end[a]), 0.0, last) : last;
    grid.origin[a] = first, grid.dims[a] = static_cast<int32_t>(end - first) + 1;
  }
  return grid;
}

// The plane through the samples that are nearest to one along the axes; even: it is of even positions.
Hyperplane plane_of_samples(const OpenVolume& volume, const Hyperplane& plane, const UnevenAxes* even) {
  const size_t axis = *axis_of(plane);
  std::array<Vec4, 1> point{};
  point[0][axis] = -plane[4] / plane[axis];
  if (even && axis < 3) point[0][axis] = even->index_of(axis, point[0][axis]);
  snap_to_samples(volume, point);
  if (even && axis < 3) point[0][axis] = even->even_of(axis, point[0][axis]);
  Vec4 normal{};
  normal[axis] = plane[axis] < 0 ? -1 : 1;
  return {normal[0], normal[1], normal[2], normal[3], -normal[axis] * point[0][axis]};
}

// The hidden samples of a frame: those of other labels, and those that were missing before.
class HiddenSamples {
 public:
  HiddenSamples(const Slice& slice, const std::array<int64_t, 3>& samples, std::span<const double> labels,
                const Context& context)
      : before_(slice.mask.get()), samples_(samples), labels_(labels),
        mask_(std::make_shared<FrameMask>(
            samples, Reservation(context.memory, FrameMask::bytes_of(samples), "a mask of labels"), false)) {}

  void add(const Grid& grid, std::span<const float> values, Progress& progress) {
    const auto nx = static_cast<size_t>(grid.dims[0]), ny = static_cast<size_t>(grid.dims[1]);
    for (size_t n = 0; n < values.size(); ++n) {
      if (n % (nx * ny) == 0) progress.check();
      const Vec3 at{grid.origin[0] + static_cast<double>(n % nx),
                    grid.origin[1] + static_cast<double>(n / nx % ny),
                    grid.origin[2] + static_cast<double>(n / nx / ny)};
      if (shows(values[n]) && !(before_ && before_->missing(at))) continue;
      const int64_t voxel =
          (static_cast<int64_t>(at[2]) * samples_[1] + static_cast<int64_t>(at[1])) * samples_[0] +
          static_cast<int64_t>(at[0]);
      mask_->add(static_cast<uint64_t>(voxel), static_cast<uint64_t>(voxel) + 1);
    }
  }
  [[nodiscard]] FrameMaskPtr finish() {
    mask_->count_blocks();
    return mask_;
  }

 private:
  [[nodiscard]] bool shows(float value) const {
    return std::any_of(labels_.begin(), labels_.end(), [&](double l) { return std::fabs(l - value) < half; });
  }

  const SliceMask* before_;
  std::array<int64_t, 3> samples_;
  std::span<const double> labels_;
  std::shared_ptr<FrameMask> mask_;
};

} // namespace

bool is_labels(const OpenVolume& volume, uint32_t channel) {
  const std::string& name = volume.channel(channel).name;
  const Lattice4& lattice = volume.lattice(0);
  const Vec3 own{1, 1, 1};
  if (lattice.kind != LatticeKind::cc || lattice.space_step != own) return false;
  if (!lattice.is_static() && lattice.time_step != 1) return false;
  if (volume.info().tile_edge > 1) return false; // wavelets are near to what they store, and no labels
  if (const auto known = volume.known_labels(channel)) return *known;
  const std::optional<bool> said = said_labels(volume.info(), name);
  const bool labels = said ? *said : survey_values(value_counts(volume, channel)).kind == ValueKind::labels;
  volume.note_labels(channel, labels);
  return labels;
}

void snap_to_samples(const OpenVolume& volume, std::span<Vec4> points) {
  for (Vec4& p : points)
    for (size_t a = 0; a < 4; ++a) {
      const double end = volume.lattice(0).domain_end(a), nearest = nearest_place(p[a]);
      if (p[a] >= 0 && p[a] <= end) p[a] = std::min(nearest, end);
    }
}

bool cuts_labels(const OpenVolume& volume, const SliceRequest& request) {
  const HypersliceOptions& cut = request.cut;
  if (cut.method == SliceMethod::extracted || request.level != 0 || cut.axes || cut.target || cut.bandwidth)
    return false;
  if (cut.has_interval() || cut.thickness.length != 0 || cut.spacing != 0) return false;
  return axis_of(request.plane) && is_labels(volume, request.channel);
}

SliceRequest as_cut(const OpenVolume& volume, const SliceRequest& request) {
  SliceRequest made = request;
  if (!cuts_labels(volume, request)) return made;
  made.cut.motion = false; // they are those of a frame
  const UnevenAxes* const even = made.cut.even.get();
  made.plane = plane_of_samples(volume, request.plane, even);
  std::optional<IndexBox>& box = made.cut.box;
  if (box && even) box = index_box(*box, *even);
  for (size_t a = 0; box && a < 3; ++a) {
    box->begin[a] = std::floor(box->begin[a]), box->end[a] = std::ceil(box->end[a]);
    if (even) box->begin[a] = even->even_of(a, box->begin[a]), box->end[a] = even->even_of(a, box->end[a]);
  }
  return made;
}

void add_labels(OpenSlice& slice, const OpenVolume& volume, const Context& context) {
  if (slice.slice.empty()) return;
  const Grid grid = label_grid(slice);
  Reservation memory(context.memory, count_of(grid) * sizeof(float), "the labels of a slice");
  slice.slice.labels = std::make_shared<const SliceLabels>(
      grid.origin, grid.dims, read_labels(volume, slice, context), std::move(memory), even_places(slice));
}

SliceRequest request_labels(const OpenVolume& volume, uint32_t channel, double frame,
                            const std::optional<IndexBox>& box) {
  HypersliceOptions cut;
  cut.box = box;
  return request_slice(volume, channel, nullptr, 0, Hyperplane(0, 0, 0, 1, -nearest_place(frame)), cut);
}

void show_labels_only(Slice& slice, const OpenVolume& volume, uint32_t channel,
                      std::span<const double> labels, double frame, const std::optional<IndexBox>& box,
                      const Context& context) {
  if (volume.axes()->any())
    fail(Code::unsupported,
         "mask: the axes of the volume are unevenly spaced, and labels of uneven axes mask "
         "nothing; leave the mask out");
  const std::array<uint32_t, 4>& dims = volume.info().lattice.dims;
  const double nearest = nearest_place(frame);
  const OpenSlice of_labels = cut_slice(volume, request_labels(volume, channel, frame, box), context);
  const Grid grid = samples_in(volume, box);
  const Reservation work(context.memory, count_of(grid) * sizeof(float), "reading a mask of labels");
  std::vector<float> values(count_of(grid));
  of_labels.sample(grid, values.data(), context);
  HiddenSamples hidden(slice, {dims[0], dims[1], dims[2]}, labels, context);
  hidden.add(grid, values, context.progress);
  const TurningAxes turning = slice.lattice.any_periodic()
                                  ? TurningAxes{slice.lattice.periodic[0], slice.lattice.periodic[1],
                                                slice.lattice.periodic[2], false}
                                  : TurningAxes{};
  slice.mask = std::make_shared<const SliceMask>(
      std::array<int64_t, 4>{dims[0], dims[1], dims[2], dims[3]}, turning, slice.origin, slice.basis,
      static_cast<int64_t>(nearest), std::vector<FrameMaskPtr>{hidden.finish()});
  slice.holes_by_mask = slice.holes_by_mask || !slice.has_holes;
  slice.has_holes = true;
}

} // namespace bccsplat
