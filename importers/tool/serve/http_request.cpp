// SPDX-License-Identifier: Apache-2.0
#include "tool/serve/http_request.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <utility>

namespace bcc4 {
namespace {

std::optional<uint64_t> number(std::string_view text, int base = 10) {
  uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Turns %20 and the like into bytes.
std::string decoded(std::string_view text) {
  constexpr size_t digits = 2;
  constexpr int hexadecimal = 16;
  std::string out;
  for (size_t n = 0; n < text.size(); ++n) {
    const auto code = text[n] == '%' && n + digits < text.size()
                          ? number(text.substr(n + 1, digits), hexadecimal)
                          : std::nullopt;
    out += code ? static_cast<char>(*code) : text[n];
    if (code) n += digits;
  }
  return out;
}

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return out;
}

// Returns the value of a header; its name in small letters.
std::string header(std::string_view head, std::string_view name) {
  for (size_t at = head.find("\r\n"); at != std::string_view::npos; at = head.find("\r\n", at + 2)) {
    const std::string_view line = head.substr(at + 2, head.find("\r\n", at + 2) - at - 2);
    const size_t colon = line.find(':');
    if (colon == std::string_view::npos || lower(line.substr(0, colon)) != name) continue;
    const size_t begin = line.find_first_not_of(' ', colon + 1);
    return begin == std::string_view::npos ? "" : std::string(line.substr(begin));
  }
  return "";
}

} // namespace

std::optional<HttpRequest> parse_request(const std::string& head) {
  const size_t first = head.find(' ');
  const size_t second = first == std::string::npos ? first : head.find(' ', first + 1);
  if (second == std::string::npos || head.compare(second + 1, 5, "HTTP/") != 0) return std::nullopt;
  const std::string target = head.substr(first + 1, second - first - 1);
  return HttpRequest{head.substr(0, first), decoded(target.substr(0, target.find('?'))),
                     header(head, "range")};
}

std::optional<ByteInterval> parse_range(const std::string& range, uint64_t size) {
  constexpr std::string_view unit = "bytes=";
  const size_t dash = range.find('-');
  if (!range.starts_with(unit) || dash == std::string::npos || size == 0) return std::nullopt;
  const std::string_view text = range;
  const auto from = number(text.substr(unit.size(), dash - unit.size())), to = number(text.substr(dash + 1));
  if (!from && !to) return std::nullopt;
  if (!from) return ByteInterval{size - std::min(*to, size), size - 1};
  return ByteInterval{*from, to ? std::min(*to, size - 1) : size - 1};
}

const char* media_type(const std::string& file) {
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
