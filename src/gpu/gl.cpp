// SPDX-License-Identifier: Apache-2.0
#include "gpu/gl.h"

#include <vector>

#include "gpu/gpu_info.h"

namespace bccsplat {

thread_local bool gl_objects_gone = false;

thread_local GLenum (*next_gl_error)() = [] { return glGetError(); };

#if defined(__EMSCRIPTEN__)
bool has_storage_buffers() { return false; }
#else
bool has_storage_buffers() {
  constexpr int first_version = 43; // of OpenGL, times 10
  return epoxy_gl_version() >= first_version;
}
#endif

void check_gl(const char* what) {
  constexpr int most_errors = 16; // of a context that is lost there is no end of them
  const GLenum error = next_gl_error();
  if (error == GL_NO_ERROR) return;
  if (error == GL_CONTEXT_LOST) fail_gpu("its context was lost, as when a driver resets its card: ", what);
  for (int n = 0; n < most_errors && next_gl_error() != GL_NO_ERROR; ++n) {
  }
  if (error == GL_OUT_OF_MEMORY) fail_this_time("its memory is too small: ", what);
  fail_gpu("OpenGL error ", static_cast<uint32_t>(error), ": ", what);
}

void delete_buffer(GLuint name) { glDeleteBuffers(1, &name); }
void delete_texture(GLuint name) { glDeleteTextures(1, &name); }
void delete_program(GLuint name) { glDeleteProgram(name); }
void delete_framebuffer(GLuint name) { glDeleteFramebuffers(1, &name); }
void delete_vertex_array(GLuint name) { glDeleteVertexArrays(1, &name); }

GlBuffer make_buffer() {
  GLuint name = 0;
  glGenBuffers(1, &name);
  return GlBuffer(name);
}

GlFramebuffer make_framebuffer() {
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  return GlFramebuffer(name);
}

GlVertexArray make_vertex_array() {
  GLuint name = 0;
  glGenVertexArrays(1, &name);
  return GlVertexArray(name);
}

GlTexture make_texture(const TextureShape& shape, const void* texels) {
  GLuint name = 0;
  glGenTextures(1, &name);
  GlTexture texture(name);
  const GLenum target = shape.target();
  glBindTexture(target, name);
  glTexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(target, GL_TEXTURE_MAX_LEVEL, 0);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  const auto internal = static_cast<GLint>(shape.internal);
  if (shape.depth > 0)
    glTexImage3D(target, 0, internal, shape.width, shape.height, shape.depth, 0, shape.format, shape.type,
                 texels);
  else
    glTexImage2D(target, 0, internal, shape.width, shape.height, 0, shape.format, shape.type, texels);
  check_gl("a texture");
  return texture;
}

namespace {

std::string log_of(GLuint name, bool program) {
  constexpr GLsizei longest = 2000;
  std::vector<char> text(longest);
  GLsizei length = 0;
  if (program)
    glGetProgramInfoLog(name, longest, &length, text.data());
  else
    glGetShaderInfoLog(name, longest, &length, text.data());
  return {text.data(), static_cast<size_t>(length)};
}

void attach(GLuint program, GLenum kind, const std::string& source) {
  const GLuint shader = glCreateShader(kind);
  const char* const text = source.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  glAttachShader(program, shader);
  GLint compiled = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  const std::string log = compiled ? std::string() : log_of(shader, false);
  glDeleteShader(shader); // lives on with the program
  if (!compiled) fail_gpu("its compiler refuses the shader: ", log);
}

} // namespace

GlProgram make_program(const std::string& vertex, const std::string& body) {
  GlProgram program(glCreateProgram());
  if (!vertex.empty()) attach(program.get(), GL_VERTEX_SHADER, vertex);
  attach(program.get(), vertex.empty() ? GL_COMPUTE_SHADER : GL_FRAGMENT_SHADER, body);
  glLinkProgram(program.get());
  GLint linked = 0;
  glGetProgramiv(program.get(), GL_LINK_STATUS, &linked);
  if (!linked) fail_gpu("the shader does not link: ", log_of(program.get(), true));
  return program;
}

} // namespace bccsplat
