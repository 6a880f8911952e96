// SPDX-License-Identifier: Apache-2.0
#include "tool/serve/http_request.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <utility>

#include "readers/text.h"

namespace bcc4 {
namespace {

constexpr uint16_t usual_port = 80; // which browsers leave out

// The number that digits mean, or the largest; nothing of any other text.
std::optional<uint64_t> number(std::string_view digits) {
  uint64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (digits.empty() || end != digits.data() + digits.size()) return std::nullopt;
  return error == std::errc{} ? value : std::numeric_limits<uint64_t>::max();
}

} // namespace

std::optional<ByteInterval> parse_range(std::string_view range, uint64_t size) {
  constexpr std::string_view unit = "bytes=";
  if (lower(range.substr(0, unit.size())) != unit) return std::nullopt;
  const std::string_view text = range.substr(unit.size());
  const size_t dash = text.find('-');
  if (dash == std::string_view::npos) return std::nullopt;
  const std::string_view before = text.substr(0, dash), after = text.substr(dash + 1);
  const auto from = number(before), to = number(after);
  if ((!from && !before.empty()) || (!to && !after.empty()) || (!from && !to)) return std::nullopt;
  if (from && to && *to < *from) return std::nullopt;
  const uint64_t first = from ? *from : size - std::min(*to, size);
  if (first >= size) return ByteInterval{1, 0};
  return ByteInterval{first, from && to ? std::min(*to, size - 1) : size - 1};
}

bool names_this_server(std::string_view host, uint16_t port) {
  const std::string name = lower(host);
  for (const char* const own : {"127.0.0.1", "localhost"})
    if (name == concat(own, ":", port) || (port == usual_port && name == own)) return true;
  return false;
}

const char* media_type(std::string_view file) {
  constexpr std::array<std::pair<std::string_view, const char*>, 4> types{
      {{".html", "text/html; charset=utf-8"},
       {".css", "text/css; charset=utf-8"},
       {".mjs", "text/javascript; charset=utf-8"},
       {".wasm", "application/wasm"}}};
  for (const auto& [end, type] : types)
    if (file.ends_with(end)) return type;
  return "application/octet-stream";
}

} // namespace bcc4
