// SPDX-License-Identifier: Apache-2.0
#include "splat/tile/kept_sheets.h"

#include <new>
#include <utility>

namespace bccsplat {

std::unique_ptr<float[]> KeptTile::room(size_t count) {
  if (!view_->reserve(count * sizeof(float))) return nullptr;
  std::unique_ptr<float[]> floats(new (std::nothrow) float[count]);
  if (!floats) view_->too_large = true;
  return floats;
}

void KeptView::clear() {
  tiles.clear();
  complete = false;
  budget_->release(bytes_.exchange(0));
}

bool KeptView::reserve(uint64_t bytes) {
  // Each view has its half, so that it does not matter which of them came first.
  const uint64_t most = budget_->limit() / (2 * KeptSheets::most_of_budget);
  if (too_large || bytes_.load() + bytes > most || !budget_->try_reserve(bytes)) {
    too_large = true;
    return false;
  }
  bytes_ += bytes;
  return true;
}

KeptSheets::Use KeptSheets::begin_picture(const SplatScene& scene, const SplatOptions& options,
                                          const Context& context) {
  ViewKey key;
  key.slice = scene.slice, key.points = scene.points, key.view = *scene.view;
  key.mode = options.mode, key.shading = options.shading, key.reference_loops = options.reference_loops;
  key.gradient = options.gradient;
  key.preintegrate =
      options.preintegrate && !(options.shading && options.gradient == GradientMethod::fourth_order);
  key.kernel_form = options.kernel_form, key.raise = options.raise;
  key.tile_size = options.tile_size, key.threads = context.tasks.threads();
  if (views_[1] && views_[1]->key == key) std::swap(views_[0], views_[1]);
  if (!views_[0] || !(views_[0]->key == key)) {
    views_[1] = std::move(views_[0]);
    views_[0] = std::make_unique<KeptView>(key, context.memory);
    use_ = Use::draw;
  } else if (views_[0]->complete) {
    use_ = Use::take;
  } else {
    views_[0]->clear();
    use_ = views_[0]->too_large ? Use::draw : Use::keep;
  }
  current_ = views_[0].get();
  return use_;
}

void KeptSheets::set_tiles(size_t count) {
  if (use_ == Use::keep)
    for (size_t n = 0; n < count; ++n) current_->tiles.emplace_back(*current_);
}

void KeptSheets::finish_picture() {
  if (use_ != Use::keep) return;
  current_->complete = !current_->too_large;
  if (!current_->complete) current_->clear();
}

} // namespace bccsplat
