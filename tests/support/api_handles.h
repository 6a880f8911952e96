// SPDX-License-Identifier: Apache-2.0
// What hosts in C++ use, by the name that tests have for it.
#pragma once

#include <bccsplat.hpp>

namespace host {

using bccsplat::client::Handle;
using bccsplat::client::sized;

} // namespace host
