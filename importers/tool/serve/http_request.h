// SPDX-License-Identifier: Apache-2.0
// What a browser asks for, as text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace bcc4 {

struct ByteInterval {
  uint64_t first = 0, last = 0; // both included
};

// Returns the bytes that a header Range means of a file of this size; nothing where it means all of it: of
// several ranges, of other units and of what is no range, too, as RFC 9110 lets a server do. An interval that
// ends before it begins cannot be given.
[[nodiscard]] std::optional<ByteInterval> parse_range(std::string_view range, uint64_t size);
// Returns whether a header Host names this port of 127.0.0.1 or localhost. Pages of other sites whose own
// name was led here (DNS rebinding) send that name.
[[nodiscard]] bool names_this_server(std::string_view host, uint16_t port);
// Returns the type that a browser is told of a file by its name.
[[nodiscard]] const char* media_type(std::string_view file);

} // namespace bcc4
