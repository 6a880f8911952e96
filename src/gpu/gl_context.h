// SPDX-License-Identifier: Apache-2.0
// An OpenGL context without a window, through EGL.
#pragma once

#include "gpu/gpu_info.h"

namespace bccsplat {

// Returns whether there is a card that a context could be made on, without loading its driver.
[[nodiscard]] bool any_graphics_card();

// Whether there are no other contexts than the host's, as in a browser.
#if defined(__EMSCRIPTEN__)
inline constexpr bool only_host_contexts = true;
#else
inline constexpr bool only_host_contexts = false;
#endif

// Lives, and is current, on the thread that made it. The displays of EGL are a process's: none is terminated,
// for the host may use it, too.
class GlContext {
 public:
  // Throws GpuFailure where there is none.
  explicit GlContext(const GpuWishes& wishes);
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;
  [[nodiscard]] const GpuInfo& info() const { return info_; }

 private:
  void* display_ = nullptr;
  void* context_ = nullptr;
  GpuInfo info_;
};

// The context that is current on this thread, by EGL or GLX; null: none.
[[nodiscard]] const void* current_gl_context();
// What the current context is; entry: as asked for, or the best it has. Throws GpuFailure where it has none.
[[nodiscard]] GpuInfo current_context_info(GpuEntry entry);

} // namespace bccsplat
