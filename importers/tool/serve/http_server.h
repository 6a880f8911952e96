// SPDX-License-Identifier: Apache-2.0
// A server of files for the browser on this machine: GET and HEAD, with ranges.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace bcc4 {

// A file under an address, or none. The address is decoded and without its query; nothing else is sure of it.
using FindFile = std::function<std::optional<std::string>(const std::string& path)>;

struct Serving {
  uint16_t port = 0; // of 127.0.0.1; 0: any that is free
  FindFile find;
  std::function<void(uint16_t port)> listens; // called once, when browsers may come
  std::function<bool()> ends;                 // asked several times a second
};

// Answers until `ends` says so. Throws bad_input where the port is taken.
void serve_files(const Serving& serving);

} // namespace bcc4
