// SPDX-License-Identifier: Apache-2.0
// Puts slices and tables where the shader looks, has it draw by either entry, and reads the pixels back.
#include "gpu/gpu_picture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "gpu/gl_state.h"

namespace bccsplat {
namespace {

void bind_texture(int unit, const TextureShape& shape, const GlTexture& texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(shape.target(), texture.get());
}

constexpr TextureShape plane{}, volume{.depth = 1};

GlTexture make_words(GLint width, GLint height, GLint depth, const std::vector<uint32_t>& words) {
  return make_texture({.width = width,
                       .height = height,
                       .depth = depth,
                       .internal = GL_R32UI,
                       .format = GL_RED_INTEGER,
                       .type = GL_UNSIGNED_INT},
                      words.data());
}

GlTexture bit_texture(const BitBox& bits) {
  if (bits.empty()) return {};
  return make_words(bits.row_words(), bits.size[1], bits.size[2], bits.words);
}

} // namespace

GpuSites::GpuSites(const FieldBricks& bricks, const GpuInfo& info)
    : GpuSites(bricks, GpuBricks(bricks.value.data(), bricks.count(), bricks.edge,
                                 GpuBricks::fit_buffer(bricks.site_bytes(), info))) {}

GpuSites::GpuSites(const FieldBricks& bricks, GpuBricks&& of) : sites(std::move(of)) {
  brick_at = make_words(bricks.bricks[0], bricks.bricks[1], bricks.cosets() * bricks.bricks[2],
                        sites.places(bricks.brick_at));
  if (const FieldFixes& own = bricks.fixes; !own.empty()) {
    fixes = GpuBricks(own.value.data(), own.count(), FieldFixes::edge, false);
    fix_at = make_words(own.bricks[0], own.bricks[1], own.bricks[2], fixes.places(own.brick_at));
  }
  missing = bit_texture(bricks.missing.bits), holes = bit_texture(bricks.holes);
}

GpuClasses::GpuClasses(const std::vector<Vec4f>& texels, const FieldBricks& bricks,
                       const std::vector<uint8_t>& unseen)
    : table(make_texture({.width = table_row,
                          .height = static_cast<GLint>(texels.size()) / table_row,
                          .internal = GL_RGBA32F,
                          .format = GL_RGBA},
                         texels.data())),
      around_at(make_texture({.width = bricks.cells[0],
                              .height = bricks.cells[1],
                              .depth = bricks.cells[2],
                              .internal = GL_R8UI,
                              .format = GL_RED_INTEGER,
                              .type = GL_UNSIGNED_BYTE},
                             unseen.data())) {}

GpuPicture::GpuPicture(GpuPrograms& programs, const ShaderKind& kind, const PictureBlock& block,
                       const GpuSites& sites, const GpuClasses& classes, const std::vector<float>& ends,
                       GLuint depth_texture, const std::vector<Vec4f>& objects)
    : sites_(sites), classes_(classes), kind_(kind), block_(block), software_(programs.info().software),
      width_(block.picture[0]), height_(block.picture[1]), depth_texture_(depth_texture) {
  kind_.entry = programs.info().entry;
  kind_.sites_in_buffer = sites.sites.in_buffer();
  program_ = programs.find(kind_);
  uniforms_ = make_buffer();
  if (kind_.entry == GpuEntry::compute)
    make_buffer_of_pixels();
  else
    make_framebuffer_of_pixels();
  if (!ends.empty()) ends_ = make_texture({.width = width_, .height = height_}, ends.data());
  if (!objects.empty())
    objects_ = make_texture({.width = object_texels,
                             .height = static_cast<GLint>(objects.size() / object_texels),
                             .internal = GL_RGBA32F,
                             .format = GL_RGBA},
                            objects.data());
  check_gl("a picture");
}

int GpuPicture::rows_at_once() const {
  // A card that works on one call for seconds is taken for hung by its driver.
  constexpr int software_rows = 64, card_pixels = 1 << 21;
  return software_ ? software_rows : std::max(software_rows, card_pixels / width_);
}

void GpuPicture::make_buffer_of_pixels() {
  pixels_ = make_buffer();
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, pixels_.get());
  glBufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(2 * sizeof(Vec4f)) * width_ * height_,
               nullptr, GL_STREAM_READ);
}

void GpuPicture::make_framebuffer_of_pixels() {
  framebuffer_ = make_framebuffer(), vertices_ = make_vertex_array();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  for (size_t n = 0; n < planes_.size(); ++n) {
    planes_[n] = make_texture({.width = width_, .height = height_, .internal = GL_RGBA32F, .format = GL_RGBA},
                              nullptr);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(n), GL_TEXTURE_2D,
                           planes_[n].get(), 0);
  }
  constexpr std::array<GLenum, 2> buffers{GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  glDrawBuffers(buffers.size(), buffers.data());
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    fail_this_time("it has no framebuffer of floats of ", width_, " x ", height_, " pixels");
}

