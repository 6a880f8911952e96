// SPDX-License-Identifier: Apache-2.0
// What is known of a GPU, and what is asked of one.
#pragma once

#include <cstdint>
#include <string>

#include "base/error.h"

namespace bccsplat {

// The two ways into the shader: a compute shader with the sites in a buffer (GL 4.3), or a fragment shader
// with all data in textures (GL 3.3).
enum class GpuEntry : uint8_t { automatic, compute, fragment };

struct GpuInfo {
  std::string vendor, renderer, version;
  GpuEntry entry = GpuEntry::automatic;
  bool software = false; // a rasteriser on the CPU
  uint64_t memory = 0;   // bytes; 0: the driver does not tell
};

struct GpuWishes {
  bool host_context = false; // that of the calling thread, whatever it is
  GpuEntry entry = GpuEntry::automatic;
  bool as_card = false;      // what is found is taken unasked, whatever it is: for tests
  bool software_too = false; // false: a rasteriser on the CPU is none
  uint64_t memory_limit = 0; // bytes of data on the GPU at a time; 0: what it has
};

// A texture of the host's context that a picture goes into, row 0 at the bottom: over what it holds, before
// what its depths hide.
struct GpuTarget {
  uint32_t texture = 0, depth_texture = 0; // of two dimensions; 0: no depths
  bool replace = false;                    // what the texture holds
  // A texture's depth d is at the distance (d - constant) / factor, in perspective over which 1 is; where
  // reversed 0 is infinitely far, else 1.
  bool perspective = false, reversed = false;
  double constant = 0, factor = 1;
};

// Why a GPU does not draw what it covers: there is none, it lost its context, its memory is too small, its
// compiler refuses the shader. Another drawer can.
class GpuFailure : public Error {
 public:
  // for_good: no other picture will be drawn by it either.
  explicit GpuFailure(std::string why, bool for_good = true)
      : Error(Code::missing_feature, std::move(why)), for_good_(for_good) {}
  [[nodiscard]] bool for_good() const { return for_good_; }

 private:
  bool for_good_;
};

template<class... Parts> [[noreturn]] void fail_gpu(const Parts&... parts) {
  throw GpuFailure(concat("gpu: ", parts...));
}
// Smaller pictures, or those of other slices, may be drawn.
template<class... Parts> [[noreturn]] void fail_this_time(const Parts&... parts) {
  throw GpuFailure(concat("gpu: ", parts...), false);
}

} // namespace bccsplat
