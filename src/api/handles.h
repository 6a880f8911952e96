// SPDX-License-Identifier: Apache-2.0
// What the opaque handles point to. Each is reference counted and keeps its parents alive.
#pragma once

#include <atomic>
#include <concepts>
#include <memory>
#include <mutex>
#include <optional>
#include <semaphore>
#include <string>
#include <utility>
#include <vector>

#include "bccsplat.h"

#include "api/guard.h"
#include "base/context.h"
#include "scene/picture.h"
#include "scene/save_picture.h"
#include "view/camera.h"
#include "volume/open_slice.h"

namespace bccsplat::api {

// What a handle points to begins with its kind: C casts any handle into any other.
enum class Kind : uint32_t {
  device = 0x42434431, // odd numbers, that memory of other things hardly begins with
  volume = 0x42435631,
  slice = 0x42435331,
  renderer = 0x42435231,
  frame = 0x42434631,
  writer = 0x42435731,
  cancel_token = 0x42435431,
  scene = 0x42434531,
  plan = 0x42435031
};

struct Counted {
  explicit Counted(Kind k) : kind(k) {}
  const Kind kind;
  std::atomic<uint32_t> references{1};
};

template<Kind own> struct Object : Counted {
  static constexpr Kind own_kind = own;
  Object() : Counted(own) {}
};

// Every function asks this of its handles first.
template<std::derived_from<Counted> Handle> void require(const Handle* handle, const char* name) {
  if (!handle) fail(Code::invalid_argument, name, " is NULL");
  if (handle->kind != Handle::own_kind) fail(Code::invalid_handle, name, " is a handle of another kind");
}

template<class Handle> void retain(Handle* handle) noexcept {
  if (handle && handle->kind == Handle::own_kind) handle->references.fetch_add(1, std::memory_order_relaxed);
}
template<class Handle> void release(Handle* handle) noexcept {
  if (!handle || handle->kind != Handle::own_kind) return;
  if (handle->references.fetch_sub(1, std::memory_order_acq_rel) == 1) delete handle;
}

// Who uses an object: one call that changes it, or any number that do not. A call that comes meanwhile, from
// another thread or out of a callback, is refused instead of waiting for what may wait for it.
class Users {
 public:
  [[nodiscard]] bool try_alone() {
    int none = 0;
    return count_.compare_exchange_strong(none, -1, std::memory_order_acquire);
  }
  [[nodiscard]] bool try_shared() {
    int now = count_.load(std::memory_order_relaxed);
    while (now >= 0)
      if (count_.compare_exchange_weak(now, now + 1, std::memory_order_acquire)) return true;
    return false;
  }
  void end_alone() { count_.store(0, std::memory_order_release); }
  void end_shared() { count_.fetch_sub(1, std::memory_order_release); }

