// SPDX-License-Identifier: Apache-2.0
// By libmicrohttpd, in one thread: a client that does not send, or does not take, costs a connection alone. A
// connection is for one request: a browser asks for few.
#include "tool/serve/http_server.h"

#include <fcntl.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <exception>
#include <initializer_list>
#include <map>
#include <memory>
#include <utility>

#include "readers/error.h"
#include "tool/serve/http_request.h"

namespace bcc4 {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int milliseconds_between_looks = 200;
// Each has a descriptor of its own and one of a file: together fewer than the 1024 that a process may have.
constexpr unsigned most_connections = 400;
// For the head of a request in all, and between two bytes of an answer that are taken.
constexpr unsigned patience_in_seconds = 5;

struct Server {
  const FindFile& find;
  uint16_t port;
  std::map<MHD_Connection*, Clock::time_point> unheard; // connections by when they began: no request so far
};

using Response = std::unique_ptr<MHD_Response, decltype(&MHD_destroy_response)>;
using Header = std::pair<const char*, std::string>;

MHD_Result send(MHD_Connection* to, unsigned status, const Response& response,
                std::initializer_list<Header> headers) {
  if (!response) return MHD_NO;
  for (const auto& [name, value] : headers)
    if (MHD_add_response_header(response.get(), name, value.c_str()) != MHD_YES) return MHD_NO;
  return MHD_queue_response(to, status, response.get());
}

MHD_Result refuse(MHD_Connection* to, unsigned status, std::string text, const Header& header) {
  text += '\n';
  const Response response(MHD_create_response_from_buffer(text.size(), text.data(), MHD_RESPMEM_MUST_COPY),
                          MHD_destroy_response);
  return send(to, status, response, {{MHD_HTTP_HEADER_CONTENT_TYPE, "text/plain"}, header});
}

MHD_Result refuse(MHD_Connection* to, unsigned status, std::string text) {
  return refuse(to, status, std::move(text), {MHD_HTTP_HEADER_CACHE_CONTROL, "no-cache"});
}

MHD_Result refuse_unknown(MHD_Connection* to) { return refuse(to, MHD_HTTP_NOT_FOUND, "No such file"); }

// Sends a file as long as it is now: one that is still written grows.
MHD_Result send_file(MHD_Connection* to, const std::string& path, const std::string& asked) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); // a pipe does not make it wait
  if (file < 0) return refuse_unknown(to);
  struct stat info {};
  const bool is_file = ::fstat(file, &info) == 0 && S_ISREG(info.st_mode);
  const auto size = static_cast<uint64_t>(is_file ? info.st_size : 0);
  const auto range = parse_range(asked, size);
  const bool is_there = is_file && !(range && range->last < range->first);
  const uint64_t first = range ? range->first : 0, count = range ? range->last - first + 1 : size;
  const Response response(is_there ? MHD_create_response_from_fd_at_offset64(count, file, first) : nullptr,
                          MHD_destroy_response);
  if (!response) ::close(file);
  if (!is_file) return refuse_unknown(to);
  if (!is_there)
    return refuse(to, MHD_HTTP_RANGE_NOT_SATISFIABLE, "The file has fewer bytes",
                  {MHD_HTTP_HEADER_CONTENT_RANGE, concat("bytes */", size)});
  const Header type{MHD_HTTP_HEADER_CONTENT_TYPE, media_type(path)};
  const Header ranges{MHD_HTTP_HEADER_ACCEPT_RANGES, "bytes"};
  const Header fresh{MHD_HTTP_HEADER_CACHE_CONTROL, "no-cache"};
  if (!range) return send(to, MHD_HTTP_OK, response, {type, ranges, fresh});
  const Header part{MHD_HTTP_HEADER_CONTENT_RANGE, concat("bytes ", first, "-", range->last, "/", size)};
  return send(to, MHD_HTTP_PARTIAL_CONTENT, response, {type, ranges, fresh, part});
}

