// SPDX-License-Identifier: Apache-2.0
// What the objects of a picture, one or several, look like to the shader.
#pragma once

#include <span>
#include <vector>

#include "draw/shot.h"
#include "gpu/gpu_look.h"
#include "gpu/object_bricks.h"

namespace bccsplat {

// A slice that is drawn alone, or one of several that are composited in one picture.
struct GpuObject {
  Shot shot;       // of it alone; of several, of mode composite
  float share = 1; // of its extinction
  int group = 1;   // 0: the slice of a trail, 1: what is combined with it, or all
};

// The objects of a shot with a trail. with_slice: the slice among them.
[[nodiscard]] std::vector<GpuObject> trail_objects(const Shot& shot, bool with_slice);
// The objects of shots without trails.
[[nodiscard]] std::vector<GpuObject> instance_objects(Shots shots);

// Their tables, all with integrals where one of them asks for it. change: as gpu_table() has it.
[[nodiscard]] std::vector<ClassTable> object_tables(std::span<const GpuObject> objects,
                                                    std::span<const double> change);

[[nodiscard]] KernelForm objects_form(std::span<const GpuObject> objects);
[[nodiscard]] ShaderKind objects_kind(std::span<const GpuObject> objects, TrailCombine combine,
                                      std::span<const ClassTable> tables);

// The texels that the shader knows an object by; first_row: of its table.
[[nodiscard]] std::vector<Vec4f> object_row(const GpuObject& object, const PictureBlock& block,
                                            const ObjectPlace& place, int first_row);

} // namespace bccsplat
