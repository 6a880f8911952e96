// SPDX-License-Identifier: Apache-2.0
// The text of the shader that draws a kind of picture: the one body (march.glsl.inc), what it is specialised
// by, and one of two entries around it.
#pragma once

#include <array>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "draw/shot.h"
#include "gpu/gpu_info.h"
#include "kernel/kernel.h"
#include "points/correction_source.h"
#include "shade/mode.h"

namespace bccsplat {

// How many half-spaces, lights and surfaces the shader's uniform block has room for.
inline constexpr int most_cuts = 48, most_gpu_lights = 16, most_gpu_surfaces = 16;
// Fields that one picture is of; the shader keeps what it knows of each beside the others.
inline constexpr int most_gpu_objects = 96;
// Texels that an object is known by: its numbers, and two for each half-space.
inline constexpr int object_numbers = 18, object_texels = object_numbers + 2 * most_cuts;

struct ShaderKind {
  GpuEntry entry = GpuEntry::fragment;
  bool sites_in_buffer = false; // of the compute entry
  RenderMode mode = RenderMode::composite;
  bool shading = false;
  bool halves = false;     // segments that add much are lit by two gradients
  bool integrals = false;  // segments are classified by them
  bool split = false;      // as ValueIntegrals::split
  bool ripple = false;     // lit without that of the kernel
  bool bcc = true;         // else the lattice is Cartesian
  bool normalised = false; // the paper's kernel
  double first_wave = 0;   // of its lattice sum
  int surfaces = 1;
  int objects = 0;                               // room for so many in one picture; 0: it is of one slice
  TrailCombine combine = TrailCombine::physical; // of objects
  RadialKernel kernel;                           // as it is drawn
  // Corrections of the field, none or by the polynomial that they fall off by.
  std::optional<CorrectionShape> corrections;
  bool masked = false, holes = false; // samples are missing, or sites
  // GLSL of another gather() than that of the sites, as measurements compare it with; empty: none.
  std::string gather;
};

// Lattice units between the sites of a coset.
[[nodiscard]] inline double coset_pitch(bool bcc) { return bcc ? std::numbers::sqrt2 : 1; }
// Sites beyond a brick's own that it has, too: as far as a kernel reaches from the site nearest to a point.
[[nodiscard]] int brick_border(const RadialKernel& kernel, bool bcc = true);

[[nodiscard]] std::string shader_source(const ShaderKind& kind);
[[nodiscard]] std::string vertex_source();
// The fragment shader that writes pixels into a texture whose rows run from below.
[[nodiscard]] std::string over_source(bool from_buffer);

// The shader that adds layers of a series into the sites of a moment: from buffers one at a time, else from
// textures, so many at once.
[[nodiscard]] std::string merge_source(bool in_buffers, int edge);
inline constexpr int layers_at_once = 8, merge_threads = 64;

// Texture units.
enum ShaderUnit {
  unit_brick_at,
  unit_around_at,
  unit_class_table,
  unit_ray_ends,
  unit_sites,
  unit_fix_at,
  unit_fixes,
  unit_missing,
  unit_holes,
  unit_objects,
  units_used
};
inline constexpr std::array<std::pair<const char*, int>, units_used> shader_samplers{
    {{"brick_at", unit_brick_at},
     {"around_at", unit_around_at},
     {"class_table", unit_class_table},
     {"ray_ends", unit_ray_ends},
     {"sites", unit_sites},
     {"fix_at", unit_fix_at},
     {"fixes", unit_fixes},
     {"missing", unit_missing},
     {"holes", unit_holes},
     {"objects", unit_objects}}};
// Bindings of buffers of the compute entry, and its square of pixels.
inline constexpr int binding_sites = 0, binding_pixels = 1, compute_edge = 8;
// Bindings of the shader that merges.
inline constexpr int binding_layer = 1, binding_from = 2;

} // namespace bccsplat
