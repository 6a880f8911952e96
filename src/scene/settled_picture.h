// SPDX-License-Identifier: Apache-2.0
// What a shot refers to while a picture is drawn: the level of the slice and its view, by the camera and the
// quality; the table of the transfer function; the trail's views and tables; and the drawer. Pictures of
// several slices on the same sheets are one once each is settled.
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "draw/shot.h"
#include "draw/tile_pixels.h"
#include "scene/picture.h"
#include "view/view.h"

namespace bccsplat {

// Scene, options, context and image outlive it.
class SettledPicture {
 public:
  SettledPicture(const Scene& scene, const RenderOptions& options, const Context& context, Image& image)
      : scene_(scene), options_(options), context_(context), image_(image) {}
  SettledPicture(const SettledPicture&) = delete;
  SettledPicture& operator=(const SettledPicture&) = delete;

  // These settle the shot, in this order. Sheets are as far from each other as slice and quality ask for;
  // `sheets_apart`, a world length, overrides that for pictures that share their sheets.
  void settle_level();
  void settle_view(std::optional<double> sheets_apart = std::nullopt);
  void settle_look();
  void settle_paint();
  void settle_light();
  void settle_trail();
  void settle_trail(const Trail& trail);
  // Draws another one in the same picture, of mode composite, which is settled so far, too, and outlives
  // this.
  void join(SettledPicture& other) { all_.push_back(&other), shots_.push_back(&other.shot_); }
  void settle_drawer();

  // World lengths, once the level is settled: how far sheets are from each other, and the nearest that they
  // may be.
  [[nodiscard]] double sheets_apart() const { return step_ * seen_->world_per_unit(); }
  [[nodiscard]] double least_apart() const;

  [[nodiscard]] const Shot& shot() const { return shot_; }
  [[nodiscard]] const char* drawer() const { return drawer_ ? drawer_->name() : "reference"; }
  RenderStats draw();
  // Draws by the reference, whose samples are `reference` lattice units apart; field: null for the slice's.
  // Nothing but this need be settled.
  RenderStats draw_truth(const FieldAt* field, const ReferenceOptions* reference);

  [[nodiscard]] int level() const { return level_; }
  std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();

 private:
  const Scene& scene_;
  const RenderOptions& options_;
  const Context& context_;
  Image& image_;
  int level_ = 0;
  double step_ = 0; // T of the slice that is drawn
  std::optional<SliceView> seen_;
  SheetView view_;
  [[nodiscard]] bool smooths_edges() const {
    return options_.smooth_edges && !scene_.trail && !scene_.paint && !image_.deep && !options_.target;
  }
  [[nodiscard]] Drawers& drawers() { return scene_.drawers ? *scene_.drawers : of_picture_; }
  [[nodiscard]] Drawer& choose_drawer(Backend backend);
  DrawStats draw_tiles(RenderStats& stats, const std::function<void(const TilePixels&)>& emit);

  ClassTable table_;
  const Trail* settled_trail_ = nullptr; // that the shot's is of
  ShotTrail trail_;
  ShotPaint paint_;
  SheetView paint_view_;
  TransferFunction paint_function_;
  ClassTable paint_table_;
  std::shared_ptr<const LightVolume> light_;
  std::deque<SheetView> moved_; // of the trail's sources with a domain of their own
  Shot shot_;
  std::vector<SettledPicture*> all_{this}; // that are drawn into the picture
  std::vector<const Shot*> shots_{&shot_};
  Drawers of_picture_; // where nothing is kept
  Drawer* drawer_ = nullptr;
};

// Writes finished pixels into the planes that an image has.
void write_tile(const TilePixels& tile, const SheetView& view, Image& image);
// Tells an image that they are there.
void tell_drawn(const TilePixels& tile, const Image& image);

} // namespace bccsplat
