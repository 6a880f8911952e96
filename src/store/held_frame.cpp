// SPDX-License-Identifier: Apache-2.0
// Copies what a grid has of each box of a frame, packed in the box's own type, and widens rows when they are
// asked for.
#include "store/held_frame.h"

#include <algorithm>
#include <cstring>

#include "base/half.h"
#include "fit/frame/unpack.h"

namespace bccsplat {
namespace {

template<class T> void widen(const std::byte* data, int64_t count, double* out) {
  for (int64_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, data + i * sizeof(T), sizeof(T));
    out[i] = value;
  }
}

void widen_halves(const std::byte* data, int64_t count, double* out) {
  for (int64_t i = 0; i < count; ++i) {
    uint16_t bits;
    std::memcpy(&bits, data + 2 * i, 2);
    out[i] = half_to_float(bits);
  }
}

void widen_row(SourceType type, const std::byte* data, int64_t count, double* out) {
  switch (type) {
  case SourceType::u8:
    return widen<uint8_t>(data, count, out);
  case SourceType::i8:
    return widen<int8_t>(data, count, out);
  case SourceType::u16:
    return widen<uint16_t>(data, count, out);
  case SourceType::i16:
    return widen<int16_t>(data, count, out);
  case SourceType::u32:
    return widen<uint32_t>(data, count, out);
  case SourceType::i32:
    return widen<int32_t>(data, count, out);
  case SourceType::f16:
    return widen_halves(data, count, out);
  case SourceType::f32:
    return widen<float>(data, count, out);
  case SourceType::f64:
    return widen<double>(data, count, out);
  case SourceType::unknown:
    break;
  }
}

std::array<int64_t, 3> packed_strides(const FrameBox& b) {
  const int64_t size = source_bytes(b.type);
  return {size, size * b.dims[0], size * b.dims[0] * b.dims[1]};
}

// The number of the first sample at or behind i whose index `every` divides.
int64_t number_from(int64_t i, int64_t every) { return (i + every - 1) / every; }

// The samples of a box that the grid has, counted in it; its dims may be 0.
FrameBox thinned(FrameBox box, const HeldGrid& grid) {
  const auto stride = box.stride == std::array<int64_t, 3>{} ? packed_strides(box) : box.stride;
  const auto* data = static_cast<const std::byte*>(box.data);
  for (size_t a = 0; a < 3; ++a) {
    const int64_t first = std::max(number_from(box.begin[a], grid.every), grid.begin[a]);
    const int64_t end =
        std::min(number_from(box.begin[a] + box.dims[a], grid.every), grid.begin[a] + grid.dims[a]);
    data += (first * grid.every - box.begin[a]) * stride[a];
    box.begin[a] = first - grid.begin[a], box.dims[a] = std::max<int64_t>(end - first, 0);
    box.stride[a] = stride[a] * grid.every;
  }
  box.data = data;
  return box;
}

} // namespace

HeldGrid held_grid(const Region& region, int64_t every) {
  HeldGrid grid;
  grid.every = every;
  for (size_t a = 0; a < 3; ++a) {
    grid.begin[a] = number_from(region.begin[a], every);
    grid.dims[a] = number_from(region.end[a], every) - grid.begin[a];
  }
  return grid;
}

HeldFrame::HeldFrame(std::span<const FrameBox> boxes, double air, MemoryBudget& memory, const HeldGrid& grid)
    : grid_(grid), air_(air) {
  std::vector<FrameBox> held;
  uint64_t bytes = 0;
  for (const FrameBox& whole : boxes) {
    const FrameBox b = thinned(whole, grid);
    const uint64_t samples = b.dims[0] * b.dims[1] * b.dims[2];
    if (samples == 0) continue;
    held.push_back(b);
    bytes += source_bytes(b.type) * samples;
  }
  memory_ = Reservation(memory, bytes, "source frames kept to measure the error");
  for (const FrameBox& b : held) {
    const std::array<int64_t, 3> packed = packed_strides(b), &stride = b.stride;
    const int64_t size = packed[0];
    Box box{b.type, b.begin, b.dims, {}};
    box.data.resize(packed[2] * b.dims[2]);
    const auto* from = static_cast<const std::byte*>(b.data);
    std::byte* to = box.data.data();
    for (int64_t z = 0; z < b.dims[2]; ++z)
      for (int64_t y = 0; y < b.dims[1]; ++y, to += packed[1]) {
        const std::byte* row = from + z * stride[2] + y * stride[1];
        if (stride[0] == size)
          std::memcpy(to, row, packed[1]);
        else
          for (int64_t x = 0; x < b.dims[0]; ++x) std::memcpy(to + x * size, row + x * stride[0], size);
      }
    boxes_.push_back(std::move(box));
  }
}

void HeldFrame::plane(int64_t z, double* out) const {
  const int64_t nx = grid_.dims[0], ny = grid_.dims[1];
  std::fill_n(out, nx * ny, air_);
  for (const Box& b : boxes_) {
    if (z < b.begin[2] || z >= b.begin[2] + b.dims[2]) continue;
    const auto row = static_cast<int64_t>(source_bytes(b.type)) * b.dims[0];
    const std::byte* data = b.data.data() + (z - b.begin[2]) * b.dims[1] * row;
    for (int64_t y = 0; y < b.dims[1]; ++y)
      widen_row(b.type, data + y * row, b.dims[0], out + (b.begin[1] + y) * nx + b.begin[0]);
  }
}

} // namespace bccsplat
