// SPDX-License-Identifier: Apache-2.0
// The state of a host's context that drawing changes.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "gpu/gl.h"

namespace bccsplat {

// Takes note of the state at its beginning, sets what drawing depends on to OpenGL's own defaults, and puts
// the state back at its end.
class GlState {
 public:
  GlState();
  ~GlState();
  GlState(const GlState&) = delete;
  GlState& operator=(const GlState&) = delete;

 private:
  struct Unit {
    GLint texture2 = 0, texture3 = 0, sampler = 0;
  };
  struct Binding {
    GLint buffer = 0;
    GLint64 start = 0, size = 0;
  };
  static constexpr size_t units = 10, bindings = 3;
  void read_buffers();
  void set_buffers() const;
  [[nodiscard]] GLuint was(GLenum name) const;

  bool compute_;                                  // whether the context has storage buffers
  std::vector<std::pair<GLenum, GLint>> numbers_; // of what a call each sets
  std::vector<std::pair<GLenum, GLboolean>> switches_;
  std::array<Unit, units> unit_;
  std::array<Binding, bindings> storage_;
  Binding uniform_;
  std::array<GLint, 4> viewport_{}, scissor_{};
  std::array<GLboolean, 4> color_mask_{};
};

// Lets what is written into textures of sRGB be linear, where a context asks for that.
void write_linear();
// Switches off what would keep pixels from being written as they are, and sets the viewport.
void prepare_for_raster(GLint width, GLint height);

} // namespace bccsplat
