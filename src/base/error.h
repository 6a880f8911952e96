// SPDX-License-Identifier: Apache-2.0
// The one exception type of the core. Codes are the numbers of the C ABI (src/api checks that they agree).
#pragma once

#include <cstdint>
#include <exception>
#include <string>
#include <utility>

#include "base/text.h"

namespace bccsplat {

enum class Code : int32_t {
  ok = 0,
  // caller
  invalid_argument = 1,
  invalid_struct_size = 2,
  invalid_handle = 3,
  wrong_state = 4,
  out_of_domain = 5, // a time or point where the field is not defined
  unsupported = 6,
  not_found = 7, // an unknown kernel, channel, attribute or option name
  // data
  not_bcc4 = 16,
  unsupported_version = 17,
  corrupt = 18,
  truncated = 19,
  checksum_mismatch = 20,
  limit_exceeded = 21,
  nonfinite_value = 22,
  bound_not_met = 23,
  hole = 24, // missing data where a value was asked for
  // environment
  out_of_memory = 32,
  io_error = 33,
  file_not_found = 34,
  no_space = 35,
  permission_denied = 36,
  file_exists = 37,
  memory_budget = 38,
  missing_feature = 39,
  would_block = 40, // bytes that are not there yet: would_block.h
  cancelled = 48,
  internal = 64,
};

class Error : public std::exception {
 public:
  Error(Code code, std::string message) : code_(code), message_(std::move(message)) {}
  [[nodiscard]] Code code() const noexcept { return code_; }
  [[nodiscard]] const char* what() const noexcept override { return message_.c_str(); }
  [[nodiscard]] const std::string& message() const noexcept { return message_; }

 private:
  Code code_;
  std::string message_;
};

// Throws an Error whose text is the parts joined: what failed, where, what to try.
template<class... Parts> [[noreturn]] void fail(Code code, const Parts&... parts) {
  throw Error(code, concat(parts...));
}

} // namespace bccsplat
