// SPDX-License-Identifier: Apache-2.0
// JSON with keys in the order they are set. NaN and infinities become null.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdio>
#include <span>
#include <string>

#include "tool/json_fwd.h"

namespace bcc4 {

inline void print_json(const Json& json) {
  const std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace);
  std::printf("%s\n", text.c_str());
}

// 4x4 row-major as four rows.
[[nodiscard]] inline Json matrix_json(const double* m) {
  Json rows = Json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({m[4 * r], m[4 * r + 1], m[4 * r + 2], m[4 * r + 3]});
  return rows;
}

} // namespace bcc4
