// SPDX-License-Identifier: Apache-2.0
// What is listed here is what the calls of a job set; nothing else is touched.
#include "gpu/gl_state.h"

namespace bccsplat {
namespace {

#if defined(__EMSCRIPTEN__)
constexpr std::array switches{GL_BLEND,
                              GL_DEPTH_TEST,
                              GL_CULL_FACE,
                              GL_SCISSOR_TEST,
                              GL_STENCIL_TEST,
                              GL_RASTERIZER_DISCARD,
                              GL_SAMPLE_ALPHA_TO_COVERAGE};
#else
constexpr std::array switches{GL_BLEND,          GL_DEPTH_TEST,
                              GL_CULL_FACE,      GL_SCISSOR_TEST,
                              GL_STENCIL_TEST,   GL_FRAMEBUFFER_SRGB,
                              GL_COLOR_LOGIC_OP, GL_RASTERIZER_DISCARD,
                              GL_SAMPLE_MASK,    GL_SAMPLE_ALPHA_TO_COVERAGE};
#endif
constexpr std::array pixel_store{GL_UNPACK_ALIGNMENT,   GL_UNPACK_ROW_LENGTH,  GL_UNPACK_SKIP_ROWS,
                                 GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_IMAGES, GL_UNPACK_IMAGE_HEIGHT,
                                 GL_PACK_ALIGNMENT,     GL_PACK_ROW_LENGTH,    GL_PACK_SKIP_ROWS,
                                 GL_PACK_SKIP_PIXELS};
constexpr std::array bound{GL_CURRENT_PROGRAM,
                           GL_VERTEX_ARRAY_BINDING,
                           GL_DRAW_FRAMEBUFFER_BINDING,
                           GL_READ_FRAMEBUFFER_BINDING,
                           GL_PIXEL_UNPACK_BUFFER_BINDING,
                           GL_PIXEL_PACK_BUFFER_BINDING,
                           GL_UNIFORM_BUFFER_BINDING,
                           GL_ACTIVE_TEXTURE,
                           GL_BLEND_SRC_RGB,
                           GL_BLEND_DST_RGB,
                           GL_BLEND_SRC_ALPHA,
                           GL_BLEND_DST_ALPHA,
                           GL_BLEND_EQUATION_RGB,
                           GL_BLEND_EQUATION_ALPHA};

GLint number_of(GLenum name) {
  GLint value = 0;
  glGetIntegerv(name, &value);
  return value;
}

} // namespace

GlState::GlState() : compute_(has_storage_buffers()) {
  while (glGetError() != GL_NO_ERROR) { // those of the host
  }
  for (const GLenum name : bound) numbers_.emplace_back(name, number_of(name));
  for (const GLenum name : pixel_store) numbers_.emplace_back(name, number_of(name));
  for (const GLenum name : switches) switches_.emplace_back(name, glIsEnabled(name));
  glGetIntegerv(GL_VIEWPORT, viewport_.data());
  glGetIntegerv(GL_SCISSOR_BOX, scissor_.data());
  glGetBooleanv(GL_COLOR_WRITEMASK, color_mask_.data());
  for (size_t n = 0; n < units; ++n) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(n));
    unit_[n] = {number_of(GL_TEXTURE_BINDING_2D), number_of(GL_TEXTURE_BINDING_3D),
                number_of(GL_SAMPLER_BINDING)};
    glBindSampler(static_cast<GLuint>(n), 0);
  }
  read_buffers();
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0), glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  for (const GLenum name : pixel_store) glPixelStorei(name, 0);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1), glPixelStorei(GL_PACK_ALIGNMENT, 1);
  while (glGetError() != GL_NO_ERROR) { // an alignment is not 0
  }
}

