// SPDX-License-Identifier: Apache-2.0
#include "field/masks.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

namespace bccsplat {
namespace {

constexpr uint64_t block_points = 4096; // of a task

// Half a step of rounding is no reason for a point that is meant to lie half way to belong to the earlier
// one.
constexpr double rounding = 1e-9;

double near_index(double position) { return std::floor(position + 0.5 + rounding); }

// Of a periodic axis, on which points may be anywhere; what is further off than that is no place of a series.
int64_t counted_index(double position) {
  constexpr double most = 1e15;
  return static_cast<int64_t>(std::clamp(near_index(position), -most, most));
}

int64_t nearest_of(double position, int64_t n) {
  return static_cast<int64_t>(std::clamp(near_index(position), 0.0, static_cast<double>(n - 1)));
}

uint64_t voxels_of(const std::array<int64_t, 3>& n) {
  return static_cast<uint64_t>(n[0]) * static_cast<uint64_t>(n[1]) * static_cast<uint64_t>(n[2]);
}

} // namespace

FrameMask::FrameMask(const std::array<int64_t, 3>& samples, Reservation memory, bool all)
    : n_(samples), bits_(bytes_of(samples) / sizeof(uint64_t)), memory_(std::move(memory)) {
  if (all) add(0, voxels_of(n_));
}

uint64_t FrameMask::bytes_of(const std::array<int64_t, 3>& samples) {
  return (voxels_of(samples) + 63) / 64 * sizeof(uint64_t);
}

void FrameMask::add(uint64_t begin, uint64_t end) {
  for (uint64_t i = begin; i < end;) {
    const uint64_t from = i % 64, n = std::min(end - i, 64 - from);
    bits_[i / 64] |= (n == 64 ? ~uint64_t{0} : (uint64_t{1} << n) - 1) << from;
    i += n;
  }
}

uint64_t FrameMask::count() const {
  uint64_t sum = 0;
  for (const uint64_t bits : bits_) sum += static_cast<uint64_t>(std::popcount(bits));
  return sum;
}

Masks::Masks(std::shared_ptr<const Bcc4Reader> reader, int channel, MemoryBudget& budget,
             uint64_t cache_bytes)
    : reader_(std::move(reader)), channel_(channel), periodic_(reader_->info().lattice.periodic),
      budget_(budget), cache_(cache_bytes) {
  const auto& dims = reader_->info().lattice.dims;
  for (size_t a = 0; a < 4; ++a) n_[a] = dims[a];
}

int64_t Masks::nearest(double position, size_t axis) const { return nearest_of(position, n_[axis]); }

int64_t Masks::counted_frame(double moment) const {
  return periodic_ ? counted_index(moment) : nearest(moment, 3);
}

FrameMaskPtr Masks::read(int64_t frame) const {
  const uint64_t offset = blocks()[static_cast<size_t>(frame)].offset;
  if (auto found = cache_.find(offset)) return found;
  const std::scoped_lock lock(mutex_);
  if (auto held = in_use_[offset].lock()) return held;
  const std::array<int64_t, 3> n{n_[0], n_[1], n_[2]};
  auto made = std::make_shared<FrameMask>(n, Reservation(budget_, FrameMask::bytes_of(n), "a mask"), false);
  reader_->mask_runs(channel_, static_cast<uint64_t>(frame),
                     [&](uint64_t begin, uint64_t end) { made->add(begin, end); });
  in_use_[offset] = made;
  // The mask itself holds its memory.
  cache_.insert(offset, FrameMaskPtr(made), made->bytes(), 0);
  return made;
}

FrameMaskPtr Masks::read_nearest_whole(int64_t frame) const {
  const auto end = static_cast<int64_t>(blocks().size());
  std::set<uint64_t> damaged;
  for (int64_t d = 0; d < end; ++d)
    for (const int64_t f : {frame + d, frame - d}) {
      if (f < 0 || f >= end) continue;
      const BlockRef& block = blocks()[static_cast<size_t>(f)];
      if (block.stored == 0) return nullptr;
      if (damaged.contains(block.offset)) continue;
      try {
        return read(f);
      } catch (const Error& e) {
        if (e.code() == Code::memory_budget) throw;
        damaged.insert(block.offset);
      }
    }
  return nullptr;
}

FrameMaskPtr Masks::frame(int64_t counted) const {
  const int64_t frame = reader_->info().lattice.turned_frame(counted);
  if (blocks()[static_cast<size_t>(frame)].stored == 0) return nullptr;
  return reader_->salvages() ? read_nearest_whole(frame) : read(frame);
}

uint64_t Masks::count() const {
  std::map<uint64_t, uint64_t> of_block;
  uint64_t sum = 0;
  for (size_t f = 0; f < blocks().size(); ++f) {
    if (blocks()[f].stored == 0) continue;
    const auto [at, is_new] = of_block.try_emplace(blocks()[f].offset, 0);
    uint64_t& missing = at->second;
    try {
      if (is_new)
        reader_->mask_runs(channel_, f, [&](uint64_t begin, uint64_t end) { missing += end - begin; });
    } catch (const Error&) {
      // What is damaged is found by a check of the file, or by whoever looks there.
    }
    sum += missing;
  }
  return sum;
}

template<class Body>
void Masks::each_missing(std::span<const Vec4> points, const Context& context, const Body& body) const {
  context.tasks.parallel_for((points.size() + block_points - 1) / block_points, [&](uint64_t b) {
    context.progress.check();
    std::optional<int64_t> held; // frame
    FrameMaskPtr mask;
    for (size_t i = b * block_points; i < std::min<size_t>(points.size(), (b + 1) * block_points); ++i) {
      const Vec4& p = points[i];
      const double t = n_[3] == 1 ? 0 : p[3]; // a static volume ignores it
      if (!(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]) && std::isfinite(t))) continue;
      if (const int64_t f = counted_frame(t); f != held) mask = frame(f), held = f;
      if (mask && mask->at({nearest(p[0], 0), nearest(p[1], 1), nearest(p[2], 2)})) body(i);
    }
  });
}

