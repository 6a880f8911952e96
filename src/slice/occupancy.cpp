// SPDX-License-Identifier: Apache-2.0
#include "slice/occupancy.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {
namespace {

constexpr int cell_edge = 4; // sites: smaller cells leave out more and take more memory
constexpr int brick_cells = brick_edge / cell_edge; // per axis

} // namespace

void Occupancy::add(int32_t layer, const BrickLayer& points) {
  Layer& l = layers_[layer];
  for (size_t slot = 0; slot < points.brick_slots(); ++slot) {
    const Brick* brick = points.brick(slot);
    if (!brick) continue;
    if (l.used.empty()) {
      for (size_t a = 0; a < 3; ++a) l.cells[a] = points.brick_dims()[a] * brick_cells;
      l.used.resize(static_cast<size_t>(l.cells[0]) * l.cells[1] * l.cells[2]);
    }
    const Int3 b = points.slot_position(slot);
    for (size_t row = 0; row < brick_rows; ++row) {
      const unsigned bits = brick->kept[row] | (brick->hole ? (*brick->hole)[row] : 0u);
      if (bits == 0) continue;
      const size_t y = b[1] * brick_cells + row % brick_edge / cell_edge;
      const size_t z = b[2] * brick_cells + row / brick_edge / cell_edge;
      const size_t first = (z * l.cells[1] + y) * l.cells[0] + b[0] * brick_cells;
      for (size_t x = 0; x < brick_cells; ++x)
        if (bits >> (cell_edge * x) & 15) l.used[first + x] = true;
    }
  }
}

bool Occupancy::any(const Vec4& low, const Vec4& high) const {
  // What a box meets beyond an end is the image of as much inside.
  std::array<std::array<double, 2>, 4> planes; // in plane numbers
  for (size_t a = 0; a < 4; ++a) {
    const double step = a < 3 ? lattice_.space_step[a] : lattice_.time_step;
    const double last = a < 3 ? lattice_.space.last[a] : lattice_.last_layer;
    const double zero = a < 3 ? lattice_.before[a] : lattice_.lead;
    const double from = low[a] / step + zero, to = high[a] / step + zero;
    planes[a] = {std::max(0.0, std::min(from, 2 * last - to)), std::min(last, std::max(to, -from))};
    if (a == 3 && lattice_.periodic) planes[a] = {from, std::min(to, from + last)};
    // Across the end of a periodic axis of space all of it counts.
    if (a < 3 && lattice_.turns(a) && (from < 0 || to > last)) planes[a] = {0, last};
  }
  const auto first_layer = static_cast<int32_t>(std::ceil(planes[3][0]));
  const auto last_layer = static_cast<int32_t>(std::floor(planes[3][1]));
  for (int32_t m = first_layer; m <= last_layer; ++m) {
    const Layer& l = layers_[lattice_.mirror_layer(m)];
    if (l.used.empty()) continue;
    std::array<int, 3> first, end;
    for (size_t a = 0; a < 3; ++a) {
      const int coset = lattice_.coset(m), per_site = lattice_.space.bcc ? 2 : 1;
      const auto site = [&](double plane) { return (plane - coset) / per_site; };
      first[a] = std::max(0, static_cast<int>(std::ceil(site(planes[a][0]))) / cell_edge);
      end[a] = std::min(l.cells[a], static_cast<int>(std::floor(site(planes[a][1]))) / cell_edge + 1);
    }
    for (int z = first[2]; z < end[2]; ++z)
      for (int y = first[1]; y < end[1]; ++y) {
        const size_t row = (static_cast<size_t>(z) * l.cells[1] + y) * l.cells[0];
        for (int x = first[0]; x < end[0]; ++x)
          if (l.used[row + x]) return true;
      }
  }
  return false;
}

std::optional<HeldSamples> HeldSamples::read(const SampleSource& source, int channel, const BrickBox& region,
                                             uint64_t limit, const Context& context) {
  HeldSamples held(source);
  uint64_t sum = 0;
  for (int32_t m = 0; m < source.lattice().layers(); ++m) {
    context.progress.advance(m, source.lattice().layers());
    held.layers_.push_back(source.read_layer(channel, m, region, context));
    const uint64_t bytes = held.layers_.back().bytes();
    sum += bytes;
    if (sum > limit || !context.memory.try_reserve(bytes)) return std::nullopt;
    held.memory_.push_back(Reservation::adopt(context.memory, bytes));
  }
  return held;
}

} // namespace bccsplat
