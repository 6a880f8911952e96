// SPDX-License-Identifier: Apache-2.0
// OpenGL's objects, each deleted at its end, which must come while their context is current.
#pragma once

#if defined(__EMSCRIPTEN__)
#include "gpu/gl_es.h"
#else
#include <epoxy/gl.h>
#endif

#include <cstdint>
#include <string>
#include <utility>

namespace bccsplat {

// Throws GpuFailure, with what was done, where OpenGL has met an error since the last call, or has lost the
// context.
void check_gl(const char* what);

// What this thread's check_gl() asks, as glGetError() answers: tests have their own.
extern thread_local GLenum (*next_gl_error)();

// Whether the current context has buffers that compute shaders write.
[[nodiscard]] bool has_storage_buffers();

// Whether the context of the objects that this thread deletes is gone, or not current: their names are
// forgotten then.
extern thread_local bool gl_objects_gone;

// An object's name, of a kind that `Delete` deletes.
template<void (*Delete)(GLuint)> class GlName {
 public:
  GlName() = default;
  explicit GlName(GLuint name) : name_(name) {}
  GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlName& operator=(GlName&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  ~GlName() {
    if (name_ != 0 && !gl_objects_gone) Delete(name_);
  }
  [[nodiscard]] GLuint get() const { return name_; }
  explicit operator bool() const { return name_ != 0; }

 private:
  GLuint name_ = 0;
};

void delete_buffer(GLuint name);
void delete_texture(GLuint name);
void delete_program(GLuint name);
void delete_framebuffer(GLuint name);
void delete_vertex_array(GLuint name);
using GlBuffer = GlName<delete_buffer>;
using GlTexture = GlName<delete_texture>;
using GlProgram = GlName<delete_program>;
using GlFramebuffer = GlName<delete_framebuffer>;
using GlVertexArray = GlName<delete_vertex_array>;

[[nodiscard]] GlBuffer make_buffer();
[[nodiscard]] GlFramebuffer make_framebuffer();
[[nodiscard]] GlVertexArray make_vertex_array();

// The shape of a texture whose texels are looked up one by one; depth 0: of two dimensions.
struct TextureShape {
  GLint width = 1, height = 1, depth = 0;
  GLenum internal = GL_R32F, format = GL_RED, type = GL_FLOAT;
  [[nodiscard]] GLenum target() const { return depth > 0 ? GL_TEXTURE_3D : GL_TEXTURE_2D; }
};
// texels: packed; null: none yet.
[[nodiscard]] GlTexture make_texture(const TextureShape& shape, const void* texels);

// Compiles and links; throws GpuFailure with what the compiler says. vertex empty: a compute shader.
[[nodiscard]] GlProgram make_program(const std::string& vertex, const std::string& body);

} // namespace bccsplat
