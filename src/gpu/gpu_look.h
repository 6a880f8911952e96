// SPDX-License-Identifier: Apache-2.0
// What a shot looks like to the shader: its kind, the texels of its transfer function, its numbers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "draw/shot.h"
#include "gpu/field_bricks.h"
#include "gpu/shader.h"

namespace bccsplat {

using Vec4f = std::array<float, 4>;

// The shader's uniform block, as the layout std140 has it.
struct PictureBlock {
  std::array<Vec4f, 3> origin{}, along{}, world_along{};
  std::array<Vec4f, size_t{2} * most_cuts> cuts{};
  std::array<Vec4f, 3> to_world{};
  Vec4f sheets{}, field{}, classes{}, noise{}, frame{}, centre{}, ends{};
  std::array<Vec4f, most_gpu_lights> lights{}, diffuse{}, specular{};
  std::array<Vec4f, size_t{2} * most_gpu_surfaces> surface{};
  std::array<int32_t, 4> counts{}, picture{}, first_site{}, bricks{}, cells{};
  std::array<Vec4f, 3> to_fixes{}, to_samples{};
  std::array<int32_t, 4> fix_bricks{}, samples{};
};

// The texels of the class table and of its integrals, in rows.
inline constexpr int table_row = 1024;
[[nodiscard]] std::vector<Vec4f> table_texels(const ClassTable& table);

// Whether it depends on how fast values change if a shot is classified by integrals.
[[nodiscard]] bool asks_for_change(const Shot& shot);
// change: what change_at_sites() says of the shot's slice, where it is asked for. Returns the table with
// integrals where the shot is classified by them.
[[nodiscard]] ClassTable gpu_table(const Shot& shot, double change);

// The form of the kernel that a shot is drawn with.
[[nodiscard]] KernelForm gpu_form(const Shot& shot);
[[nodiscard]] ShaderKind shader_kind(const Shot& shot, const ClassTable& table, KernelForm form);
[[nodiscard]] PictureBlock picture_block(const Shot& shot, const ClassTable& table, const FieldBricks& bricks,
                                         KernelForm form);
[[nodiscard]] inline ShaderKind shader_kind(const Shot& shot, const ClassTable& table) {
  return shader_kind(shot, table, gpu_form(shot));
}
[[nodiscard]] inline PictureBlock picture_block(const Shot& shot, const ClassTable& table,
                                                const FieldBricks& bricks) {
  return picture_block(shot, table, bricks, gpu_form(shot));
}

// How many cells a step along a ray passes at most.
[[nodiscard]] int cells_of_step(const Shot& shot);
// The cells of the bricks that a shot sees nothing of, as unseen_cells().
[[nodiscard]] std::vector<uint8_t> unseen_by(const Shot& shot, const ClassTable& table,
                                             const FieldBricks& bricks);

} // namespace bccsplat
