// SPDX-License-Identifier: Apache-2.0
// The objects of the C API as values that release themselves, and its status codes as exceptions.
#pragma once

#include "bccsplat.hpp"
#include "readers/error.h"

namespace bcc4 {

using bccsplat::client::Device;
using bccsplat::client::sized;
using bccsplat::client::Slice;
using bccsplat::client::Volume;
using bccsplat::client::Writer;

// A failed call of the library.
class StatusError : public Error {
 public:
  StatusError(bccsplat_status status, Exit exit, const std::string& text)
      : Error(exit, text), status_(status) {}
  [[nodiscard]] bccsplat_status status() const { return status_; }

 private:
  bccsplat_status status_;
};

[[nodiscard]] Exit exit_of(bccsplat_status status);
// Throws a StatusError of the library's text, with `what` before it, unless status is OK.
void check(bccsplat_status status, const std::string& what);

[[nodiscard]] const char* lattice_name(int32_t lattice);

} // namespace bcc4
