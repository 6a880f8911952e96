// SPDX-License-Identifier: Apache-2.0
// Whoever waits for a pass over frames, or for the choosing: is told how far it is, and may end it.
#pragma once

#include <cstdint>
#include <string>

#include "base/error.h"

struct bccsplat_cancel_token; // of the C ABI

namespace bccsplat::series {

// A part of the work: a pass over frames in bytes, or trials of codings.
struct WorkDone {
  const char* label = ""; // of the part: "scan", "trial"
  uint64_t done = 0;
  uint64_t total = 0; // bytes; 0: not known, `done` are counted
  std::string detail; // "frame 3/12"
};

class Watch {
 public:
  virtual ~Watch() = default;
  // Is the work to end? Asked often.
  [[nodiscard]] virtual bool ends() = 0;
  // Called as the work goes on.
  virtual void show(const WorkDone& /*work*/) {}
  // Returns the token for calls of the library that may take long; null: none.
  [[nodiscard]] virtual bccsplat_cancel_token* token() { return nullptr; }

  void go_on() {
    if (ends()) throw Error(Code::cancelled, "interrupted");
  }
};

} // namespace bccsplat::series
