// SPDX-License-Identifier: Apache-2.0
// JSON's name, for headers that declare who makes it.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace bcc4 {

using Json = nlohmann::ordered_json;

} // namespace bcc4