 private:
  std::atomic<int> count_{0};
};

// Keeps a handle to one call for the length of the call. The handle is checked, too.
template<class Handle> class Alone {
 public:
  Alone(Handle* handle, const char* name) : handle_(handle) {
    require(handle, name);
    if (!handle->users.try_alone()) fail(Code::wrong_state, name, ": another call is using it");
  }
  ~Alone() { handle_->users.end_alone(); }
  Alone(const Alone&) = delete;
  Alone& operator=(const Alone&) = delete;

 private:
  Handle* handle_;
};
template<class Handle> class Shared {
 public:
  Shared(const Handle* handle, const char* name) : handle_(handle) {
    require(handle, name);
    if (!handle->users.try_shared()) fail(Code::wrong_state, name, ": another call is changing it");
  }
  ~Shared() { handle_->users.end_shared(); }
  Shared(const Shared&) = delete;
  Shared& operator=(const Shared&) = delete;

 private:
  const Handle* handle_;
};

// A reference held by another object.
template<class Handle> class Ref {
 public:
  Ref() = default;
  explicit Ref(Handle* handle) : handle_(handle) { retain(handle); }
  Ref(const Ref& other) : Ref(other.handle_) {}
  Ref(Ref&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  Ref& operator=(Ref other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Ref() { release(handle_); }
  [[nodiscard]] Handle* get() const { return handle_; }
  Handle* operator->() const { return handle_; }
  explicit operator bool() const { return handle_ != nullptr; }

 private:
  Handle* handle_ = nullptr;
};

// A progress callback of the C ABI as the core's.
[[nodiscard]] inline Progress::Callback progress_callback(bccsplat_progress_fn function, void* user) {
  if (!function) return {};
  return [function, user](double fraction) { return static_cast<int>(function(user, fraction)); };
}

} // namespace bccsplat::api

struct bccsplat_cancel_token : bccsplat::api::Object<bccsplat::api::Kind::cancel_token> {
  bccsplat::CancelToken state;
};

namespace bccsplat::api {

// The token of an options struct, which may be null.
using Token = Ref<bccsplat_cancel_token>;
[[nodiscard]] inline Token read_token(bccsplat_cancel_token* token) {
  if (token) require(token, "cancel_token");
  return Token(token);
}

// Makes the progress of a call hear of a token, which may be null and outlives the call.
inline void watch(Progress& progress, const Token& token) { progress.watch(token ? &token->state : nullptr); }

} // namespace bccsplat::api

struct bccsplat_device : bccsplat::api::Object<bccsplat::api::Kind::device> {
  explicit bccsplat_device(const bccsplat_device_options& options);
  void log(int32_t level, const std::string& message);
  // What a host may have meant otherwise: each is logged once.
  enum class Hint : uint32_t { fovy_in_radians = 1, surfaces_ignored = 2 };
  void hint(Hint which, const std::string& message);
  // Warns, once for each reason, that the CPU drew what the GPU should have; empty: it did not.
  void tell_gpu(const std::string& failed);
  // Whether pictures that do not say otherwise are a GPU's, where one draws them.
  [[nodiscard]] bool draws_by_gpu() const;
  [[nodiscard]] bccsplat::Context context(bccsplat::Progress& progress) { return {*tasks, memory, progress}; }

  std::unique_ptr<bccsplat::Tasks> tasks;
  bccsplat::MemoryBudget memory;
  uint64_t max_sites;
  std::shared_ptr<std::counting_semaphore<>> read_turns; // of volumes' bytes; null: no limit
  bccsplat::Backend backend;                             // of pictures that do not say otherwise
  std::shared_ptr<bccsplat::GpuDevice> gpu;              // null: the library was built without
  uint64_t gpu_memory;                                   // bytes; 0: what it has

 private:
  bccsplat_log_fn log_;
  void* log_user_;
  std::mutex log_mutex_;
  std::atomic<uint32_t> hinted_{0};
  std::string gpu_told_; // last
};

struct bccsplat_volume : bccsplat::api::Object<bccsplat::api::Kind::volume> {
  // What it was opened with, and may be opened with again.
  struct Opening {
    std::shared_ptr<const bccsplat::ByteSource> bytes;
    bccsplat::VolumeOptions options;
    bccsplat::api::Token token;
  };
  bccsplat_volume(bccsplat_device* owner, Opening how, std::unique_ptr<bccsplat::ByteSource> source)
      : device(owner), opening(std::move(how)), file(std::move(source), opening.options, owner->memory),
        token(opening.token) {}
  // Logs, once, that the cache is too small and how large it should be.
  void note_repeats(const bccsplat::Coefficients& coefficients) const {
    if (const auto note = file.note_repeats(coefficients)) device->log(BCCSPLAT_LOG_INFO, *note);
  }

  bccsplat::api::Ref<bccsplat_device> device;
  Opening opening;
  bccsplat::OpenVolume file;
  bccsplat::api::Token token;
};

struct bccsplat_slice : bccsplat::api::Object<bccsplat::api::Kind::slice> {
  bccsplat::api::Ref<bccsplat_volume> volume;
  bccsplat::api::Token token;
  bccsplat::OpenSlice open;
  bccsplat::SliceKeep kept;
};

struct bccsplat_frame : bccsplat::api::Object<bccsplat::api::Kind::frame> {
  bccsplat::api::Ref<bccsplat_device> device;
  bccsplat::Image image;
  std::vector<float> storage; // of the planes the frame owns
  // A host's texture that is drawn into, with the GPU of its context and what is kept there; null: in memory.
  std::shared_ptr<bccsplat::GpuDevice> gl;
  std::unique_ptr<bccsplat::Drawers> gl_drawers;
  bccsplat::GpuTarget target;
  bccsplat::Reservation memory;
  bccsplat::DeepImage deep; // of the last picture; `first` is empty before it
  std::vector<std::pair<std::string, std::string>> attributes; // of the last picture, for EXR
  std::optional<bccsplat::WorldCamera> camera;                 // of the last picture
};
