// SPDX-License-Identifier: Apache-2.0
// A semi-transparent, shaded, orthographic picture from sheets by stencils, on one thread: what render()
// would draw, with its classification and shading.
#pragma once

#include <array>

#include "scene/picture.h"
#include "splat/tile/tile_memory.h"
#include "tests/bench/stencils/affine_raise.h"
#include "tests/bench/stencils/stencil_fill.h"

namespace bccsplat::bench {

struct StencilSettings {
  int tile = 124; // pixels a side at most
  int taps = 6;   // of both passes
  // The sheets are made before the first tile; else each tile makes the samples that it needs, four sheets at
  // a time.
  bool whole_sheets = true;
};

// Where the CPU time of a frame went, ms.
struct StencilTimes {
  double plan = 0, fill = 0, raise = 0, shade = 0, write = 0;
};

struct TileScratch {
  AlignedArray<float> planes, strip, window;
};

class StencilPicture {
 public:
  // The dense sites are made when a view asks for another axis than the one before.
  StencilPicture(const Scene& scene, const StencilSettings& settings) : scene_(scene), settings_(settings) {}

  void draw(Quality quality, Image& image);

  [[nodiscard]] const StencilTimes& times() const { return times_; } // of the last picture
  [[nodiscard]] double prepare_ms() const { return prepare_ms_; }    // of making the sites
  [[nodiscard]] const StencilView& view() const { return view_; }
  [[nodiscard]] const SampleSheets& sheets() const { return sheets_; }
  // Of samples: all sheets, or the window of a tile.
  [[nodiscard]] uint64_t sample_bytes() const {
    return settings_.whole_sheets ? sheets_.bytes() : scratch_.window.capacity() * sizeof(float);
  }
  [[nodiscard]] uint64_t site_bytes() const { return sites_.floats * sizeof(float); }

 private:
  const Scene& scene_;
  StencilSettings settings_;
  StencilView view_;
  SiteArray sites_;
  int margin_ = -1; // of the sites, planes
  SampleSheets sheets_;
  RaiseRows across_, down_;
  TileMemory memory_;
  TileScratch scratch_;
  StencilTimes times_;
  double prepare_ms_ = 0;

  void prepare_sites(int margin);
};

} // namespace bccsplat::bench
