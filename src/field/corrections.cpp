// Loads the corrections of single frames and adds their tents to grids and points.
#include "field/corrections.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {
namespace {

// Lists of frames that stay in memory: a picture needs two, a trail over time goes through them in order.
constexpr size_t frames_kept = 8;
constexpr double same_place = 1e-6; // index units: a point this close to a source sample is meant to be it
constexpr double rounding = 1e-9;   // index units: sums of steps miss a whole index by less

// Samples of one axis of a grid by the cell between two voxels in which they lie.
struct CellSamples {
  CellSamples(const Grid& grid, size_t axis, int64_t voxels) : cells(static_cast<size_t>(voxels)) {
    for (int32_t i = 0; i < grid.dims[axis]; ++i) {
      double p = grid.origin[axis] + grid.step[axis] * i;
      const double near = std::nearbyint(p);
      if (std::fabs(p - near) < rounding) p = near; // a whole index, whatever its sum rounded to
      const double cell = std::floor(p);
      if (cell < 0 || cell >= static_cast<double>(voxels)) continue;
      cells[static_cast<size_t>(cell)].push_back({static_cast<size_t>(i), p});
    }
  }
  // Calls body(sample, weight) for the samples under the tent of a voxel.
  template<class Body> void under(int64_t voxel, const Body& body) const {
    for (int64_t c = std::max<int64_t>(voxel - 1, 0); c <= voxel; ++c)
      for (const auto& [i, p] : cells[static_cast<size_t>(c)]) {
        const double w = 1 - std::fabs(p - static_cast<double>(voxel));
        if (w > 0) body(i, static_cast<float>(w));
      }
  }
  std::vector<std::vector<std::pair<size_t, double>>> cells;
};

// The value of a voxel in a list, null when it has none.
const float* find(const std::vector<std::pair<uint64_t, float>>& list, uint64_t voxel) {
  const auto it = std::lower_bound(list.begin(), list.end(), voxel,
                                   [](const auto& entry, uint64_t v) { return entry.first < v; });
  return it != list.end() && it->first == voxel ? &it->second : nullptr;
}

} // namespace

Corrections::Corrections(std::shared_ptr<const Bcc4Reader> reader, int channel)
    : reader_(std::move(reader)), channel_(channel) {
  const auto& dims = reader_->info().lattice.dims;
  std::copy(dims.begin(), dims.end(), n_.begin());
}

std::shared_ptr<const Corrections::FrameList> Corrections::load(int64_t frame) const {
  {
    const std::scoped_lock lock(mutex_);
    const auto it =
        std::find_if(recent_.begin(), recent_.end(), [&](const auto& entry) { return entry.first == frame; });
    if (it != recent_.end()) {
      std::rotate(it, it + 1, recent_.end());
      return recent_.back().second;
    }
  }
  const ChannelInfo& info = reader_->info().channels[static_cast<size_t>(channel_)];
  const FrameResiduals stored = reader_->residuals(channel_, static_cast<uint64_t>(frame));
  auto list = std::make_shared<FrameList>();
  const auto value = [&](int64_t steps) {
    return static_cast<float>(static_cast<double>(steps) * info.residuals.step);
  };
  for (const ResidualSample& s : stored.add) list->add.emplace_back(s.voxel, value(s.steps));
  for (const ResidualSample& s : stored.set) list->set.emplace_back(s.voxel, info.air + value(s.steps));
  const std::scoped_lock lock(mutex_);
  recent_.emplace_back(frame, list);
  if (recent_.size() > frames_kept) recent_.erase(recent_.begin());
  return list;
}

std::vector<Corrections::Part> Corrections::parts(double frame) const {
  if (n_[3] == 1) frame = 0;
  if (const double near = std::nearbyint(frame); std::fabs(frame - near) < rounding) frame = near;
  std::vector<Part> result;
  const auto first = static_cast<int64_t>(std::floor(frame));
  for (int64_t f = first; f <= first + 1; ++f) {
    const double w = 1 - std::fabs(frame - static_cast<double>(f));
    if (w > 0 && f >= 0 && f < n_[3]) result.push_back({load(f), static_cast<float>(w)});
  }
  return result;
}

