// SPDX-License-Identifier: Apache-2.0
// Layers are merged where they are: from buffers by a compute shader, layer by layer, from
// textures by drawing into the planes of the merged one, several layers at a time.
#include "gpu/gpu_moment.h"

#include <algorithm>
#include <array>
#include <string>

#include "gpu/gl_state.h"
#include "gpu/shader.h"

namespace bccsplat {
namespace {

constexpr size_t table_width = 1024;

} // namespace

GpuMomentKey key_of(const MomentPlan& moment, const std::vector<const GpuLayer*>& layers) {
  GpuMomentKey key{{}, moment.largest_weight()};
  for (const GpuLayer* layer : layers) key.layers.push_back(layer->key);
  return key;
}

GpuMoment::GpuMoment(const FieldBricks& bricks, const std::vector<const GpuLayer*>& layers) {
  const size_t per_coset = layers.front()->bricks.brick_at.size();
  count_ = 1;
  for (const uint32_t n : bricks.brick_at) count_ = std::max(count_, size_t{n} + 1);
  from_.resize(layers.size() * count_);
  for (size_t k = 0; k < layers.size(); ++k)
    for (size_t n = 0; n < per_coset; ++n)
      if (const uint32_t own = layers[k]->bricks.brick_at[n]; own != 0)
        from_[k * count_ + bricks.brick_at[layers[k]->coset * per_coset + n]] = layers[k]->sites->place(own);
  if (layers.front()->sites->in_buffer()) {
    from_buffer_ = make_buffer();
    glBindBuffer(GL_SHADER_STORAGE_BUFFER, from_buffer_.get());
    glBufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(from_.size() * sizeof(uint32_t)),
                 from_.data(), GL_STATIC_DRAW);
  } else {
    from_.resize((from_.size() + table_width - 1) / table_width * table_width);
    from_texture_ = make_texture({.width = table_width,
                                  .height = static_cast<GLint>(from_.size() / table_width),
                                  .internal = GL_R32UI,
                                  .format = GL_RED_INTEGER,
                                  .type = GL_UNSIGNED_INT},
                                 from_.data());
  }
  from_ = {};
  check_gl("the layers of a moment");
}

bool GpuMoment::merge(GpuPrograms& programs, const std::vector<const GpuLayer*>& layers,
                      const std::vector<float>& weights, const GpuBricks& sites, size_t first) {
  if (weights == weights_ && first == first_) return false;
  weights_ = weights, first_ = first;
  try {
    if (sites.in_buffer())
      merge_buffers(programs, layers, sites);
    else
      merge_textures(programs, layers, sites);
    check_gl("merging a moment");
  } catch (...) { // or the next picture would take what is there for merged
    weights_.clear();
    throw;
  }
  return true;
}

void GpuMoment::merge_buffers(GpuPrograms& programs, const std::vector<const GpuLayer*>& layers,
                              const GpuBricks& sites) {
  constexpr size_t most_groups = 65535; // along an axis that every context takes
  const auto edge = static_cast<GLuint>(sites.edge()), size = edge * edge * edge;
  const GLuint program = programs.find_merge(true, sites.edge());
  const auto set = [&](const char* name, size_t value) {
    glUniform1ui(glGetUniformLocation(program, name), static_cast<GLuint>(value));
  };
  glUseProgram(program);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding_sites, sites.buffer());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding_from, from_buffer_.get());
  for (size_t k = 0; k < layers.size(); ++k) {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding_layer, layers[k]->sites->buffer());
    glUniform1f(glGetUniformLocation(program, "weight"), weights_[k]);
    set("adds", k > 0 ? 1 : 0);
    for (size_t first = 0; first < count_; first += most_groups) {
      set("first", first_ + first), set("table", k * count_ + first);
      glDispatchCompute((size + merge_threads - 1) / merge_threads,
                        static_cast<GLuint>(std::min(most_groups, count_ - first)), 1);
    }
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  }
}

void GpuMoment::merge_textures(GpuPrograms& programs, const std::vector<const GpuLayer*>& layers,
                               const GpuBricks& sites) {
  const GLuint program = programs.find_merge(false, sites.edge());
  const auto side = static_cast<GLint>(sites.along()) * sites.edge();
  const GlFramebuffer onto = make_framebuffer();
  const GlVertexArray vertices = make_vertex_array();
  glBindFramebuffer(GL_FRAMEBUFFER, onto.get());
  glBindVertexArray(vertices.get());
  glUseProgram(program);
  prepare_for_raster(side, side);
  glUniform3i(glGetUniformLocation(program, "atlas"), static_cast<GLint>(sites.along()),
              static_cast<GLint>(count_), static_cast<GLint>(first_));
  for (size_t first = 0; first < layers.size(); first += layers_at_once) {
    if (first > 0) glEnable(GL_BLEND), glBlendEquation(GL_FUNC_ADD), glBlendFunc(GL_ONE, GL_ONE);
    draw_textures(program, layers, first, sites);
  }
  glDisable(GL_BLEND);
}

void GpuMoment::draw_textures(GLuint program, const std::vector<const GpuLayer*>& layers, size_t from,
                              const GpuBricks& sites) const {
  const auto bind = [&](size_t unit, GLenum target, GLuint texture, const std::string& name) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(target, texture);
    glUniform1i(glGetUniformLocation(program, name.c_str()), static_cast<GLint>(unit));
  };
  bind(0, GL_TEXTURE_2D, from_texture_.get(), "from");
  std::array<GLfloat, layers_at_once> weights{};
  for (size_t k = 0; k < layers_at_once; ++k) {
    const size_t n = std::min(from + k, layers.size() - 1); // others have weight 0
    bind(1 + k, GL_TEXTURE_3D, layers[n]->sites->texture().get(), "layer" + std::to_string(k));
    if (from + k < layers.size()) weights[k] = weights_[from + k];
  }
  glUniform1fv(glGetUniformLocation(program, "weights"), layers_at_once, weights.data());
  glUniform2i(glGetUniformLocation(program, "table"), static_cast<GLint>(from * count_),
              static_cast<GLint>(std::min<size_t>(layers_at_once, layers.size() - from)));
  const size_t per_layer = sites.along() * sites.along();
  const auto begin = static_cast<GLint>(first_ / per_layer) * sites.edge(),
             end = static_cast<GLint>((first_ + count_ - 1) / per_layer + 1) * sites.edge();
  for (GLint z = begin; z < end; ++z) {
    glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, sites.texture().get(), 0, z);
    if (z == begin && glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
      fail_this_time("it does not draw into a texture of floats, so that moments are merged by the CPU");
    glUniform1i(glGetUniformLocation(program, "plane"), z);
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }
}

} // namespace bccsplat
