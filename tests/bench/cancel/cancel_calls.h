// SPDX-License-Identifier: Apache-2.0
// The long calls of the C API, each with a token, for the suite `cancel`.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/api_handles.h"

namespace bccsplat::bench {

// Returns the status of the call; the token ends it. What it needs is made before, by prepare().
struct LongCall {
  std::string name;
  std::function<void()> prepare; // may be null
  std::function<bccsplat_status(bccsplat_cancel_token*)> run;
};

// Files and objects that the calls share; they outlive the calls.
class LongCalls {
 public:
  LongCalls(uint32_t size, const std::string& folder, int threads);
  [[nodiscard]] const std::vector<LongCall>& calls() const { return calls_; }

 private:
  void add_readers();
  void add_pictures();
  void add_writers();
  [[nodiscard]] bccsplat_status write(const std::string& path, const bccsplat_writer_options& options,
                                      uint32_t first, uint32_t end) const;
  void write_parts();

  uint32_t size_;
  std::string folder_;
  host::Handle<bccsplat_device> device_;
  std::vector<std::vector<uint8_t>> frames_;
  host::Handle<bccsplat_volume> volume_;
  host::Handle<bccsplat_slice> slice_;
  std::vector<double> points_;
  std::vector<float> values_;
  std::vector<LongCall> calls_;
};

} // namespace bccsplat::bench
