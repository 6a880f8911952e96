// SPDX-License-Identifier: Apache-2.0
// Pictures in a texture of the host's OpenGL context: those of a frame in memory, over what the host has
// drawn and before what hides them, with the context's state as it was. Without EGL these are skipped.
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "../support.h"

using namespace host;

namespace {

constexpr uint32_t width = 56, height = 40;
using Pixels = std::vector<float>;

// A host's context, current on this thread.
class Context {
 public:
  explicit Context(int version) {
    std::array<EGLDeviceEXT, 8> devices{};
    EGLint count = 0;
    if (!epoxy_has_egl() || !epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device") ||
        !eglQueryDevicesEXT(8, devices.data(), &count))
      return;
    for (EGLint n = 0; n < count && !context_; ++n) {
      display_ = eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<size_t>(n)], nullptr);
      if (!eglInitialize(display_, nullptr, nullptr)) continue;
      eglBindAPI(EGL_OPENGL_API);
      const std::array<EGLint, 7> wishes{EGL_CONTEXT_MAJOR_VERSION,
                                         version / 10,
                                         EGL_CONTEXT_MINOR_VERSION,
                                         version % 10,
                                         EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                         EGL_NONE};
      context_ = eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wishes.data());
    }
    enter();
  }
  ~Context() {
    leave();
    if (context_) eglDestroyContext(display_, context_);
  }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  void enter() const {
    if (context_) eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_);
  }
  void leave() const {
    if (context_) eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  [[nodiscard]] bool there() const { return context_ != nullptr; }

 private:
  EGLDisplay display_ = nullptr;
  EGLContext context_ = nullptr;
};

// Rows of textures run from below.
Pixels turned(const Pixels& p, size_t components) {
  Pixels out(p.size());
  const size_t row = width * components;
  for (size_t y = 0; y < height; ++y)
    std::copy_n(p.begin() + static_cast<std::ptrdiff_t>(y * row), row,
                out.begin() + static_cast<std::ptrdiff_t>((height - 1 - y) * row));
  return out;
}

GLuint texture_of(GLint internal, GLenum format, const Pixels& texels) {
  GLuint name = 0;
  glGenTextures(1, &name);
  glBindTexture(GL_TEXTURE_2D, name);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  glTexImage2D(GL_TEXTURE_2D, 0, internal, width, height, 0, format, GL_FLOAT, texels.data());
  glBindTexture(GL_TEXTURE_2D, 0);
  return name;
}

Pixels texels_of(GLuint name) {
  Pixels out(size_t{4} * width * height);
  glBindTexture(GL_TEXTURE_2D, name);
  glGetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, out.data());
  glBindTexture(GL_TEXTURE_2D, 0);
  return turned(out, 4);
}

double db(const Pixels& a, const Pixels& b) {
  double sum = 0;
  for (size_t n = 0; n < a.size(); ++n) sum += std::pow(static_cast<double>(a[n]) - b[n], 2);
  return -10 * std::log10(sum / static_cast<double>(a.size()));
}

// Numbers of state that a host may have set.
std::vector<GLint> state(bool storage) {
  std::vector<GLint> out;
  const auto add = [&](GLenum name, size_t count = 1) {
    std::array<GLint, 4> value{};
    glGetIntegerv(name, value.data());
    out.insert(out.end(), value.begin(), value.begin() + static_cast<std::ptrdiff_t>(count));
  };
  for (const GLenum name : {GL_CURRENT_PROGRAM,
                            GL_VERTEX_ARRAY_BINDING,
                            GL_DRAW_FRAMEBUFFER_BINDING,
                            GL_READ_FRAMEBUFFER_BINDING,
                            GL_PIXEL_UNPACK_BUFFER_BINDING,
                            GL_PIXEL_PACK_BUFFER_BINDING,
                            GL_UNIFORM_BUFFER_BINDING,
                            GL_BLEND_SRC_RGB,
                            GL_BLEND_DST_ALPHA,
                            GL_BLEND_EQUATION_RGB,
                            GL_UNPACK_ROW_LENGTH,
                            GL_UNPACK_ALIGNMENT,
                            GL_PACK_ALIGNMENT,
                            GL_UNPACK_SKIP_ROWS,
                            GL_BLEND,
                            GL_DEPTH_TEST,
                            GL_CULL_FACE,
                            GL_SCISSOR_TEST,
                            GL_STENCIL_TEST,
                            GL_FRAMEBUFFER_SRGB,
                            GL_ACTIVE_TEXTURE})
    add(name);
  for (const GLenum name : {GL_VIEWPORT, GL_SCISSOR_BOX, GL_COLOR_WRITEMASK}) add(name, 4);
  GLint active = 0;
  glGetIntegerv(GL_ACTIVE_TEXTURE, &active);
  for (GLenum unit = 0; unit < 6; ++unit) {
    glActiveTexture(GL_TEXTURE0 + unit);
    for (const GLenum name : {GL_TEXTURE_BINDING_2D, GL_TEXTURE_BINDING_3D, GL_SAMPLER_BINDING}) add(name);
  }
  glActiveTexture(static_cast<GLenum>(active));
  for (GLuint n = 0; n < 2; ++n) {
    GLint value = 0;
    glGetIntegeri_v(GL_UNIFORM_BUFFER_BINDING, n, &value), out.push_back(value);
    if (storage) glGetIntegeri_v(GL_SHADER_STORAGE_BUFFER_BINDING, n, &value), out.push_back(value);
  }
  return out;
}

