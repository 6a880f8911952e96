// SPDX-License-Identifier: Apache-2.0
// Looks through the devices of EGL, cards before rasterisers on the CPU, for the first that gives a context.
#include "gpu/gl_context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "base/machine.h"

namespace bccsplat {
namespace {

constexpr int compute_version = 43, fragment_version = 33; // of OpenGL, times 10

// The loader of libepoxy ends the process where a library is not there.
bool has_libraries() {
  return machine_has_library("libEGL.so.1") &&
         (machine_has_library("libOpenGL.so.0") || machine_has_library("libGL.so.1"));
}

bool has_word(const char* words, const char* word) {
  const size_t size = std::strlen(word);
  for (const char* at = words; at && (at = std::strstr(at, word)); at += size)
    if ((at == words || at[-1] == ' ') && (at[size] == ' ' || at[size] == 0)) return true;
  return false;
}

struct Device {
  EGLDeviceEXT handle = nullptr;
  bool software = false;
};

// Cards first.
std::vector<Device> find_devices() {
  std::vector<Device> out;
  const char* const words = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (!words || !has_word(words, "EGL_EXT_platform_device") ||
      !(has_word(words, "EGL_EXT_device_enumeration") || has_word(words, "EGL_EXT_device_base")))
    return out;
  constexpr EGLint most = 32;
  std::array<EGLDeviceEXT, most> found{};
  EGLint count = 0;
  if (!eglQueryDevicesEXT(most, found.data(), &count)) return out;
  for (EGLint n = 0; n < count; ++n) {
    const char* const of = eglQueryDeviceStringEXT(found[n], EGL_EXTENSIONS);
    out.push_back({found[n], of && has_word(of, "EGL_MESA_device_software")});
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Device& a, const Device& b) { return a.software < b.software; });
  return out;
}

EGLContext context_of(EGLDisplay display, int version) {
  constexpr EGLint tens = 10;
  const std::array<EGLint, 7> attributes{EGL_CONTEXT_MAJOR_VERSION,
                                         version / tens,
                                         EGL_CONTEXT_MINOR_VERSION,
                                         version % tens,
                                         EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                         EGL_NONE};
  return eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
}

// Makes a context of the display current; null where it gives none.
EGLContext enter(EGLDisplay display, GpuEntry entry) {
  EGLint major = 0, minor = 0;
  if (!display || !eglInitialize(display, &major, &minor) || !eglBindAPI(EGL_OPENGL_API)) return nullptr;
  const char* const words = eglQueryString(display, EGL_EXTENSIONS);
  if (!has_word(words, "EGL_KHR_no_config_context") || !has_word(words, "EGL_KHR_surfaceless_context"))
    return nullptr;
  for (const int version : {compute_version, fragment_version}) {
    if (version == compute_version && entry == GpuEntry::fragment) continue;
    if (version == fragment_version && entry == GpuEntry::compute) continue;
    const EGLContext context = context_of(display, version);
    if (!context) continue;
    if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) return context;
    eglDestroyContext(display, context);
  }
  return nullptr;
}

std::string gl_text(GLenum name) {
  const auto* const text = reinterpret_cast<const char*>(glGetString(name));
  return text ? text : "";
}

bool draws_on_the_cpu(const std::string& renderer) {
  constexpr std::array names{"llvmpipe", "softpipe", "swrast", "SwiftShader", "Software Rasterizer"};
  return std::any_of(names.begin(), names.end(),
                     [&](const char* n) { return renderer.find(n) != std::string::npos; });
}

uint64_t card_memory() {
  constexpr uint64_t kib = 1024;
  GLint size = 0;
  if (epoxy_has_gl_extension("GL_NVX_gpu_memory_info"))
    glGetIntegerv(GL_GPU_MEMORY_INFO_DEDICATED_VIDMEM_NVX, &size);
  return static_cast<uint64_t>(std::max(size, 0)) * kib;
}

} // namespace

GpuInfo current_context_info(GpuEntry entry) {
  GpuInfo info;
  info.vendor = gl_text(GL_VENDOR), info.renderer = gl_text(GL_RENDERER), info.version = gl_text(GL_VERSION);
  info.software = draws_on_the_cpu(info.renderer);
  info.memory = card_memory();
  const int version = epoxy_gl_version();
  if (!epoxy_is_desktop_gl() || version < fragment_version)
    fail_gpu("OpenGL ", info.version, " is too old; it takes 3.3");
  info.entry =
      version >= compute_version && entry != GpuEntry::fragment ? GpuEntry::compute : GpuEntry::fragment;
  if (entry == GpuEntry::compute && info.entry != entry)
    fail_gpu("OpenGL ", info.version, " has no compute shaders; they take 4.3");
  return info;
}

const void* current_gl_context() {
  if (!has_libraries() || !epoxy_has_egl()) return nullptr;
  if (const EGLContext context = eglGetCurrentContext()) return context;
  using Current = void* (*)();
  const auto of_glx = reinterpret_cast<Current>(machine_symbol("glXGetCurrentContext"));
  return of_glx ? of_glx() : nullptr;
}

bool any_graphics_card() {
  if (!has_libraries() || !epoxy_has_egl()) return false;
  const std::vector<Device> devices = find_devices();
  return !devices.empty() && !devices.front().software;
}

GlContext::GlContext(const GpuWishes& wishes) {
  if (!has_libraries() || !epoxy_has_egl())
    fail_gpu("the system has no EGL or no OpenGL (libEGL.so.1, libOpenGL.so.0); install its driver");
  for (const Device& device : find_devices()) {
    if (device.software && !wishes.software_too) continue;
    const EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device.handle, nullptr);
    context_ = enter(display, wishes.entry);
    if (!context_) continue;
    display_ = display;
    info_ = current_context_info(wishes.entry);
    if (!info_.software || wishes.software_too) return;
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
    context_ = nullptr;
  }
  fail_gpu(wishes.software_too ? "no device gives a context of OpenGL 3.3; install a driver, or Mesa's"
                               : "no card gives a context of OpenGL 3.3; install its driver");
}

GlContext::~GlContext() {
  if (!context_) return;
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
}

} // namespace bccsplat
