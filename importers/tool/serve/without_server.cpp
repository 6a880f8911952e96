// SPDX-License-Identifier: Apache-2.0
// The server where the tool has none: on Windows. Any other one of files, with ranges, does as well.
#include "readers/error.h"
#include "tool/serve/http_server.h"

namespace bcc4 {

HttpServer::HttpServer(uint16_t port, FindFile /*find*/) : port_(port) {
  fail_input("view: this bcc4 has no server; let another one (with ranges) serve examples/web and the file, "
             "and open "
             "index.html?url=FILE there");
}
HttpServer::~HttpServer() = default;
void HttpServer::serve(const std::function<bool()>& /*ends*/) {}

} // namespace bcc4