// Leaves the context as a host in the middle of its own work might.
void make_busy(bool storage) {
  GLuint buffers[3] = {}, sampler = 0, array = 0, textures[2] = {};
  glGenBuffers(3, buffers), glGenSamplers(1, &sampler), glGenVertexArrays(1, &array),
      glGenTextures(2, textures);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, buffers[0]);
  glBindBuffer(GL_UNIFORM_BUFFER, buffers[1]);
  glBufferData(GL_UNIFORM_BUFFER, 1024, nullptr, GL_STATIC_DRAW);
  glBindBufferRange(GL_UNIFORM_BUFFER, 0, buffers[1], 256, 512);
  if (storage) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, buffers[2]);
  glBindSampler(2, sampler), glBindVertexArray(array);
  glActiveTexture(GL_TEXTURE3), glBindTexture(GL_TEXTURE_2D, textures[0]);
  glActiveTexture(GL_TEXTURE4), glBindTexture(GL_TEXTURE_3D, textures[1]);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 77), glPixelStorei(GL_UNPACK_SKIP_ROWS, 3),
      glPixelStorei(GL_PACK_ALIGNMENT, 8);
  glEnable(GL_BLEND), glEnable(GL_DEPTH_TEST), glEnable(GL_CULL_FACE), glEnable(GL_SCISSOR_TEST);
  glCullFace(GL_FRONT_AND_BACK);
  glBlendFunc(GL_DST_COLOR, GL_ZERO), glBlendEquation(GL_FUNC_SUBTRACT);
  glViewport(3, 4, 5, 6), glScissor(1, 2, 3, 4), glColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
}

void make_idle() {
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0), glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0), glPixelStorei(GL_UNPACK_SKIP_ROWS, 0),
      glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glActiveTexture(GL_TEXTURE0);
}

class GpuTexture : public testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    if (!context_.there()) {
      std::fprintf(stderr, "NOT TESTED: EGL gives no context of OpenGL %d\n", GetParam());
      GTEST_SKIP() << "no context";
    }
    device_ = make_device();
    Series s;
    s.nx = s.ny = s.nz = 26;
    write_series(device_, folder_.file("s.bcc4"), s);
    volume_ = open(device_, folder_.file("s.bcc4"));
    slice_ = cut_time(volume_, 1.5);
    bccsplat_renderer* created = nullptr;
    ASSERT_OK(bccsplat_renderer_create(device_.get(), &created));
    renderer_ = Renderer(created);
    ASSERT_OK(bccsplat_renderer_set_slice(created, slice_.get()));
    const double colors[8] = {0, 1, 0.3, 0.1, 100, 0.2, 0.9, 1}, opacities[4] = {5, 0, 60, 0.7};
    auto function = sized<bccsplat_transfer_function>();
    function.colors = colors, function.color_count = 2;
    function.opacities = opacities, function.opacity_count = 2;
    ASSERT_OK(bccsplat_renderer_set_transfer_function(created, &function));
    auto camera = sized<bccsplat_camera>();
    ASSERT_OK(bccsplat_slice_fit_camera(slice_.get(), BCCSPLAT_PROJECTION_PERSPECTIVE, 20, 30, width, height,
                                        &camera));
    distance_ = std::hypot(camera.target[0] - camera.position[0], camera.target[1] - camera.position[1],
                           camera.target[2] - camera.position[2]);
    view_.use_matrices = 1, view_.depth_kind = BCCSPLAT_DEPTH_DEVICE;
    ASSERT_OK(bccsplat_camera_get_matrices(&camera, width, height, distance_ / 4, distance_ * 4,
                                           view_.depth_range, 0, view_.world_to_view, view_.projection));
  }
  [[nodiscard]] bool storage() const { return GetParam() >= 43; }
  [[nodiscard]] Frame wrap(GLuint texture, GLuint depth, int32_t replace = 0) const {
    auto target = sized<bccsplat_gl_target>();
    target.texture = texture, target.width = width, target.height = height, target.depth_texture = depth,
    target.replace = replace;
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_wrap_gl(device_.get(), &target, &f));
    return Frame(f);
  }
  // The CPU's picture, of the view with its depths and background.
  [[nodiscard]] Pixels expected(const bccsplat_view& view) const {
    EXPECT_OK(bccsplat_renderer_set_view(renderer_.get(), &view));
    bccsplat_frame* created = nullptr;
    EXPECT_OK(bccsplat_frame_create(device_.get(), width, height, 0, &created));
    const Frame f(created);
    EXPECT_OK(bccsplat_renderer_render(renderer_.get(), created));
    auto plane = sized<bccsplat_plane>();
    EXPECT_OK(bccsplat_frame_get_channel(created, BCCSPLAT_FRAME_RGBA, &plane));
    return {plane.pixels, plane.pixels + size_t{4} * width * height};
  }

  const Folder folder_;
  const Context context_{GetParam()};
  Device device_;
  Volume volume_;
  Slice slice_;
  Renderer renderer_;
  bccsplat_view view_ = sized<bccsplat_view>();
  double distance_ = 0;
};

