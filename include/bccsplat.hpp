// SPDX-License-Identifier: Apache-2.0
// bccsplat.h for hosts in C++ from C++17 on: handles that release themselves, statuses as exceptions, structs
// with their size set. Everything is in this file; nothing of it is in the library.
//
//   using namespace bccsplat::client;
//   const Device device = make(bccsplat_device_create, nullptr);
//   const Volume volume = make(bccsplat_volume_open_file, device.get(), "smoke.bcc4", nullptr);
//   auto info = sized<bccsplat_volume_info>();
//   check(bccsplat_volume_get_info(volume.get(), &info));
#ifndef BCCSPLAT_HPP
#define BCCSPLAT_HPP

#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>

#include "bccsplat.h"

namespace bccsplat {
namespace client {

// A struct of the API, cleared, with its size set.
template<class Struct> [[nodiscard]] Struct sized() {
  Struct s{};
  s.struct_size = sizeof(Struct);
  return s;
}

// A call that failed; what() is bccsplat_last_error() and the name of the status.
class Error : public std::runtime_error {
 public:
  explicit Error(bccsplat_status status)
      : std::runtime_error(
            std::string(bccsplat_last_error()) + " (" + bccsplat_status_name(status) + ")"),
        status_(status) {}
  [[nodiscard]] bccsplat_status status() const noexcept { return status_; }

 private:
  bccsplat_status status_;
};

// Throws Error unless the status is OK; to be called by the thread that made the call.
inline void check(bccsplat_status status) {
  if (status != BCCSPLAT_OK) throw Error(status);
}

struct Retain {
  void operator()(bccsplat_cancel_token* h) const noexcept { bccsplat_cancel_token_retain(h); }
  void operator()(bccsplat_device* h) const noexcept { bccsplat_device_retain(h); }
  void operator()(bccsplat_plan* h) const noexcept { bccsplat_plan_retain(h); }
  void operator()(bccsplat_writer* h) const noexcept { bccsplat_writer_retain(h); }
  void operator()(bccsplat_volume* h) const noexcept { bccsplat_volume_retain(h); }
  void operator()(bccsplat_slice* h) const noexcept { bccsplat_slice_retain(h); }
  void operator()(bccsplat_renderer* h) const noexcept { bccsplat_renderer_retain(h); }
  void operator()(bccsplat_frame* h) const noexcept { bccsplat_frame_retain(h); }
  void operator()(bccsplat_scene* h) const noexcept { bccsplat_scene_retain(h); }
};
struct Release {
  void operator()(bccsplat_cancel_token* h) const noexcept { bccsplat_cancel_token_release(h); }
  void operator()(bccsplat_device* h) const noexcept { bccsplat_device_release(h); }
  void operator()(bccsplat_plan* h) const noexcept { bccsplat_plan_release(h); }
  void operator()(bccsplat_writer* h) const noexcept { bccsplat_writer_release(h); }
  void operator()(bccsplat_volume* h) const noexcept { bccsplat_volume_release(h); }
  void operator()(bccsplat_slice* h) const noexcept { bccsplat_slice_release(h); }
  void operator()(bccsplat_renderer* h) const noexcept { bccsplat_renderer_release(h); }
  void operator()(bccsplat_frame* h) const noexcept { bccsplat_frame_release(h); }
  void operator()(bccsplat_scene* h) const noexcept { bccsplat_scene_release(h); }
};

// One reference to an object, or none.
template<class Object> using Handle = std::unique_ptr<Object, Release>;
using CancelToken = Handle<bccsplat_cancel_token>;
using Device = Handle<bccsplat_device>;
using Plan = Handle<bccsplat_plan>;
using Writer = Handle<bccsplat_writer>; // released unfinished it leaves no file
using Volume = Handle<bccsplat_volume>;
using Slice = Handle<bccsplat_slice>;
using Renderer = Handle<bccsplat_renderer>;
using Frame = Handle<bccsplat_frame>;
using Scene = Handle<bccsplat_scene>;

// Returns another reference to the same object.
template<class Object> [[nodiscard]] Handle<Object> share(const Handle<Object>& handle) {
  if (handle) Retain()(handle.get());
  return Handle<Object>(handle.get());
}

// Calls a function that makes an object into its last parameter, and returns it. Throws Error.
template<class... Parameters, class... Arguments>
[[nodiscard]] auto make(bccsplat_status (*function)(Parameters...), Arguments&&... arguments) {
  using Last = std::tuple_element_t<sizeof...(Parameters) - 1, std::tuple<Parameters...>>;
  using Object = std::remove_pointer_t<std::remove_pointer_t<Last>>;
  Object* made = nullptr;
  check(function(arguments..., &made));
  return Handle<Object>(made);
}

} // namespace client
} // namespace bccsplat

#endif
