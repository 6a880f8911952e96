// SPDX-License-Identifier: Apache-2.0
// What the sheets of a picture are made of, and how.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "draw/shot.h"
#include "field/lattice_sums.h"
#include "field/slice.h"
#include "kernel/drawn_kernel.h"
#include "shade/class_table.h"
#include "shade/light.h"
#include "splat/points/points.h"
#include "splat/raise/raise.h"
#include "view/view.h"

namespace bccsplat {

// The kernel's own gradient, or differences of the sheets' samples over one or two neighbours on either side.
enum class GradientMethod : uint8_t { analytic, central, fourth_order };

struct SplatOptions : ShotOptions {
  GradientMethod gradient = GradientMethod::analytic;
  KernelForm kernel_form = KernelForm::exact; // how the slice's kernel is drawn
  bool preintegrate = false;                  // mode composite: by the table's integrals, which are there
  RaiseFilter raise;                          // where sheets need fewer samples than the picture has pixels
  bool reference_loops = false;               // slow ones that read like the formulae
};

struct SplatScene {
  const Slice* slice = nullptr;
  const SplatPoints* points = nullptr;
  const SheetView* view = nullptr;
  const ClassTable* table = nullptr;
  const Lights* lights = nullptr;
  KeptLatticeSums* sums = nullptr;    // of earlier pictures; null: none are kept
  const SplatScene* paint = nullptr;  // whose values say the colours; null: the scene's own
  const LightVolume* light = nullptr; // null: all light comes through
};

// What is made of scenes and classified, such as a moment of a trail; see ShotStill. A scene's table must let
// everything be seen that a still made of it shows (bricks are left out by it).
struct SplatStill {
  std::span<const SheetShare> shares; // of scenes by their number
  const ClassTable* table = nullptr;
  float weight = 1;
  double frame = 0;
  std::optional<uint32_t> paint{}; // a scene whose values say the colours; none: the still's own
  bool lit = true;                 // where the picture is
  size_t group = 1;                // that it is composited in, see TileJob
};

// A slice, alone or among others in one picture, with its trail.
struct SplatObject {
  SplatScene scene;
  std::vector<SplatScene> sources{}; // of the trail; none: it has none
  std::vector<SplatStill> stills{};
  TrailCombine combine = TrailCombine::physical; // of slice and trail
};

} // namespace bccsplat