Pixels chequers() {
  Pixels p(size_t{4} * width * height);
  for (size_t n = 0; n < p.size(); ++n)
    p[n] = n % 4 == 3 ? 1.0f : 0.25f * static_cast<float>((n / 4 / 7 + n / 4 / width / 5 + n % 4) % 3);
  return p;
}

TEST_P(GpuTexture, LiesOverTheHostsPictureBeforeItsDepths) {
  const Pixels behind = chequers();
  Pixels depth(size_t{width} * height);
  // An opaque wall aslant through the volume, in device depths.
  for (size_t n = 0; n < depth.size(); ++n) {
    const double across = static_cast<double>(n % width) / width;
    const double d = distance_ * (0.6 + 0.6 * across);
    depth[n] = n % width < 5 ? 1.0f : static_cast<float>(4.0 / (4 - 0.25) * (1 - 0.25 * distance_ / d));
  }
  const GLuint texture = texture_of(GL_RGBA32F, GL_RGBA, turned(behind, 4)),
               hidden = texture_of(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, turned(depth, 1));
  ASSERT_OK(bccsplat_renderer_set_view(renderer_.get(), &view_));
  {
    const Frame frame = wrap(texture, hidden);
    make_busy(storage());
    const std::vector<GLint> before = state(storage());
    ASSERT_OK(bccsplat_renderer_render(renderer_.get(), frame.get()));
    EXPECT_EQ(state(storage()), before);
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    auto stats = sized<bccsplat_render_stats>();
    ASSERT_OK(bccsplat_renderer_get_stats(renderer_.get(), &stats));
    EXPECT_EQ(stats.backend, BCCSPLAT_BACKEND_GPU);
  }
  make_idle();
  const Pixels drawn = texels_of(texture);
  bccsplat_view cpu = view_;
  cpu.background = behind.data();
  const Pixels without = expected(cpu);
  cpu.depth = depth.data();
  const Pixels with = expected(cpu);
  EXPECT_LT(db(with, without), 35) << "the wall hides nothing";
  EXPECT_LT(db(with, behind), 35) << "nothing is drawn";
  EXPECT_GT(db(drawn, with), 45);
}

TEST_P(GpuTexture, ReplacesAndIsDrawnAgain) {
  const GLuint texture = texture_of(GL_RGBA16F, GL_RGBA, chequers());
  const Frame frame = wrap(texture, 0, 1);
  for (const double time : {1.5, 0.5}) { // another slice, where the one before stood or elsewhere
    slice_ = cut_time(volume_, time);
    ASSERT_OK(bccsplat_renderer_set_slice(renderer_.get(), slice_.get()));
    ASSERT_OK(bccsplat_renderer_set_view(renderer_.get(), &view_));
    for (int n = 0; n < 2; ++n) ASSERT_OK(bccsplat_renderer_render(renderer_.get(), frame.get()));
    EXPECT_GT(db(texels_of(texture), expected(view_)), 45) << time;
  }
}