std::array<float, 2> Corrections::range(double frame) const {
  std::array<float, 2> r{};
  for (const Part& part : parts(frame))
    for (const auto& [voxel, value] : part.list->add) r = {std::min(r[0], value), std::max(r[1], value)};
  return r;
}

void Corrections::add_to_grid(double frame, const Grid& grid, float* values) const {
  const std::vector<Part> all = parts(frame);
  if (std::all_of(all.begin(), all.end(),
                  [](const Part& p) { return p.list->add.empty() && p.list->set.empty(); }))
    return;
  const CellSamples x(grid, 0, n_[0]), y(grid, 1, n_[1]), z(grid, 2, n_[2]);
  const auto nx = static_cast<size_t>(grid.dims[0]), ny = static_cast<size_t>(grid.dims[1]);
  // Calls body(sample, weight) for the samples under the tent of a voxel.
  const auto under = [&](uint64_t voxel, const auto& body) {
    const auto v = static_cast<int64_t>(voxel);
    z.under(v / (n_[0] * n_[1]), [&](size_t k, float wz) {
      y.under(v / n_[0] % n_[1], [&](size_t j, float wy) {
        x.under(v % n_[0], [&](size_t i, float wx) { body((k * ny + j) * nx + i, wx * wy * wz); });
      });
    });
  };
  for (const Part& part : all) {
    for (const auto& [voxel, value] : part.list->add)
      under(voxel, [&, add = value](size_t sample, float w) { values[sample] += add * (w * part.weight); });
    for (const auto& [voxel, value] : part.list->set)
      under(voxel, [&, set = value](size_t sample, float w) {
        if (w * part.weight > 1 - 4 * same_place && std::isnan(values[sample])) values[sample] = set;
      });
  }
}

uint64_t Corrections::add_to_points(std::span<const Vec4> points, std::span<float> values) const {
  uint64_t found = 0;
  double at = 0;
  std::vector<Part> now;
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec4& p = points[i];
    if (i == 0 || p[3] != at) at = p[3], now = parts(at);
    for (const Part& part : now) {
      const FrameList& list = *part.list;
      if (std::isnan(values[i])) {
        uint64_t voxel = 0;
        bool whole = part.weight > 1 - same_place;
        for (size_t a = 3; a-- > 0;) {
          const double near = std::nearbyint(p[a]);
          whole =
              whole && std::fabs(p[a] - near) < same_place && near >= 0 && near < static_cast<double>(n_[a]);
          voxel = voxel * static_cast<uint64_t>(n_[a]) + (whole ? static_cast<uint64_t>(near) : 0);
        }
        if (const float* value = whole ? find(list.set, voxel) : nullptr) values[i] = *value, ++found;
        continue;
      }
      if (list.add.empty()) continue;
      std::array<int64_t, 3> cell{};
      for (size_t a = 0; a < 3; ++a) cell[a] = static_cast<int64_t>(std::floor(p[a]));
      for (int corner = 0; corner < 8; ++corner) {
        uint64_t voxel = 0;
        double w = 1;
        bool inside = true;
        for (size_t a = 3; a-- > 0;) {
          const int64_t v = cell[a] + (corner >> a & 1);
          w *= 1 - std::fabs(p[a] - static_cast<double>(v));
          inside = inside && v >= 0 && v < n_[a];
          voxel = voxel * static_cast<uint64_t>(n_[a]) + static_cast<uint64_t>(v);
        }
        if (!inside || !(w > 0)) continue;
        if (const float* value = find(list.add, voxel))
          values[i] += *value * (static_cast<float>(w) * part.weight);
      }
    }
  }
  return found;
}

} // namespace bccsplat
