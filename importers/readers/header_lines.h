// SPDX-License-Identifier: Apache-2.0
// A text header at the start of a file, line by line, with the place for error texts.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "readers/byte_stream.h"
#include "readers/error.h"

namespace bcc4 {

class HeaderLines {
 public:
  // `format` is the format's name, for error texts.
  HeaderLines(const std::string& path, const char* format) : file_(path), format_(format) {}
  // Reads the next line without its end (LF or CR LF); returns false at the end of the file.
  bool next(std::string& line) {
    line.clear();
    for (;;) {
      if (at_ == chunk_.size()) {
        chunk_.resize(4096);
        chunk_.resize(file_.read_some(fetched_, std::as_writable_bytes(std::span(chunk_))));
        fetched_ += chunk_.size();
        at_ = 0;
        if (chunk_.empty()) return !line.empty();
      }
      const char c = chunk_[at_++];
      if (++read_ > limit_) fail_input(file_.path(), ": the header does not end within ", limit_, " bytes");
      if (c == '\n') break;
      line += c;
    }
    ++line_;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return true;
  }
  [[nodiscard]] uint64_t offset() const { return read_; }
  // Returns how the text of an error in the line read last begins.
  [[nodiscard]] std::string where() const {
    return concat(file_.path(), ": line ", line_, " of the ", format_, " header: ");
  }
  template<class... Parts> [[noreturn]] void refuse(const Parts&... parts) const {
    fail_input(where(), parts...);
  }

 private:
  static constexpr uint64_t limit_ = 16 << 20; // bytes; a real header has a few hundred

  InputFile file_;
  const char* format_;
  std::string chunk_;
  size_t at_ = 0;
  uint64_t fetched_ = 0, read_ = 0, line_ = 0;
};

} // namespace bcc4