MHD_Result answer(const Server& server, MHD_Connection* to, const char* path, const std::string& method) {
  const auto header = [to](const char* name) {
    const char* const value = MHD_lookup_connection_value(to, MHD_HEADER_KIND, name);
    return std::string(value ? value : "");
  };
  if (!names_this_server(header(MHD_HTTP_HEADER_HOST), server.port))
    return refuse(to, MHD_HTTP_FORBIDDEN,
                  concat("Only as http://127.0.0.1:", server.port, " or http://localhost:", server.port));
  if (method != MHD_HTTP_METHOD_GET && method != MHD_HTTP_METHOD_HEAD)
    return refuse(to, MHD_HTTP_METHOD_NOT_ALLOWED, "Only GET and HEAD", {MHD_HTTP_HEADER_ALLOW, "GET, HEAD"});
  const auto found = server.find(path);
  if (!found) return refuse_unknown(to);
  // A range is meant for GET alone, and under a condition for a version that is named; ours have no names.
  const bool in_parts = method == MHD_HTTP_METHOD_GET && header(MHD_HTTP_HEADER_IF_RANGE).empty();
  return send_file(to, *found, in_parts ? header(MHD_HTTP_HEADER_RANGE) : "");
}

// Called with the head of a request; what is answered here is the connection's last, and a body is not read.
MHD_Result on_request(void* data, MHD_Connection* to, const char* path, const char* method,
                      const char* /*version*/, const char* /*body*/, size_t* /*body_size*/,
                      void** /*request*/) {
  auto& server = *static_cast<Server*>(data);
  server.unheard.erase(to);
  try {
    return answer(server, to, path, method);
  } catch (const std::exception&) {
    return MHD_NO; // hangs up
  }
}

void on_connection(void* data, MHD_Connection* connection, void** /*socket*/,
                   MHD_ConnectionNotificationCode code) {
  auto& unheard = static_cast<Server*>(data)->unheard;
  if (code == MHD_CONNECTION_NOTIFY_STARTED)
    unheard.emplace(connection, Clock::now());
  else
    unheard.erase(connection);
}

// libmicrohttpd waits as long for each byte of a head.
void hang_up_on_the_slow(const Server& server) {
  const auto began = Clock::now() - std::chrono::seconds(patience_in_seconds);
  for (const auto& [connection, when] : server.unheard)
    if (when < began)
      ::shutdown(MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd,
                 SHUT_RDWR);
}

} // namespace

void serve_files(const Serving& serving) {
  std::signal(SIGPIPE, SIG_IGN); // a browser that has gone
  sockaddr_in address{};
  address.sin_family = AF_INET, address.sin_port = htons(serving.port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  Server server{serving.find, serving.port, {}};
  const std::unique_ptr<MHD_Daemon, decltype(&MHD_stop_daemon)> daemon(
      MHD_start_daemon(MHD_USE_EPOLL, serving.port, nullptr, nullptr, on_request, &server,
                       MHD_OPTION_SOCK_ADDR, &address, MHD_OPTION_NOTIFY_CONNECTION, on_connection, &server,
                       MHD_OPTION_CONNECTION_LIMIT, most_connections, MHD_OPTION_CONNECTION_TIMEOUT,
                       patience_in_seconds, MHD_OPTION_SIGPIPE_HANDLED_BY_APP, 1, MHD_OPTION_END),
      MHD_stop_daemon);
  if (!daemon)
    fail_input("port ", serving.port,
               " of 127.0.0.1 cannot be listened on; name another one by --port, or 0 for any");
  server.port = MHD_get_daemon_info(daemon.get(), MHD_DAEMON_INFO_BIND_PORT)->port;
  serving.listens(server.port);
  while (!serving.ends()) {
    if (MHD_run_wait(daemon.get(), milliseconds_between_looks) != MHD_YES)
      fail_resources("the server cannot go on waiting for browsers");
    hang_up_on_the_slow(server);
  }
}

} // namespace bcc4
