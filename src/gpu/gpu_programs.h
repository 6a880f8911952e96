// SPDX-License-Identifier: Apache-2.0
// The compiled shaders of a context.
#pragma once

#include <map>
#include <string>

#include "gpu/gl.h"
#include "gpu/shader.h"

namespace bccsplat {

class GpuPrograms {
 public:
  explicit GpuPrograms(const GpuInfo& info) : info_(info) {}
  [[nodiscard]] const GpuInfo& info() const { return info_; }
  // Returns the program of a kind of picture, compiled at its first use. Throws GpuFailure.
  [[nodiscard]] GLuint find(const ShaderKind& kind);
  // The same of what lays pixels over a texture, from a buffer or from a texture.
  [[nodiscard]] GLuint find_over(bool from_buffer);
  // The same of what merges layers, from buffers or from textures.
  [[nodiscard]] GLuint find_merge(bool in_buffers, int edge);

 private:
  // A program without textures or blocks of its own.
  [[nodiscard]] GLuint find_plain(const std::string& vertex, const std::string& source);
  GpuInfo info_;
  std::map<std::string, GlProgram> programs_; // by source
};

} // namespace bccsplat
