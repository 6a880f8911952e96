// SPDX-License-Identifier: Apache-2.0
// The one volume that a page looks at, as a host of the C API keeps it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "bccsplat.hpp"

namespace web {

using namespace bccsplat::client;

// What a picture is to show; the page sets it, and pictures are made of it.
struct Wishes {
  uint32_t channel = 0;
  int32_t mode = BCCSPLAT_MODE_COMPOSITE;
  int32_t quality = BCCSPLAT_QUALITY_NORMAL;
  bool shading = true, perspective = false;
  double iso = 0, turn_x = 0, turn_y = 0, zoom = 1, pan_x = 0, pan_y = 0; // pans: of the picture's height
  std::vector<double> colors, opacities; // as bccsplat_transfer_function has them
  double density = 1;
  std::vector<bccsplat_clip> clips;
};

// A moment that is cut; level -1: none.
struct Moment {
  Slice slice;
  double time = 0;
  uint32_t channel = 0;
  int level = -1;
  [[nodiscard]] bool is(double t, uint32_t c, int l) const {
    return slice && time == t && channel == c && level == l;
  }
};

struct Viewer {
  Device device;
  Volume volume;
  bccsplat_volume_info info{};
  std::array<bccsplat_axis, 3> axes{}; // where samples stand
  Wishes wishes;
  Moment moment, coarse; // what is drawn; the coarsest level, by which levels are chosen
  Moment samples; // what planes are made of where the moment would blend labels: indices are its places
  Renderer renderer;
  bccsplat_camera camera{};
  std::string text; // what the last call answered with

  void open(double bytes);
  // Cuts the moment of a time at the level that a picture of this size takes; of `preview` at the coarsest.
  // planes: what these are made of, too.
  void cut(double time, uint32_t width, uint32_t height, bool preview, bool planes);
  void fit(uint32_t width, uint32_t height);
  [[nodiscard]] bccsplat_render_options options() const;
};

extern Viewer viewer;

// Samples from the first place of an axis of the domain to its last one, which along a periodic axis is the
// first again.
[[nodiscard]] inline double samples_across(const bccsplat_volume_info& info, int axis) {
  return static_cast<double>(info.dims[axis]) - (info.periodic_axes >> axis & 1 ? 0 : 1);
}

// Runs the body; returns its status, with the text of a failure in viewer.text.
[[nodiscard]] int answer(void (*body)(const void*), const void* of);
template<class Body> [[nodiscard]] int answer(const Body& body) { // a std::function is larger
  return answer([](const void* of) { (*static_cast<const Body*>(of))(); }, &body);
}
// Puts the error of the current thread into viewer.text.
void note_error();

} // namespace web
