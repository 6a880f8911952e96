// SPDX-License-Identifier: Apache-2.0
// Handles of the C ABI that release themselves, and structs with their size set.
#pragma once

#include <memory>

#include <bccsplat.h>

namespace host {

template<class T> [[nodiscard]] T sized() {
  T t{};
  t.struct_size = sizeof(T);
  return t;
}

struct Releaser {
  void operator()(bccsplat_device* h) const { bccsplat_device_release(h); }
  void operator()(bccsplat_writer* h) const { bccsplat_writer_release(h); }
  void operator()(bccsplat_volume* h) const { bccsplat_volume_release(h); }
  void operator()(bccsplat_slice* h) const { bccsplat_slice_release(h); }
  void operator()(bccsplat_renderer* h) const { bccsplat_renderer_release(h); }
  void operator()(bccsplat_frame* h) const { bccsplat_frame_release(h); }
  void operator()(bccsplat_scene* h) const { bccsplat_scene_release(h); }
  void operator()(bccsplat_cancel_token* h) const { bccsplat_cancel_token_release(h); }
};
template<class T> using Handle = std::unique_ptr<T, Releaser>;

} // namespace host