void GlState::read_buffers() {
  const auto read = [](GLenum binding, GLenum start, GLenum size, GLuint n) {
    Binding b;
    glGetIntegeri_v(binding, n, &b.buffer);
    glGetInteger64i_v(start, n, &b.start), glGetInteger64i_v(size, n, &b.size);
    return b;
  };
  uniform_ = read(GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START, GL_UNIFORM_BUFFER_SIZE, 0);
  if (!compute_) return;
  numbers_.emplace_back(GL_SHADER_STORAGE_BUFFER_BINDING, number_of(GL_SHADER_STORAGE_BUFFER_BINDING));
  for (size_t n = 0; n < bindings; ++n)
    storage_[n] = read(GL_SHADER_STORAGE_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_START,
                       GL_SHADER_STORAGE_BUFFER_SIZE, static_cast<GLuint>(n));
}

void GlState::set_buffers() const {
  const auto set = [](GLenum target, size_t n, const Binding& b) {
    const auto index = static_cast<GLuint>(n), buffer = static_cast<GLuint>(b.buffer);
    if (b.size > 0)
      glBindBufferRange(target, index, buffer, static_cast<GLintptr>(b.start),
                        static_cast<GLsizeiptr>(b.size));
    else
      glBindBufferBase(target, index, buffer);
  };
  set(GL_UNIFORM_BUFFER, 0, uniform_);
  for (size_t n = 0; compute_ && n < bindings; ++n) set(GL_SHADER_STORAGE_BUFFER, n, storage_[n]);
}

GLuint GlState::was(GLenum name) const {
  for (const auto& [of, value] : numbers_)
    if (of == name) return static_cast<GLuint>(value);
  return 0;
}

GlState::~GlState() {
  set_buffers();
  for (size_t n = 0; n < units; ++n) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(n));
    glBindTexture(GL_TEXTURE_2D, static_cast<GLuint>(unit_[n].texture2));
    glBindTexture(GL_TEXTURE_3D, static_cast<GLuint>(unit_[n].texture3));
    glBindSampler(static_cast<GLuint>(n), static_cast<GLuint>(unit_[n].sampler));
  }
  glUseProgram(was(GL_CURRENT_PROGRAM)), glBindVertexArray(was(GL_VERTEX_ARRAY_BINDING));
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, was(GL_DRAW_FRAMEBUFFER_BINDING));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, was(GL_READ_FRAMEBUFFER_BINDING));
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, was(GL_PIXEL_UNPACK_BUFFER_BINDING));
  glBindBuffer(GL_PIXEL_PACK_BUFFER, was(GL_PIXEL_PACK_BUFFER_BINDING));
  glBindBuffer(GL_UNIFORM_BUFFER, was(GL_UNIFORM_BUFFER_BINDING));
  if (compute_) glBindBuffer(GL_SHADER_STORAGE_BUFFER, was(GL_SHADER_STORAGE_BUFFER_BINDING));
  glActiveTexture(was(GL_ACTIVE_TEXTURE));
  glBlendFuncSeparate(was(GL_BLEND_SRC_RGB), was(GL_BLEND_DST_RGB), was(GL_BLEND_SRC_ALPHA),
                      was(GL_BLEND_DST_ALPHA));
  glBlendEquationSeparate(was(GL_BLEND_EQUATION_RGB), was(GL_BLEND_EQUATION_ALPHA));
  for (const GLenum name : pixel_store) glPixelStorei(name, static_cast<GLint>(was(name)));
  for (const auto& [name, on] : switches_) on ? glEnable(name) : glDisable(name);
  glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
  glScissor(scissor_[0], scissor_[1], scissor_[2], scissor_[3]);
  glColorMask(color_mask_[0], color_mask_[1], color_mask_[2], color_mask_[3]);
}

#if defined(__EMSCRIPTEN__)
void write_linear() {}
#else
void write_linear() { glEnable(GL_FRAMEBUFFER_SRGB); }
#endif

void prepare_for_raster(GLint width, GLint height) {
  for (const GLenum name : switches) glDisable(name);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glViewport(0, 0, width, height);
}

} // namespace bccsplat
