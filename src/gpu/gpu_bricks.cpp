// SPDX-License-Identifier: Apache-2.0
#include "gpu/gpu_bricks.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {

GpuBricks::GpuBricks(const float* values, size_t count, int edge, bool in_buffer)
    : edge_(edge), count_(count) {
  if (in_buffer)
    make_buffer_of(values);
  else
    make_texture_of(values);
  check_gl("the sites of a slice");
}

bool GpuBricks::fit_buffer(uint64_t bytes, const GpuInfo& info) {
  if (info.entry != GpuEntry::compute) return false;
  GLint64 most = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  return bytes <= static_cast<uint64_t>(std::max<GLint64>(most, 0));
}

void GpuBricks::make_buffer_of(const float* values) {
  const size_t size = static_cast<size_t>(edge_) * edge_ * edge_;
  buffer_ = make_buffer();
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffer_.get());
  glBufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(sizeof(float) * count_ * size), values,
               GL_STATIC_DRAW);
}

void GpuBricks::make_texture_of(const float* values) {
  constexpr size_t most_along = 1023; // as 10 bits count
  GLint most = 0;
  glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &most);
  const auto room = std::min(static_cast<size_t>(most / edge_), most_along);
  along_ = std::min(room, static_cast<size_t>(std::ceil(std::cbrt(static_cast<double>(count_)))));
  if (layers() > room) fail_this_time("the slice has too many bricks for its textures");
  const GLint side = static_cast<GLint>(along_) * edge_;
  texture_ =
      make_texture({.width = side, .height = side, .depth = static_cast<GLint>(layers()) * edge_}, nullptr);
  if (values) set(0, values, count_);
}

void GpuBricks::set(size_t first, const float* values, size_t count) const {
  const size_t size = static_cast<size_t>(edge_) * edge_ * edge_;
  if (in_buffer()) {
    const auto bytes = static_cast<GLsizeiptr>(sizeof(float) * size);
    glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffer_.get());
    glBufferSubData(GL_SHADER_STORAGE_BUFFER, static_cast<GLintptr>(first) * bytes,
                    static_cast<GLsizeiptr>(count) * bytes, values);
    return;
  }
  glBindTexture(GL_TEXTURE_3D, texture_.get());
  for (size_t n = 0; n < count; ++n) {
    const auto [x, y, z] = position(first + n);
    glTexSubImage3D(GL_TEXTURE_3D, 0, static_cast<GLint>(x) * edge_, static_cast<GLint>(y) * edge_,
                    static_cast<GLint>(z) * edge_, edge_, edge_, edge_, GL_RED, GL_FLOAT, values + n * size);
  }
}

uint32_t GpuBricks::place(uint32_t n) const {
  if (in_buffer()) return n;
  constexpr unsigned bits = 10;
  const auto [x, y, z] = position(n);
  return static_cast<uint32_t>(x | y << bits | z << (2 * bits));
}

std::vector<uint32_t> GpuBricks::places(std::vector<uint32_t> bricks) const {
  for (uint32_t& n : bricks) n = place(n);
  return bricks;
}

} // namespace bccsplat
