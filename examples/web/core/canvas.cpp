// SPDX-License-Identifier: Apache-2.0
// Draws into a texture, and that onto the canvas, as the display wants its colours.
#include "canvas.h"

#include <GLES3/gl3.h>
#include <emscripten.h>

#include <algorithm>
#include <vector>

namespace web {
namespace {

struct Canvas {
  bccsplat_device* of = nullptr;
  Frame frame;
  GLuint texture = 0, program = 0, vertices = 0;
  uint32_t width = 0, height = 0;
};
Canvas canvas;

const char* const corner_source = R"(#version 300 es
void main() {
  vec2 corner = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1));
  gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
}
)";
// Lays linear light over the background, as PNGs of the tool have it, and encodes it for the display.
const char* const show_source = R"(#version 300 es
precision highp float;
uniform highp sampler2D picture;
uniform vec3 background;
uniform float exposure;
out vec4 color;
vec3 encoded(vec3 light) {
  vec3 low = 12.92 * light, high = 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055;
  return mix(high, low, vec3(lessThan(light, vec3(0.0031308))));
}
void main() {
  vec4 light = texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
  vec3 seen = exposure > 0.0 ? exposure * light.rgb : light.rgb + (1.0 - light.a) * background;
  color = vec4(encoded(clamp(seen, 0.0, 1.0)), 1.0);
}
)";

GLuint shader_of(GLenum kind, const char* source) {
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &source, nullptr);
  glCompileShader(shader);
  return shader;
}

void make_program() {
  canvas.program = glCreateProgram();
  glAttachShader(canvas.program, shader_of(GL_VERTEX_SHADER, corner_source));
  glAttachShader(canvas.program, shader_of(GL_FRAGMENT_SHADER, show_source));
  glLinkProgram(canvas.program);
  glGenVertexArrays(1, &canvas.vertices);
}

void make_texture(uint32_t width, uint32_t height) {
  glGenTextures(1, &canvas.texture);
  glBindTexture(GL_TEXTURE_2D, canvas.texture);
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32F, static_cast<GLsizei>(width), static_cast<GLsizei>(height));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

} // namespace

bccsplat_frame* canvas_frame(uint32_t width, uint32_t height) {
  if (canvas.frame && canvas.of == viewer.device.get() && canvas.width == width && canvas.height == height)
    return canvas.frame.get();
  canvas.frame.reset();
  if (canvas.texture) glDeleteTextures(1, &canvas.texture);
  make_texture(width, height);
  auto target = sized<bccsplat_gl_target>();
  target.texture = canvas.texture, target.width = width, target.height = height, target.replace = 1;
  canvas.frame = make(bccsplat_frame_wrap_gl, viewer.device.get(), &target);
  canvas.of = viewer.device.get(), canvas.width = width, canvas.height = height;
  return canvas.frame.get();
}

double white_pixel() {
  std::vector<float> pixels(size_t{4} * canvas.width * canvas.height);
  GLuint framebuffer = 0;
  glGenFramebuffers(1, &framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, canvas.texture, 0);
  glReadPixels(0, 0, static_cast<GLsizei>(canvas.width), static_cast<GLsizei>(canvas.height), GL_RGBA,
               GL_FLOAT, pixels.data());
  glDeleteFramebuffers(1, &framebuffer);
  std::vector<float> seen; // by the rays that meet the domain
  for (size_t n = 0; n < pixels.size(); n += 4)
    if (pixels[n + 3] > 0) seen.push_back(pixels[n]);
  if (seen.empty()) return 0;
  constexpr double share = 0.998; // of the rays are no brighter, as in the tool's X-rays
  const auto at = seen.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(seen.size() - 1));
  std::nth_element(seen.begin(), at, seen.end());
  return static_cast<double>(*at);
}

void show_canvas(const std::array<double, 3>& background, double exposure) {
  if (!canvas.program) make_program();
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, static_cast<GLsizei>(canvas.width), static_cast<GLsizei>(canvas.height));
  glUseProgram(canvas.program);
  glBindVertexArray(canvas.vertices);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, canvas.texture);
  const auto at = [](const char* name) { return glGetUniformLocation(canvas.program, name); };
  glUniform1i(at("picture"), 0);
  glUniform3f(at("background"), static_cast<float>(background[0]), static_cast<float>(background[1]),
              static_cast<float>(background[2]));
  glUniform1f(at("exposure"), static_cast<float>(exposure));
  glDrawArrays(GL_TRIANGLES, 0, 3);
  std::array<uint8_t, 4> pixel{};
  glReadPixels(0, 0, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel.data()); // waits for the picture
}

void drop_canvas() { canvas = Canvas(); }

} // namespace web

using namespace web;

extern "C" {

// The context is gone with all that it held; a new one is made for the canvas.
EMSCRIPTEN_KEEPALIVE void web_lose_context() {
  drop_canvas();
  viewer.renderer.reset();
}

EMSCRIPTEN_KEEPALIVE int web_renew() {
  return answer([] { viewer.renderer = make(bccsplat_renderer_create, viewer.device.get()); });
}

} // extern "C"
