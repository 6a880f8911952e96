// SPDX-License-Identifier: Apache-2.0
// A server of files for the browser on this machine: GET and HEAD, with ranges.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace bcc4 {

// A file under an address, or none.
using FindFile = std::function<std::optional<std::string>(const std::string& path)>;

// Listens on 127.0.0.1.
class HttpServer {
 public:
  // port 0: any that is free. Throws bad_input where it is taken.
  HttpServer(uint16_t port, FindFile find);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  [[nodiscard]] uint16_t port() const { return port_; }
  // Answers until `ends` says so, which it asks several times a second.
  void serve(const std::function<bool()>& ends);

 private:
  int socket_ = -1;
  uint16_t port_ = 0;
  FindFile find_;
};

} // namespace bcc4
