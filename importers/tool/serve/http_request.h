// SPDX-License-Identifier: Apache-2.0
// What a browser asks for, as text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace bcc4 {

struct ByteInterval {
  uint64_t first = 0, last = 0; // both included
};

struct HttpRequest {
  std::string method, path; // the path without its query, decoded
  std::string range;        // as its header has it; empty: none
};

// Returns nothing where the head is none of HTTP.
[[nodiscard]] std::optional<HttpRequest> parse_request(const std::string& head);
// Returns the bytes that "bytes=A-B" means of a file of this size; nothing where it means all of it. An
// interval that ends before it begins cannot be given.
[[nodiscard]] std::optional<ByteInterval> parse_range(const std::string& range, uint64_t size);
// Returns the type that a browser is told of a file by its name.
[[nodiscard]] const char* media_type(const std::string& file);

} // namespace bcc4