// Other pictures may have been drawn since the last rows.
void GpuPicture::bind() {
  glUseProgram(program_);
  glBindBuffer(GL_UNIFORM_BUFFER, uniforms_.get());
  glBufferData(GL_UNIFORM_BUFFER, sizeof block_, &block_, GL_STREAM_DRAW);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, uniforms_.get());
  bind_texture(unit_brick_at, volume, sites_.brick_at);
  bind_texture(unit_around_at, volume, classes_.around_at);
  bind_texture(unit_class_table, plane, classes_.table);
  bind_texture(unit_ray_ends, plane, ends_);
  if (depth_texture_ != 0) glBindTexture(GL_TEXTURE_2D, depth_texture_);
  bind_texture(unit_sites, volume, sites_.sites.texture());
  bind_texture(unit_fix_at, volume, sites_.fix_at), bind_texture(unit_fixes, volume, sites_.fixes.texture());
  bind_texture(unit_missing, volume, sites_.missing), bind_texture(unit_holes, volume, sites_.holes);
  bind_texture(unit_objects, plane, objects_);
  if (kind_.sites_in_buffer) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding_sites, sites_.sites.buffer());
}

void GpuPicture::draw_rows(int first, int count) {
  block_.picture[2] = first;
  bind();
  if (kind_.entry == GpuEntry::compute) {
    const auto groups = [](int pixels) {
      return static_cast<GLuint>((pixels + compute_edge - 1) / compute_edge);
    };
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding_pixels, pixels_.get());
    glDispatchCompute(groups(width_), groups(count), 1);
  } else {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
    glBindVertexArray(vertices_.get());
    prepare_for_raster(width_, height_);
    glEnable(GL_SCISSOR_TEST);
    glScissor(0, first, width_, count);
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }
  if (software_) glFinish(); // or all of it would be waited for at the end
  check_gl("drawing");
}

GpuPixels GpuPicture::read(bool more) const {
  GpuPixels out;
  if (kind_.entry == GpuEntry::compute) glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  read_plane(0, out.color);
  if (more) read_plane(1, out.more);
  check_gl("reading a picture");
  return out;
}

void GpuPicture::read_plane(size_t n, std::vector<Vec4f>& out) const {
  out.resize(static_cast<size_t>(width_) * static_cast<size_t>(height_));
  const auto bytes = static_cast<GLsizeiptr>(out.size() * sizeof(Vec4f));
  if (kind_.entry == GpuEntry::compute) {
    glBindBuffer(GL_SHADER_STORAGE_BUFFER, pixels_.get());
    glGetBufferSubData(GL_SHADER_STORAGE_BUFFER, static_cast<GLintptr>(n) * bytes, bytes, out.data());
    return;
  }
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadBuffer(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(n));
  glReadPixels(0, 0, width_, height_, GL_RGBA, GL_FLOAT, out.data());
}

namespace {

// A framebuffer of the target's texture, which is bound.
GlFramebuffer bind_target(const GpuTarget& target) {
  GlFramebuffer onto = make_framebuffer();
  glBindFramebuffer(GL_FRAMEBUFFER, onto.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target.texture, 0);
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    fail_this_time("the texture of the frame is none that can be drawn into");
  return onto;
}

} // namespace

void lay_nothing_over(const GpuTarget& target) {
  const GlFramebuffer onto = bind_target(target);
  if (target.replace) {
    constexpr std::array<GLfloat, 4> transparent{};
    prepare_for_raster(1, 1);
    glClearBufferfv(GL_COLOR, 0, transparent.data());
  }
  check_gl("clearing the texture of the frame");
}

void GpuPicture::lay_over(GpuPrograms& programs, const GpuTarget& target) {
  const bool compute = kind_.entry == GpuEntry::compute;
  const GLuint program = programs.find_over(compute);
  const GlFramebuffer onto = bind_target(target);
  const GlVertexArray vertices = make_vertex_array();
  glUseProgram(program);
  glUniform2i(glGetUniformLocation(program, "size"), width_, height_);
  if (compute) {
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding_pixels, pixels_.get());
  } else {
    bind_texture(0, plane, planes_[0]);
  }
  glBindVertexArray(vertices.get());
  prepare_for_raster(width_, height_);
  write_linear();
  if (!target.replace) {
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD), glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  }
  glDrawArrays(GL_TRIANGLES, 0, 3);
  check_gl("drawing into the texture of the frame");
}

} // namespace bccsplat
