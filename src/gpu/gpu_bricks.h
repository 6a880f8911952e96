// SPDX-License-Identifier: Apache-2.0
// Bricks of floats on the GPU: one behind the other in a buffer, or side by side in a texture of three
// dimensions. All of it belongs to the thread of its context.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "gpu/gl.h"
#include "gpu/gpu_info.h"

namespace bccsplat {

class GpuBricks {
 public:
  GpuBricks() = default;
  // values: brick after brick, x fastest; null: none yet. Throws GpuFailure where they find no room.
  GpuBricks(const float* values, size_t count, int edge, bool in_buffer);
  // What a shader of another gather looks at.
  explicit GpuBricks(GlTexture&& texture) : texture_(std::move(texture)) {}
  // Sets bricks from `first` on.
  void set(size_t first, const float* values, size_t count) const;
  // Returns whether a shader of this GPU takes so many bytes from a buffer.
  [[nodiscard]] static bool fit_buffer(uint64_t bytes, const GpuInfo& info);

  [[nodiscard]] bool in_buffer() const { return static_cast<bool>(buffer_); }
  [[nodiscard]] GLuint buffer() const { return buffer_.get(); }
  [[nodiscard]] const GlTexture& texture() const { return texture_; }
  [[nodiscard]] int edge() const { return edge_; }
  [[nodiscard]] size_t count() const { return count_; }
  // Bricks along x and y of the texture, and along z.
  [[nodiscard]] size_t along() const { return along_; }
  [[nodiscard]] size_t layers() const { return (count_ + along_ * along_ - 1) / (along_ * along_); }
  // How shaders find a brick: its number, or its place along x, y and z in 10 bits each.
  [[nodiscard]] uint32_t place(uint32_t n) const;
  [[nodiscard]] std::vector<uint32_t> places(std::vector<uint32_t> bricks) const;

 private:
  void make_buffer_of(const float* values);
  void make_texture_of(const float* values);
  [[nodiscard]] std::array<size_t, 3> position(size_t n) const {
    return {n % along_, n / along_ % along_, n / (along_ * along_)};
  }

  int edge_ = 1;
  size_t count_ = 0, along_ = 1;
  GlBuffer buffer_;
  GlTexture texture_;
};

} // namespace bccsplat
