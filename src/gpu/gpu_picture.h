// SPDX-License-Identifier: Apache-2.0
// Slices and pictures on a GPU. All of it belongs to the thread of its context.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gpu/field_bricks.h"
#include "gpu/gl.h"
#include "gpu/gpu_bricks.h"
#include "gpu/gpu_look.h"
#include "gpu/gpu_programs.h"

namespace bccsplat {

// The sites of a slice: in a buffer, or where that is asked for or too large for one, in a texture; and in
// textures its corrections and what is missing, where it has these.
struct GpuSites {
  GpuBricks sites, fixes;
  GlTexture brick_at, fix_at, missing, holes;

  GpuSites() = default;
  // Throws GpuFailure where they find no room.
  GpuSites(const FieldBricks& bricks, const GpuInfo& info);
  // of: the bricks' values.
  GpuSites(const FieldBricks& bricks, GpuBricks&& of);
};

// The part of a picture that changes with its transfer function and mode.
struct GpuClasses {
  GlTexture table, around_at;
  GpuClasses(const std::vector<Vec4f>& texels, const FieldBricks& bricks, const std::vector<uint8_t>& unseen);
};

// Pixels as the shader writes them, row by row: premultiplied colour and opacity; sheet number of the depth
// (1e30: none), value, time, 1 where these are known.
struct GpuPixels {
  std::vector<Vec4f> color, more; // the latter empty where it is not asked for
};

// A picture under way, by calls that may each be a job of their own.
class GpuPicture {
 public:
  // ends: planar distances, row by row; empty: none, or those of a target's texture. objects: their rows
  // (object_row()), of a kind that has several. Sites and classes outlive it. Throws GpuFailure.
  GpuPicture(GpuPrograms& programs, const ShaderKind& kind, const PictureBlock& block, const GpuSites& sites,
             const GpuClasses& classes, const std::vector<float>& ends, GLuint depth_texture = 0,
             const std::vector<Vec4f>& objects = {});
  // How many rows are drawn at a time, so that between them a call can be cancelled.
  [[nodiscard]] int rows_at_once() const;
  void draw_rows(int first, int count);
  [[nodiscard]] GpuPixels read(bool more) const;
  // Lays the picture over the target's texture, of whose context this is.
  void lay_over(GpuPrograms& programs, const GpuTarget& target);

 private:
  void make_buffer_of_pixels();
  void make_framebuffer_of_pixels();
  void bind();
  void read_plane(size_t n, std::vector<Vec4f>& out) const;

  const GpuSites& sites_;
  const GpuClasses& classes_;
  ShaderKind kind_;
  PictureBlock block_;
  bool software_;
  GLint width_, height_;
  GLuint program_;
  GlBuffer uniforms_, pixels_;
  GlFramebuffer framebuffer_;
  GlVertexArray vertices_;
  std::array<GlTexture, 2> planes_;
  GlTexture ends_, objects_;
  GLuint depth_texture_; // of the host; 0: none
};

// Lays a picture of nothing over the target's texture, as GpuPicture::lay_over() does. Throws GpuFailure.
void lay_nothing_over(const GpuTarget& target);

} // namespace bccsplat
