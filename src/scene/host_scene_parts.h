// SPDX-License-Identifier: Apache-2.0
// What a host's scene keeps of its instances, and of a picture that it draws in several calls.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "base/memory.h"
#include "draw/image.h"
#include "scene/drawers.h"
#include "scene/host_scene.h"
#include "scene/minify.h"
#include "slice/part.h"

namespace bccsplat {

// A slice, with what pictures of it keep whatever draws them.
struct CutPart {
  OpenSlice open;
  Affine3 slice_to_world; // before the instance is placed
  std::unique_ptr<SliceKeep> kept = std::make_unique<SliceKeep>();

  CutPart() = default;
  explicit CutPart(OpenSlice cut) : open(std::move(cut)), slice_to_world(open.slice.slice_to_world) {}
  [[nodiscard]] bool is_at(const Affine3& placement) const {
    return open.slice.slice_to_world == placement.after(slice_to_world);
  }
  // Returns whether the placement is another one than before.
  bool place(const Affine3& placement);
};

// What is cut of an instance.
struct SceneCut : CutPart {
  explicit SceneCut(OpenSlice cut) : CutPart(std::move(cut)) {}
  double frame = 0;
  std::optional<CutPart> color; // of the channel that says the colours
  std::optional<Trail> trail;   // of the slice in its place
  Drawers drawers;
};

struct HostScene::Placed {
  Instance instance;
  std::unique_ptr<SceneCut> fine, coarse; // of complete pictures, and of the first ones within a budget
};

// The part of an instance that a view shows.
struct HostScene::Need {
  uint64_t id = 0;
  Placed* placed = nullptr;
  double frame = 0;
  uint32_t level = 0;
  std::optional<IndexBox> box; // none: all of it
  Sight sight;                 // with the clips that cut it

  // interval: with the frames around the moment, relative to it.
  [[nodiscard]] SliceRequest request(uint32_t channel, const std::array<double, 2>& interval = {0, 0}) const;
  [[nodiscard]] bool met_by(const std::unique_ptr<SceneCut>& cut) const;
  // Whether all that is drawn of it is cut, and in its place.
  [[nodiscard]] bool ready(const std::unique_ptr<SceneCut>& cut) const;
};

// A picture under way: which one, and how far it is.
struct HostScene::Frame {
  struct Key {
    uint64_t version = 0, depths = 0;
    double time = 0;
    int width = 0, height = 0;
    std::array<bool, 3> planes{}; // depth, value, time: whether they are drawn
    Sight sight;
    RenderOptions options;
    std::optional<double> gradient_noise;
    bool operator==(const Key&) const = default;
  };
  std::optional<Key> key;             // none: none is under way
  int rows = 0;                       // that are complete
  double allowance_ms = 0;            // for cutting, more each time that it was not enough
  double spent_ms = 0;                // on it so far, but for its coarse picture
  std::optional<double> complete_ms;  // what the last complete picture took
  double row_ms = 0;                  // what a row of the last band took; 0: none was drawn
  std::unique_ptr<ImageStorage> done; // the picture so far, without the background
  Reservation memory;                 // of it

  // Makes room for a picture like this one.
  void begin(const Image& image, const Context& context);
  void forget() { key.reset(), done.reset(), memory = {}; }
};

// Makes of it a picture of nothing.
void clear(Image& image);

} // namespace bccsplat
