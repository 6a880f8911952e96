// SPDX-License-Identifier: Apache-2.0
// texture_host FILE.bcc4 OUT.ppm [TIME]: a host of OpenGL that draws a volume into its own texture, over what
// it has drawn there, before it shows it; here it writes the texture to a file. Its context has no window,
// so that it runs on servers, by Mesa where there is no card. What a host does is draw_volume(); all around
// it stands for the host's own program.
#include <bccsplat.h>

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

constexpr int width = 320, height = 240;

void check(bccsplat_status status) {
  if (status != BCCSPLAT_OK) throw std::runtime_error(bccsplat_last_error());
}

// A structure of the library with its size.
template<class T> T sized() {
  T out{};
  out.struct_size = sizeof out;
  return out;
}

// Draws a scene into a texture of the current context, over what it holds.
void draw_volume(bccsplat_device* device, bccsplat_scene* scene, const bccsplat_camera& camera,
                 GLuint texture) {
  auto target = sized<bccsplat_gl_target>();
  target.texture = texture, target.width = width, target.height = height;
  bccsplat_frame* frame = nullptr;
  check(bccsplat_frame_wrap_gl(device, &target, &frame)); // a host keeps it as long as the texture
  auto view = sized<bccsplat_view>();
  view.camera = &camera;
  const bccsplat_status status = bccsplat_scene_render(scene, &view, frame, nullptr, 0, nullptr);
  const std::string why = status == BCCSPLAT_OK ? "" : bccsplat_last_error();
  bccsplat_frame_release(frame);
  if (status != BCCSPLAT_OK) throw std::runtime_error(why);
}

// Makes a context of OpenGL 3.3 current, without a window.
void enter_opengl() {
  std::array<EGLDeviceEXT, 16> devices{};
  EGLint count = 0;
  if (!epoxy_has_egl() || !epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device") ||
      !eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count))
    throw std::runtime_error("no EGL that finds devices");
  constexpr std::array<EGLint, 7> wishes{EGL_CONTEXT_MAJOR_VERSION,
                                         3,
                                         EGL_CONTEXT_MINOR_VERSION,
                                         3,
                                         EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                         EGL_NONE};
  for (EGLint n = 0; n < count; ++n) {
    EGLDisplay display =
        eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<size_t>(n)], nullptr);
    if (!eglInitialize(display, nullptr, nullptr) || !eglBindAPI(EGL_OPENGL_API)) continue;
    EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wishes.data());
    if (context && eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) return;
  }
  throw std::runtime_error("no context of OpenGL 3.3");
}

// The host's own picture: a sky.
GLuint draw_sky() {
  std::vector<float> sky;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float high = static_cast<float>(y) / height;
      sky.insert(sky.end(), {0.02f, 0.05f + 0.05f * high, 0.1f + 0.2f * high, 1.0f});
    }
  GLuint texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, width, height, 0, GL_RGBA, GL_FLOAT, sky.data());
  return texture;
}

// Writes the texture as it would be shown: sRGB, rows from above.
void save(GLuint texture, const char* path) {
  std::vector<float> pixels(size_t{4} * width * height);
  glBindTexture(GL_TEXTURE_2D, texture);
  glGetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, pixels.data());
  std::ofstream out(path, std::ios::binary);
  out << "P6\n" << width << ' ' << height << "\n255\n";
  for (int y = height; y-- > 0;)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) {
        const float linear = std::clamp(pixels[4 * (static_cast<size_t>(y) * width + x) + c], 0.0f, 1.0f);
        const float coded =
            linear < 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
        out.put(static_cast<char>(std::lround(255 * coded)));
      }
  if (!out) throw std::runtime_error(std::string("cannot write ") + path);
}

// The library's handles, released in the end.
struct Handles {
  bccsplat_device* device = nullptr;
  bccsplat_volume* volume = nullptr;
  bccsplat_scene* scene = nullptr;
  Handles() = default;
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;
  ~Handles() {
    bccsplat_scene_release(scene), bccsplat_volume_release(volume), bccsplat_device_release(device);
  }
};

void run(const char* volume, const char* picture, const char* time) {
  enter_opengl();
  const GLuint texture = draw_sky();
  Handles host;
  uint64_t id = 0;
  check(bccsplat_device_create(nullptr, &host.device));
  check(bccsplat_volume_open_file(host.device, volume, nullptr, &host.volume));
  check(bccsplat_scene_create(host.device, &host.scene));
  check(bccsplat_scene_add(host.scene, host.volume, nullptr, &id));
  if (time) check(bccsplat_scene_set_time(host.scene, std::strtod(time, nullptr)));
  auto fit = sized<bccsplat_fit>();
  fit.rotate_x_degrees = 20, fit.rotate_y_degrees = 30;
  check(bccsplat_scene_get_bounds(host.scene, fit.bounds));
  auto camera = sized<bccsplat_camera>();
  check(bccsplat_fit_camera(&fit, width, height, &camera));
  draw_volume(host.device, host.scene, camera, texture);
  save(texture, picture);
  std::printf("%s by %s\n", picture, reinterpret_cast<const char*>(glGetString(GL_RENDERER)));
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 3 || argc > 4) {
    std::fprintf(stderr, "usage: texture_host FILE.bcc4 OUT.ppm [TIME]\n");
    return 2;
  }
  try {
    run(argv[1], argv[2], argc == 4 ? argv[3] : nullptr);
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "texture_host: %s\n", e.what());
    return 1;
  }
}
