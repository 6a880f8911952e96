// SPDX-License-Identifier: Apache-2.0
#include "gpu/gpu_programs.h"

#include <utility>

namespace bccsplat {

GLuint GpuPrograms::find(const ShaderKind& kind) {
  const std::string source = shader_source(kind);
  const auto found = programs_.find(source);
  if (found != programs_.end()) return found->second.get();
  GlProgram program = make_program(kind.entry == GpuEntry::compute ? "" : vertex_source(), source);
  const GLuint name = program.get();
  glUseProgram(name);
  glUniformBlockBinding(name, glGetUniformBlockIndex(name, "Picture"), 0);
  for (const auto& [sampler, unit] : shader_samplers)
    if (const GLint at = glGetUniformLocation(name, sampler); at >= 0) glUniform1i(at, unit);
  check_gl("a program");
  programs_.emplace(source, std::move(program));
  return name;
}

GLuint GpuPrograms::find_plain(const std::string& vertex, const std::string& source) {
  const auto found = programs_.find(source);
  if (found != programs_.end()) return found->second.get();
  return programs_.emplace(source, make_program(vertex, source)).first->second.get();
}

GLuint GpuPrograms::find_over(bool from_buffer) {
  return find_plain(vertex_source(), over_source(from_buffer));
}

GLuint GpuPrograms::find_merge(bool in_buffers, int edge) {
  return find_plain(in_buffers ? "" : vertex_source(), merge_source(in_buffers, edge));
}

} // namespace bccsplat
