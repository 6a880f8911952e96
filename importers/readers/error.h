// SPDX-License-Identifier: Apache-2.0
// The one exception of the readers and the tool: what failed, where, what to try, and the exit code it means.
#pragma once

#include <stdexcept>
#include <string>

#include "readers/text.h"

namespace bcc4 {

enum class Exit : int {
  ok = 0,
  check_failed = 1,
  usage = 2,
  bad_input = 3,
  no_resources = 4, // disk or memory
  interrupted = 130
};

class Error : public std::runtime_error {
 public:
  Error(Exit exit, const std::string& text) : std::runtime_error(text), exit_(exit) {}
  [[nodiscard]] Exit exit() const { return exit_; }

 private:
  Exit exit_;
};

template<class... Parts> [[noreturn]] void fail(Exit exit, const Parts&... parts) {
  throw Error(exit, concat(parts...));
}
// The file or its content is at fault.
template<class... Parts> [[noreturn]] void fail_input(const Parts&... parts) {
  fail(Exit::bad_input, parts...);
}
// The command line is at fault.
template<class... Parts> [[noreturn]] void fail_usage(const Parts&... parts) { fail(Exit::usage, parts...); }

} // namespace bcc4