uint64_t Masks::hide(std::span<const Vec4> points, std::span<float> values,
                     std::span<std::array<float, 4>> gradients, const Context& context) const {
  constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();
  std::atomic<uint64_t> hidden{0};
  each_missing(points, context, [&](size_t i) {
    hidden += !std::isnan(values[i]);
    values[i] = nan_value;
    if (!gradients.empty()) gradients[i].fill(nan_value);
  });
  return hidden;
}

void Masks::mark(std::span<const Vec4> points, std::span<uint8_t> missing, const Context& context) const {
  each_missing(points, context, [&](size_t i) { missing[i] = 1; });
}

SliceMask::SliceMask(const Masks& masks, const Vec4& origin, const std::array<Vec4, 3>& basis, int64_t first,
                     std::vector<FrameMaskPtr> frames)
    : n_(masks.samples()), periodic_(masks.periodic()), origin_(origin), basis_(basis), first_(first),
      frames_(std::move(frames)) {}

bool SliceMask::missing(const Vec3& uvw) const {
  std::array<int64_t, 4> at;
  for (size_t a = 0; a < 4; ++a) {
    const double p = origin_[a] + basis_[0][a] * uvw[0] + basis_[1][a] * uvw[1] + basis_[2][a] * uvw[2];
    at[a] = a == 3 && periodic_ ? counted_index(p) : nearest_of(p, n_[a]);
  }
  const auto last = first_ + static_cast<int64_t>(frames_.size()) - 1;
  const auto& frame = frames_[static_cast<size_t>(std::clamp(at[3], first_, last) - first_)];
  return frame && frame->at({at[0], at[1], at[2]}) &&
         std::all_of(others_.begin(), others_.end(), [&](const auto& m) { return m->missing(uvw); });
}

SliceMask SliceMask::also(std::vector<std::shared_ptr<const SliceMask>> others) const {
  SliceMask mask = *this;
  mask.others_ = std::move(others);
  return mask;
}

bool SliceMask::any() const {
  return std::any_of(frames_.begin(), frames_.end(),
                     [](const FrameMaskPtr& f) { return f && f->count() > 0; });
}

} // namespace bccsplat
