// SPDX-License-Identifier: Apache-2.0
// The objects of the C API as values that release themselves, and its statuses as errors.
#pragma once

#include "base/error.h"
#include "bccsplat.hpp"

namespace bccsplat::series {

using client::Device;
using client::sized;
using client::Slice;
using client::Volume;
using client::Writer;

// Throws an Error of the library's text, with `what` before it, unless status is OK.
void check(bccsplat_status status, const std::string& what);

[[nodiscard]] const char* lattice_name(int32_t lattice);

} // namespace bccsplat::series