TEST_P(GpuTexture, AScenesPicture) {
  const GLuint texture = texture_of(GL_RGBA32F, GL_RGBA, chequers());
  const Frame frame = wrap(texture, 0, 1);
  bccsplat_scene* created = nullptr;
  ASSERT_OK(bccsplat_scene_create(device_.get(), &created));
  const Handle<bccsplat_scene> scene(created);
  const auto instance = sized<bccsplat_instance>(); // with the channel's look
  ASSERT_OK(bccsplat_renderer_set_transfer_function(renderer_.get(), nullptr));
  uint64_t id = 0;
  ASSERT_OK(bccsplat_scene_add(created, volume_.get(), &instance, &id));
  for (const double frame_index : {1.5, 2.0}) {
    double time = 0;
    Series s;
    time = s.first + s.step * frame_index;
    ASSERT_OK(bccsplat_scene_set_time(created, time));
    ASSERT_OK(bccsplat_scene_render(created, &view_, frame.get(), nullptr, 0, nullptr));
    slice_ = cut_time(volume_, frame_index);
    ASSERT_OK(bccsplat_renderer_set_slice(renderer_.get(), slice_.get()));
    EXPECT_GT(db(texels_of(texture), expected(view_)), 45) << frame_index;
  }
  EXPECT_EQ(bccsplat_scene_render(created, &view_, frame.get(), nullptr, 20, nullptr),
            BCCSPLAT_ERROR_UNSUPPORTED);
}

// Nothing replaces, or is laid over, what is there like any picture.
TEST_P(GpuTexture, ASceneOfNothing) {
  const Pixels before = chequers();
  const GLuint texture = texture_of(GL_RGBA32F, GL_RGBA, turned(before, 4));
  bccsplat_scene* created = nullptr;
  ASSERT_OK(bccsplat_scene_create(device_.get(), &created));
  const Handle<bccsplat_scene> scene(created);
  auto instance = sized<bccsplat_instance>();
  instance.hidden = 1;
  uint64_t id = 0;
  ASSERT_OK(bccsplat_scene_add(created, volume_.get(), &instance, &id));
  {
    const Frame over = wrap(texture, 0, 0);
    ASSERT_OK(bccsplat_scene_render(created, &view_, over.get(), nullptr, 0, nullptr));
    EXPECT_EQ(texels_of(texture), before);
  }
  const Frame instead = wrap(texture, 0, 1);
  make_busy(storage());
  const std::vector<GLint> state_before = state(storage());
  ASSERT_OK(bccsplat_scene_render(created, &view_, instead.get(), nullptr, 0, nullptr));
  EXPECT_EQ(state(storage()), state_before);
  make_idle();
  EXPECT_EQ(texels_of(texture), Pixels(before.size(), 0.0f));
  context_.leave();
  EXPECT_EQ(bccsplat_scene_render(created, &view_, instead.get(), nullptr, 0, nullptr),
            BCCSPLAT_ERROR_MISSING_FEATURE);
  context_.enter();
}

TEST_P(GpuTexture, RefusalsSayWhy) {
  const GLuint texture = texture_of(GL_RGBA32F, GL_RGBA, chequers());
  const auto refused = [&](const Frame& f, bccsplat_status status, const char* words) {
    EXPECT_EQ(bccsplat_renderer_render(renderer_.get(), f.get()), status);
    EXPECT_NE(std::string(bccsplat_last_error()).find(words), std::string::npos) << bccsplat_last_error();
  };
  const Frame frame = wrap(texture, texture);
  ASSERT_OK(bccsplat_renderer_set_view(renderer_.get(), nullptr));
  refused(frame, BCCSPLAT_ERROR_INVALID_ARGUMENT, "needs a view by matrices");
  const Frame other = wrap(texture, 0);
  context_.leave();
  refused(other, BCCSPLAT_ERROR_MISSING_FEATURE, "no OpenGL context is current");
  context_.enter();
  ASSERT_OK(bccsplat_renderer_render(renderer_.get(), other.get()));
  auto plane = sized<bccsplat_plane>();
  EXPECT_EQ(bccsplat_frame_get_channel(other.get(), BCCSPLAT_FRAME_RGBA, &plane), BCCSPLAT_ERROR_NOT_FOUND);
  EXPECT_EQ(bccsplat_frame_save_png(other.get(), folder_.file("x.png").c_str(), nullptr),
            BCCSPLAT_ERROR_UNSUPPORTED);
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -1, trail.intervals = 100;
  ASSERT_OK(bccsplat_renderer_set_trail(renderer_.get(), &trail));
  refused(other, BCCSPLAT_ERROR_UNSUPPORTED, "stills");
  context_.leave(); // what the frame keeps is left to the context
}

INSTANTIATE_TEST_SUITE_P(Versions, GpuTexture, testing::Values(33, 43),
                         [](const auto& p) { return "gl" + std::to_string(p.param); });

} // namespace
