// SPDX-License-Identifier: Apache-2.0
// What was sent to a GPU, from picture to picture: the fields of the last two pictures, what their looks need
// beside them, and the layers of a series that moments are merged of.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/context.h"
#include "draw/stats.h"
#include "gpu/gpu_device.h"
#include "gpu/gpu_kept.h"
#include "gpu/gpu_moment.h"
#include "gpu/gpu_picture.h"
#include "gpu/object_look.h"

namespace bccsplat {

// One field of a picture.
struct GpuField {
  SliceMark mark;     // of a slice that was sent, or of a moment that is corrected
  GpuMomentKey key;   // of a moment
  FieldBricks bricks; // without their values, once these were sent
  size_t count = 0;   // bricks, the one of zeros included
  // What a moment is merged of: its layers, which may have been dropped and sent again, and their weights.
  std::vector<const GpuLayer*> now;
  std::vector<float> weights;
  std::optional<GpuMoment> moment;
};

// The fields of a picture: one, or several whose sites are in one buffer or texture, field after field.
struct GpuFields {
  std::vector<GpuField> field;
  ObjectBricks placed; // of several
  uint64_t bytes = 0;  // on the GPU
  std::optional<GpuSites> sites;
  std::optional<GpuClasses> classes;
  std::vector<GpuClassKey> keys;
  std::vector<int> table_row; // where each field's table begins

  [[nodiscard]] bool several() const { return field.size() > 1; }
  [[nodiscard]] const FieldBricks& all() const { return several() ? placed.all : field.front().bricks; }
  [[nodiscard]] ObjectPlace place(size_t n) const { return several() ? placed.places[n] : ObjectPlace{}; }
};

class GpuScene {
 public:
  explicit GpuScene(GpuDevice& device) : device_(device) {}
  GpuScene(const GpuScene&) = delete;
  GpuScene& operator=(const GpuScene&) = delete;
  ~GpuScene() { drop_all(); }

  // Returns the fields of objects that not_on_gpu() lets pass, for set(), which sends what of them is not
  // there, merges moments, and brings their looks. Throws GpuFailure, memory_budget, cancelled.
  const GpuFields& find(std::span<const GpuObject> objects, const Context& context, DrawStats& stats);
  // The objects are those that were found last. tables: of each.
  void set(std::span<const GpuObject> objects, std::span<const ClassTable> tables);
  // Lets go of all of it.
  void forget() { drop_all(), too_large_ = 0; }

 private:
  using Moments = std::vector<const MomentPlan*>; // of a picture, whose layers stay
  [[nodiscard]] const MomentPlan* moment_of(const Slice& slice, bool alone) const;
  void find_fields(std::span<const GpuObject> objects, const Context& context, DrawStats& stats);
  // What is known of a field before anything is made of it. moment: null where it is sent.
  GpuField describe(const Slice& slice, const MomentPlan* moment, const Moments& needed,
                    const Context& context, DrawStats& stats);
  // Finds the layers of a moment, in the order of its parts; sends those that are not there.
  std::vector<const GpuLayer*> find_layers(const Slice& slice, const MomentPlan& moment,
                                           const Moments& needed, const Context& context, DrawStats& stats);
  std::unique_ptr<GpuLayer> send_layer(const Slice& slice, const MomentPlan& moment,
                                       const MomentPlan::Part& part, const Moments& needed,
                                       const Context& context);
  // Drops layers that are not needed, the latest used last, until so many bytes fit and not too many are
  // there, and where that does not do what is kept of pictures.
  void make_room(const Moments& needed, uint64_t bytes);
  void keep(std::unique_ptr<GpuFields> fresh);
  void drop(std::unique_ptr<GpuFields>& kept);
  void drop_all();

  GpuDevice& device_;
  std::array<std::unique_ptr<GpuFields>, 2> kept_; // the latest first
  std::vector<std::unique_ptr<GpuLayer>> layers_;  // the latest used first
  uint64_t too_large_ = 0;                         // a series whose layers find no room
};

} // namespace bccsplat
