// SPDX-License-Identifier: Apache-2.0
// The finished sheets of a view, kept from picture to picture: under another transfer function, other lights
// or another iso value they are classified again, and no point is drawn.
//
// They are kept whole and before anything is classified: the picture that keeps them is drawn without what
// the transfer function and closed pixels would leave out. No skip changes a bit, so that pictures are the
// same with and without. A view keeps its sheets when it is drawn for the second time: one that moves on
// costs nothing. Two views are remembered (a draft and the accurate picture after it).
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/context.h"
#include "splat/plan/scene.h"
#include "view/pixel_rect.h"

namespace bccsplat {

class KeptView;

// The ring's sheets of one tile.
class KeptTile {
 public:
  struct Sheet {
    bool filled = false;
    PixelRect touched;                               // samples
    std::array<std::unique_ptr<float[]>, 4> samples; // by quantity: rows of `touched`, in whole vectors
  };
  explicit KeptTile(KeptView& view) : view_(&view) {}

  void begin_sheets(int64_t first_sheet) { first_ = first_sheet, sheets_.clear(); }
  // The sheet after the last one.
  Sheet& add_sheet() { return sheets_.emplace_back(); }
  [[nodiscard]] Sheet& sheet(int64_t k) { return sheets_[k - first_]; }
  // Returns room for `count` floats; null when the view may keep no more.
  [[nodiscard]] std::unique_ptr<float[]> room(size_t count);

 private:
  KeptView* view_;
  int64_t first_ = 0;
  std::vector<Sheet> sheets_;
};

// What the samples of sheets depend on.
struct ViewKey {
  const Slice* slice = nullptr;
  const SplatPoints* points = nullptr;
  SheetView view;
  RenderMode mode = RenderMode::composite;
  bool shading = false, reference_loops = false;
  GradientMethod gradient = GradientMethod::analytic;
  bool preintegrate = false; // and gradients do not look as far
  KernelForm kernel_form = KernelForm::exact;
  RaiseFilter raise;
  int tile_size = 0, threads = 0;
  bool operator==(const ViewKey&) const = default;
};

class KeptView {
 public:
  KeptView(const ViewKey& of, MemoryBudget& budget) : key(of), budget_(&budget) {}
  KeptView(const KeptView&) = delete;
  KeptView& operator=(const KeptView&) = delete;
  ~KeptView() { clear(); }

  void clear();
  // Any thread may call it. Once it has returned false, because there is no room, it does so always.
  [[nodiscard]] bool reserve(uint64_t bytes);

  const ViewKey key;
  std::vector<KeptTile> tiles;
  bool complete = false;
  std::atomic<bool> too_large{false};

 private:
  MemoryBudget* budget_;
  std::atomic<uint64_t> bytes_{0};
};

class KeptSheets {
 public:
  enum class Use : uint8_t { draw, keep, take };
  // Begins a picture. The slices and points of earlier pictures must be alive, or forget() have been called;
  // all pictures come with the same memory budget, which outlives this.
  Use begin_picture(const SplatScene& scene, const SplatOptions& options, const Context& context);
  // Must be called before tile(), for a picture that keeps or takes sheets.
  void set_tiles(size_t count);
  [[nodiscard]] KeptTile& tile(size_t n) { return current_->tiles[n]; }
  // The picture is done: what it kept is whole.
  void finish_picture();
  void forget() { views_ = {}, current_ = nullptr; }

  // Both views together take at most one part in so many of a budget's bytes.
  static constexpr uint64_t most_of_budget = 4;

 private:
  std::array<std::unique_ptr<KeptView>, 2> views_; // the latest first
  KeptView* current_ = nullptr;
  Use use_ = Use::draw;
};

} // namespace bccsplat
