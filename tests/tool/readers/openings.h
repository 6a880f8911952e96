// SPDX-License-Identifier: Apache-2.0
// Counts how often files are opened, as the system tells it, because a series is to be found once and its
// first header read once.
#pragma once

#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <map>
#include <string>

#include "scratch.h"

namespace bcc4::test {

// The openings of the files of a folder while the object lives; "" means the folder itself, opened to be
// listed.
class Openings {
 public:
  explicit Openings(const std::string& folder) : queue_(inotify_init1(IN_NONBLOCK)) {
    // Equal events in a row are told once, but reading and closing comes between two openings.
    watched_ =
        queue_ >= 0 && inotify_add_watch(queue_, folder.c_str(), IN_OPEN | IN_ACCESS | IN_CLOSE_NOWRITE) >= 0;
  }
  ~Openings() { close(queue_); }
  Openings(const Openings&) = delete;
  Openings& operator=(const Openings&) = delete;

  [[nodiscard]] bool watched() const { return watched_; }
  [[nodiscard]] int of(const std::string& name) {
    alignas(inotify_event) std::array<char, 1 << 14> events{};
    for (ssize_t got = 0; (got = ::read(queue_, events.data(), events.size())) > 0;)
      for (ssize_t at = 0; at < got;) {
        inotify_event e{};
        std::memcpy(&e, events.data() + at, sizeof e);
        if (e.mask & IN_OPEN) ++count_[e.len > 0 ? events.data() + at + sizeof e : ""];
        at += static_cast<ssize_t>(sizeof e + e.len);
      }
    return count_[name];
  }

 private:
  int queue_;
  bool watched_ = false;
  std::map<std::string, int> count_;
};

// Opens a series and reads all its frames: the files are looked for once, and the first one is opened at most
// `more` times more often than the second.
inline void expect_opened_once(const Scratch& s, const ReaderOptions& options, const std::string& first,
                               const std::string& second, int more) {
  Openings openings(s.path(""));
  if (!openings.watched()) GTEST_SKIP() << "this system does not tell what is opened";
  const auto reader = open_series(options);
  for (uint64_t f = 0; f < reader->description().dims[3]; ++f) (void)dense(*reader, f);
  EXPECT_EQ(openings.of(""), 1) << "times that the folder was listed";
  EXPECT_GT(openings.of(second), 0);
  EXPECT_LE(openings.of(first), openings.of(second) + more) << first;
}

} // namespace bcc4::test
