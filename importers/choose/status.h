// SPDX-License-Identifier: Apache-2.0
// The objects of the C API as values that release themselves, and its statuses as errors.
#pragma once

#include "bccsplat.hpp"
#include "readers/error.h"

namespace bcc4 {

using bccsplat::client::Device;
using bccsplat::client::sized;
using bccsplat::client::Slice;
using bccsplat::client::Volume;
using bccsplat::client::Writer;

// Throws an Error of the library's text, with `what` before it, unless status is OK.
void check(bccsplat_status status, const std::string& what);

[[nodiscard]] const char* lattice_name(int32_t lattice);

} // namespace bcc4
