// SPDX-License-Identifier: Apache-2.0
// What somebody wants to see.
#pragma once

#include "viewer/surfaces.h"

#include <bccsplat.hpp>

#include <array>
#include <vector>

namespace viewer {

using bccsplat::client::Handle;
using bccsplat::client::sized;

struct Cancelled {};
// Throws what went wrong, or Cancelled when a newer wish ended the call.
void check(bccsplat_status status);

constexpr int curve_points = 9; // of the transfer function, evenly spread over the range of values

// Everything a picture depends on.
struct Wish {
  double frame = 0;
  std::array<double, 3> tilt{}; // frames later from one end of x, y, z to the other
  double rotate_x = 20, rotate_y = 30, zoom = 1;
  std::array<float, curve_points> opacity{};
  int palette = 0;
  bool iso = false; // the surfaces instead of the transfer function's opacities
  std::vector<Surface> surfaces;
  bool trail = false;
  double trail_frames = 4;
  std::array<bool, 3> open{};                // cut away along x, y, z of the world ...
  std::array<double, 3> open_to{.5, .5, .5}; // ... up to this part of the box
  bool playing = false;                      // drafts only, and what the next moment needs is made meanwhile
  double step = 0;                           // to the next moment, about
  int width = 0, height = 0;
  bool operator==(const Wish&) const = default;

  // Whether it is a moment, which a scene draws; other planes and trails are a renderer's.
  [[nodiscard]] bool upright() const { return tilt == std::array<double, 3>{}; }
  [[nodiscard]] bool of_scene() const { return upright() && !trail; }
};

// The transfer function of a wish over a range of values, with what it points to.
struct Look {
  std::vector<double> colors, opacities;
  bccsplat_transfer_function function = sized<bccsplat_transfer_function>();

  Look(const Wish& wish, const std::array<double, 2>& range);
  Look(const Look&) = delete;
  Look& operator=(const Look&) = delete;
};

// The render options of a wish, but for their quality, with what they point to.
struct Options {
  std::vector<bccsplat_iso_surface> surfaces;
  bccsplat_render_options options = sized<bccsplat_render_options>();

  Options(const Wish& wish, bccsplat_quality quality, bccsplat_cancel_token* token);
  Options(const Options&) = delete;
  Options& operator=(const Options&) = delete;
};

// The clips that cut a box (x0 y0 z0 x1 y1 z1) open as a wish asks.
[[nodiscard]] std::vector<bccsplat_clip> clips_of(const Wish& wish, const double (&box)[6]);

} // namespace viewer
