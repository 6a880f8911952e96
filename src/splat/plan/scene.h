// SPDX-License-Identifier: Apache-2.0
// What the sheets of a picture are made of, and how.
#pragma once

#include <cstdint>

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

} // namespace bccsplat
