// SPDX-License-Identifier: Apache-2.0
#include "gpu/object_bricks.h"

#include <algorithm>

namespace bccsplat {
namespace {

// Boxes of one size, as many along each axis: textures are as short along each as they can be.
struct Shelf {
  int along = 1;
  explicit Shelf(size_t objects) {
    while (static_cast<size_t>(along) * along * along < objects) ++along;
  }
  [[nodiscard]] Int3 place(size_t n, const Int3& box) const {
    const int at = static_cast<int>(n);
    return {at % along * box[0], at / along % along * box[1], at / (along * along) * box[2]};
  }
  [[nodiscard]] Int3 size(size_t objects, const Int3& box) const {
    const int layers = (static_cast<int>(objects) + along * along - 1) / (along * along);
    return {along * box[0], along * box[1], layers * box[2]};
  }
};

void include(Int3& box, const Int3& size) {
  for (size_t a = 0; a < 3; ++a) box[a] = std::max(box[a], size[a]);
}

Int3 brick_box(const FieldBricks& b) { return {b.bricks[0], b.bricks[1], b.cosets() * b.bricks[2]}; }

// Copies a box into a larger one; each(value) is what comes there.
template<class T, class Each>
void copy_box(const std::vector<T>& from, const Int3& size, const Int3& at, const Int3& whole,
              std::vector<T>& to, const Each& each) {
  size_t n = 0;
  for (int z = 0; z < size[2]; ++z)
    for (int y = 0; y < size[1]; ++y)
      for (int x = 0; x < size[0]; ++x, ++n)
        to[(static_cast<size_t>(at[2] + z) * whole[1] + at[1] + y) * whole[0] + at[0] + x] = each(from[n]);
}

} // namespace

ObjectBricks place_objects(const std::vector<const FieldBricks*>& objects,
                           const std::vector<size_t>& counts) {
  ObjectBricks out;
  Int3 bricks{}, cells{};
  for (const FieldBricks* b : objects) include(bricks, brick_box(*b)), include(cells, b->cells);
  const Shelf shelf(objects.size());
  out.all.border = objects.front()->border, out.all.edge = objects.front()->edge;
  out.all.bricks = shelf.size(objects.size(), bricks), out.all.cells = shelf.size(objects.size(), cells);
  out.all.brick_at.resize(static_cast<size_t>(out.all.bricks[0]) * out.all.bricks[1] * out.all.bricks[2]);
  for (size_t n = 0; n < objects.size(); ++n) {
    const auto first = static_cast<uint32_t>(out.count);
    out.places.push_back({shelf.place(n, bricks), shelf.place(n, cells), first});
    copy_box(objects[n]->brick_at, brick_box(*objects[n]), out.places[n].bricks, out.all.bricks,
             out.all.brick_at, [&](uint32_t brick) { return brick == 0 ? 0 : first + brick; });
    out.count += counts[n];
  }
  return out;
}

void place_cells(const ObjectBricks& objects, size_t n, const Int3& cells, const std::vector<uint8_t>& from,
                 std::vector<uint8_t>& all) {
  const Int3& whole = objects.all.cells;
  all.resize(static_cast<size_t>(whole[0]) * whole[1] * whole[2]);
  copy_box(from, cells, objects.places[n].cells, whole, all, [](uint8_t around) { return around; });
}

} // namespace bccsplat
