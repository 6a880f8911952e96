// SPDX-License-Identifier: Apache-2.0
// What a picture needs of a volume before its slice is made: how fine a level, and which box. Both follow
// from the camera and the place of a slice, whatever it is made of.
#pragma once

#include <optional>
#include <span>

#include "field/slice.h"
#include "formats/bcc4/level_error.h"
#include "scene/picture.h"
#include "slice/part.h"
#include "view/camera.h"
#include "volume/open_volume.h"

namespace bccsplat {

// Returns how many lattice distances of `lattice` a pixel covers at the centre of the domain, in the
// direction in which these are fewest. The slice is one in time, of any level of the volume that the lattice
// is a level of.
[[nodiscard]] double distances_per_pixel(const Slice& slice, const Lattice4& lattice, const Sight& sight,
                                         int width, int height);

// A level of a volume as pictures see it.
struct LevelOption {
  double per_pixel = 0;            // distances_per_pixel
  std::optional<LevelError> error; // none: not measured
};

// Returns the coarsest of the levels, the finest first, that draws the picture as well as its quality asks:
// one of which a pixel covers a lattice distance or more, as a slice of level 0 would be made coarser for it
// (minify.h); or a fifth of it in a draft, a third in a normal picture, where the level's errors leave
// the picture as good as its quality is. Pictures that no coarser slice is drawn for get level 0.
[[nodiscard]] int enough_level(std::span<const LevelOption> levels, const RenderOptions& options);

// Returns the box of source samples that is seen of a time slice, a little more on all sides; none where
// nothing of it is.
[[nodiscard]] std::optional<IndexBox> seen_box(const Slice& slice, const Sight& sight, int width, int height);

// What a picture of a channel at a moment needs of its volume. The slice is one in time, of any level, or its
// place alone.
struct PictureNeeds {
  int level = 0;                  // that is enough
  double distances_per_pixel = 0; // of level 0
  bool seen = false;              // whether the camera sees anything
  IndexBox box;                   // of what it sees; all where it sees nothing
};
[[nodiscard]] PictureNeeds picture_needs(const OpenVolume& volume, uint32_t channel, const Slice& slice,
                                         const Sight& sight, int width, int height,
                                         const RenderOptions& options);

} // namespace bccsplat
