// SPDX-License-Identifier: Apache-2.0
// A thread for each connection, which answers one request: a browser asks for few at a time.
#include "tool/serve/http_server.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <thread>
#include <utility>

#include "readers/error.h"
#include "tool/serve/http_request.h"

namespace bcc4 {
namespace {

constexpr int backlog = 32, milliseconds_between_looks = 200;
constexpr size_t longest_head = 16 << 10, piece = 64 << 10;

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

// False where the browser has gone.
bool send_all(int to, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(to, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<size_t>(sent));
  }
  return true;
}

std::string read_head(int from) {
  std::string head;
  std::array<char, 4096> buffer{};
  while (head.size() < longest_head && head.find("\r\n\r\n") == std::string::npos) {
    const ssize_t got = ::recv(from, buffer.data(), buffer.size(), 0);
    if (got <= 0) return {};
    head.append(buffer.data(), static_cast<size_t>(got));
  }
  return head;
}

void send_file(int to, int file, ByteInterval bytes) {
  std::array<char, piece> buffer{};
  while (bytes.first <= bytes.last) {
    const auto count = static_cast<size_t>(std::min<uint64_t>(piece, bytes.last - bytes.first + 1));
    const ssize_t got = ::pread(file, buffer.data(), count, static_cast<off_t>(bytes.first));
    if (got <= 0 || !send_all(to, {buffer.data(), static_cast<size_t>(got)})) return;
    bytes.first += static_cast<uint64_t>(got);
  }
}

std::string head_of(const char* status, const char* type, uint64_t size, const std::string& more = "") {
  return concat("HTTP/1.1 ", status, "\r\nContent-Type: ", type, "\r\nContent-Length: ", size,
                "\r\nAccept-Ranges: bytes\r\nCache-Control: no-cache\r\nConnection: close\r\n", more, "\r\n");
}

void refuse(int to, const char* status) {
  const std::string text = concat(status, "\n");
  send_all(to, head_of(status, "text/plain", text.size()) + text);
}

void give(int to, const HttpRequest& request, const std::string& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat info {};
  if (file.get() < 0 || ::fstat(file.get(), &info) != 0 || !S_ISREG(info.st_mode))
    return refuse(to, "404 Not Found");
  const auto size = static_cast<uint64_t>(info.st_size);
  const auto range = parse_range(request.range, size);
  if (range && range->first > range->last)
    return void(send_all(to, head_of("416 Range Not Satisfiable", "text/plain", 0,
                                     concat("Content-Range: bytes */", size, "\r\n"))));
  const ByteInterval bytes = range.value_or(ByteInterval{0, size - 1});
  const uint64_t count = size > 0 ? bytes.last - bytes.first + 1 : 0;
  const std::string more =
      range ? concat("Content-Range: bytes ", bytes.first, "-", bytes.last, "/", size, "\r\n") : "";
  const bool sent =
      send_all(to, head_of(range ? "206 Partial Content" : "200 OK", media_type(path), count, more));
  if (sent && count > 0 && request.method == "GET") send_file(to, file.get(), bytes);
}

void answer(int to, const FindFile& find) {
  const auto request = parse_request(read_head(to));
  if (!request) return refuse(to, "400 Bad Request");
  if (request->method != "GET" && request->method != "HEAD") return refuse(to, "405 Method Not Allowed");
  const auto path = find(request->path);
  if (!path) return refuse(to, "404 Not Found");
  give(to, *request, *path);
}

} // namespace

HttpServer::HttpServer(uint16_t port, FindFile find)
    : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)), find_(std::move(find)) {
  sockaddr_in address{};
  address.sin_family = AF_INET, address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int on = 1;
  ::setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  socklen_t size = sizeof address;
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  if (socket_ < 0 || ::bind(socket_, generic, size) != 0 || ::listen(socket_, backlog) != 0) {
    if (socket_ >= 0) ::close(socket_);
    fail_input("port ", port,
               " of 127.0.0.1 cannot be listened on; name another one by --port, or 0 for any");
  }
  ::getsockname(socket_, generic, &size);
  port_ = ntohs(address.sin_port);
}

HttpServer::~HttpServer() { ::close(socket_); }

void HttpServer::serve(const std::function<bool()>& ends) {
  while (!ends()) {
    pollfd look{socket_, POLLIN, 0};
    if (::poll(&look, 1, milliseconds_between_looks) <= 0) continue;
    const int to = ::accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC);
    if (to < 0) continue;
    std::thread([to, find = find_] {
      const Descriptor connection(to);
      answer(connection.get(), find);
    }).detach();
  }
}

} // namespace bcc4
