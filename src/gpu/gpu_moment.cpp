// SPDX-License-Identifier: Apache-2.0
// Layers are sent once and merged where they are: from buffers by a compute shader, layer by layer, from
// textures by drawing into the planes of the merged one, several layers at a time.
#include "gpu/gpu_moment.h"

#include <algorithm>
#include <array>
#include <set>
#include <string>

#include "gpu/gl_state.h"
#include "gpu/shader.h"

namespace bccsplat {
namespace {

constexpr size_t most_layers = 12; // that are kept; moments of more keep as many as they have
constexpr size_t table_width = 1024;

bool needs(const MomentPlan& moment, const GpuLayerKey& key) {
  return key.first == moment.series() &&
         std::any_of(moment.parts().begin(), moment.parts().end(),
                     [&](const MomentPlan::Part& p) { return p.layer == key.second; });
}

bool needs(const NeededMoments& moments, const GpuLayerKey& key) {
  return std::any_of(moments.begin(), moments.end(), [&](const MomentPlan* m) { return needs(*m, key); });
}

size_t count_layers(const NeededMoments& moments) {
  std::set<GpuLayerKey> keys;
  for (const MomentPlan* m : moments)
    for (const MomentPlan::Part& p : m->parts()) keys.emplace(m->series(), p.layer);
  return keys.size();
}

// Whether sites of a series are in buffers: those of a moment with every brick fit one.
bool in_buffers(const FieldBricks& like, const GpuInfo& info) {
  const uint64_t size = static_cast<uint64_t>(like.edge) * like.edge * like.edge;
  return GpuBricks::fit_buffer(sizeof(float) * size * (like.brick_at.size() + 1), info);
}

} // namespace

GpuMomentKey key_of(const MomentPlan& moment, const std::vector<const GpuLayer*>& layers) {
  GpuMomentKey key{{}, moment.largest_weight()};
  for (const GpuLayer* layer : layers) key.layers.push_back(layer->key);
  return key;
}

std::unique_ptr<GpuLayer> GpuLayers::make(const Slice& slice, const MomentPlan& moment,
                                          const NeededMoments& needed, const MomentPlan::Part& part,
                                          int border, GpuDevice& device, const Context& context) {
  auto layer = std::make_unique<GpuLayer>();
  layer->key = {moment.series(), part.layer}, layer->coset = static_cast<size_t>(part.coset);
  const FieldBricks like = no_bricks(slice, border);
  layer->bricks = part.of.values ? make_layer_bricks(*part.of.values, like, context)
                                 : make_layer_bricks(part.of.compact->as_values(), like, context);
  const size_t size = static_cast<size_t>(like.edge) * like.edge * like.edge;
  const uint64_t bytes = layer->bricks.value.size() * sizeof(float);
  make_room(needed, bytes, device);
  device.reserve(bytes);
  layer->bytes = bytes;
  try {
    device.run([&] {
      layer->sites.emplace(layer->bricks.value.data(), layer->bricks.value.size() / size, like.edge,
                           in_buffers(like, device.programs().info()));
    });
  } catch (...) {
    device.release(bytes);
    throw;
  }
  layer->bricks.drop_values();
  return layer;
}

void GpuLayers::make_room(const NeededMoments& needed, uint64_t bytes, GpuDevice& device) {
  const size_t most = std::max(most_layers, count_layers(needed));
  for (size_t n = layers_.size(); n-- > 0 && (!device.has_room(bytes) || layers_.size() >= most);) {
    if (needs(needed, layers_[n]->key)) continue;
    device.release(layers_[n]->bytes);
    device.clear([&] { layers_[n].reset(); });
    layers_.erase(layers_.begin() + static_cast<std::ptrdiff_t>(n));
  }
}

std::vector<const GpuLayer*> GpuLayers::find(const Slice& slice, const MomentPlan& moment,
                                             const NeededMoments& needed, int border, GpuDevice& device,
                                             const Context& context, DrawStats& stats) {
  std::vector<const GpuLayer*> out;
  for (const MomentPlan::Part& part : moment.parts()) {
    const GpuLayerKey key{moment.series(), part.layer};
    auto found = std::find_if(layers_.begin(), layers_.end(), [&](const auto& l) { return l->key == key; });
    if (found == layers_.end()) {
      auto made = make(slice, moment, needed, part, border, device, context); // which may drop others
      layers_.insert(layers_.begin(), std::move(made));
      ++stats.layers_sent, stats.bytes_sent += layers_.front()->bytes;
    } else {
      std::rotate(layers_.begin(), found, found + 1);
    }
    out.push_back(layers_.front().get());
  }
  return out;
}

void GpuLayers::drop_all(GpuDevice& device) {
  for (const auto& layer : layers_) device.release(layer->bytes);
  if (!layers_.empty()) device.clear([&] { layers_.clear(); });
  layers_.clear();
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
