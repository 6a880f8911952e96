// SPDX-License-Identifier: Apache-2.0
// Checks the boxes of a frame and reads rows of it, finding boxes by the cells of a coarse grid.
#include "fit/frame/frame.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/sizes.h"
#include "fit/frame/unpack.h"

namespace bccsplat {
namespace {

constexpr int64_t cell_edge = 32; // samples, of the grid that finds boxes: a finer one has more cells to fill

// Calls body(cell) for the cells that `region` touches.
template<class Body>
void for_cells(const Region& region, const std::array<int64_t, 3>& cells, const Body& body) {
  for (int64_t z = region.begin[2] / cell_edge; z <= (region.end[2] - 1) / cell_edge; ++z)
    for (int64_t y = region.begin[1] / cell_edge; y <= (region.end[1] - 1) / cell_edge; ++y)
      for (int64_t x = region.begin[0] / cell_edge; x <= (region.end[0] - 1) / cell_edge; ++x)
        body((z * cells[1] + y) * cells[0] + x);
}

} // namespace

Region Region::cut(const Region& other) const {
  Region r;
  for (size_t a = 0; a < 3; ++a) {
    r.begin[a] = std::max(begin[a], other.begin[a]);
    r.end[a] = std::min(end[a], other.end[a]);
  }
  return r;
}

Region Region::joined(const Region& other) const {
  if (empty()) return other;
  Region r = *this;
  for (size_t a = 0; a < 3 && !other.empty(); ++a) {
    r.begin[a] = std::min(r.begin[a], other.begin[a]);
    r.end[a] = std::max(r.end[a], other.end[a]);
  }
  return r;
}

Frame::Frame(std::span<const FrameBox> boxes, const std::array<int64_t, 3>& dims, double air,
             const std::string& what)
    : dims_(dims), given_{{}, dims}, air_(air) {
  for (size_t b = 0; b < boxes.size(); ++b) {
    FrameBox box = boxes[b];
    const int64_t bytes = source_bytes(box.type);
    if (bytes == 0) fail(Code::invalid_argument, what, ": box ", b, " has no known value type");
    bool empty = false;
    for (size_t a = 0; a < 3; ++a) {
      if (box.begin[a] < 0 || box.dims[a] < 0 || box.dims[a] > dims[a] ||
          box.begin[a] > dims[a] - box.dims[a])
        fail(Code::invalid_argument, what, ": box ", b, " covers ", box.begin[a], " .. ", box.begin[a], " + ",
             box.dims[a], " along ", "xyz"[a], ", the frame has ", dims[a], " samples there");
      empty = empty || box.dims[a] == 0;
    }
    if (empty) continue;
    if (!box.data) fail(Code::invalid_argument, what, ": box ", b, " has no data");
    if (box.stride == std::array<int64_t, 3>{})
      box.stride = {bytes, bytes * box.dims[0], bytes * box.dims[0] * box.dims[1]};
    boxes_.push_back(box);
  }
  if (boxes_.size() > UINT32_MAX) fail(Code::limit_exceeded, what, ": more than 2^32 boxes");

  if (boxes_.size() > 8) // few boxes are found by looking at each
    for (size_t a = 0; a < 3; ++a) cells_[a] = (dims_[a] + cell_edge - 1) / cell_edge;
  const size_t count = cells_[0] * cells_[1] * cells_[2];
  cell_begin_.assign(count + 1, 0);
  const auto visit = [&](const FrameBox& box, const auto& body) {
    if (count == 1)
      body(size_t{0});
    else
      for_cells(region(box), cells_, body);
  };
  for (const FrameBox& box : boxes_) visit(box, [&](size_t c) { ++cell_begin_[c + 1]; });
  uint64_t total = 0;
  for (size_t c = 1; c <= count; ++c) {
    total += cell_begin_[c];
    if (total > UINT32_MAX) fail(Code::limit_exceeded, what, ": too many boxes");
    cell_begin_[c] = static_cast<uint32_t>(total);
  }
  members_.resize(total);
  std::vector<uint32_t> next(cell_begin_.begin(), cell_begin_.end() - 1);
  for (size_t b = 0; b < boxes_.size(); ++b)
    visit(boxes_[b], [&](size_t c) { members_[next[c]++] = static_cast<uint32_t>(b); });
}

Region Frame::region(const FrameBox& box) const {
  Region r;
  for (size_t a = 0; a < 3; ++a) {
    r.begin[a] = box.begin[a];
    r.end[a] = box.begin[a] + box.dims[a];
  }
  return r;
}

const std::byte* Frame::sample(const FrameBox& box, int64_t x, int64_t y, int64_t z) const {
  return static_cast<const std::byte*>(box.data) + (x - box.begin[0]) * box.stride[0] +
         (y - box.begin[1]) * box.stride[1] + (z - box.begin[2]) * box.stride[2];
}

void Frame::clamp(float low, float high) {
  clamps_ = true;
  clamp_low_ = low;
  clamp_high_ = high;
}

void Frame::patch(const Region& region, std::vector<float> values) {
  patch_region_ = region;
  patch_ = std::move(values);
}

void Frame::read_row(const FrameBox& box, const Region& part, int64_t y, int64_t z, float* out) const {
  const size_t width = part.length(0);
  unpack_row(box.type, sample(box, part.begin[0], y, z), box.stride[0], width, air_, out);
  if (!clamps_) return;
  for (size_t x = 0; x < width; ++x)
    if (!std::isfinite(out[x])) out[x] = std::isnan(out[x]) ? 0 : out[x] > 0 ? clamp_high_ : clamp_low_;
}

std::vector<uint32_t> Frame::boxes_in(const Region& region) const {
  std::vector<uint32_t> found;
  if (cell_begin_.size() == 2)
    found = members_;
  else {
    for_cells(region, cells_, [&](size_t c) {
      found.insert(found.end(), members_.begin() + cell_begin_[c], members_.begin() + cell_begin_[c + 1]);
    });
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
  }
  std::erase_if(found, [&](uint32_t b) { return region.cut(this->region(boxes_[b])).empty(); });
  return found;
}

void Frame::read(std::span<const uint32_t> boxes, const Region& region, float* out, int64_t row,
                 int64_t plane) const {
  if (region.cut(given_) != region)
    fail(Code::internal, "samples of a frame are read that were not asked for, from (", region.begin[0], ", ",
         region.begin[1], ", ", region.begin[2], ") on");
  const auto target = [&](int64_t x, int64_t y, int64_t z) {
    return out + (z - region.begin[2]) * plane + (y - region.begin[1]) * row + x - region.begin[0];
  };
  const bool covered =
      boxes.size() == 1 && region.cut(this->region(boxes_[boxes[0]])).samples() == region.samples();
  if (!covered)
    for (int64_t z = region.begin[2]; z < region.end[2]; ++z)
      for (int64_t y = region.begin[1]; y < region.end[1]; ++y)
        std::fill_n(target(region.begin[0], y, z), region.length(0), 0.0f);
  for (const uint32_t b : boxes) {
    const Region part = region.cut(this->region(boxes_[b]));
    for (int64_t z = part.begin[2]; z < part.end[2]; ++z)
      for (int64_t y = part.begin[1]; y < part.end[1]; ++y)
        read_row(boxes_[b], part, y, z, target(part.begin[0], y, z));
  }
  const Region part = region.cut(patch_region_);
  if (part.empty()) return;
  for (int64_t z = part.begin[2]; z < part.end[2]; ++z)
    for (int64_t y = part.begin[1]; y < part.end[1]; ++y) {
      const int64_t from =
          ((z - patch_region_.begin[2]) * patch_region_.length(1) + y - patch_region_.begin[1]) *
              patch_region_.length(0) +
          part.begin[0] - patch_region_.begin[0];
      std::copy_n(patch_.begin() + from, part.length(0), target(part.begin[0], y, z));
    }
}

} // namespace bccsplat
