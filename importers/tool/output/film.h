// SPDX-License-Identifier: Apache-2.0
// A film that ffmpeg encodes from pictures piped to it. It takes its name only when it is whole.
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "readers/text.h"

namespace bcc4 {

// Returns whether a file of that name is a film: .mp4, .webm or .webp.
[[nodiscard]] inline bool is_film(const std::string& path) {
  const std::string name = lower(path);
  return name.ends_with(".mp4") || name.ends_with(".webm") || name.ends_with(".webp");
}

struct FilmFormat {
  uint32_t width = 0, height = 0;    // even
  std::array<int32_t, 2> fps{24, 1}; // numerator and denominator
  int threads = 0;                   // 0: ffmpeg's choice
  std::string comment;
  int shown = 1;       // times, one after the other: ffmpeg keeps the pictures in memory for that
  size_t pictures = 0; // that it gets
};

class Film {
 public:
  // ffmpeg runs from here on: that it is missing is told before any picture is drawn.
  Film(std::string path, const FilmFormat& format);
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;
  ~Film(); // ends ffmpeg and removes what it wrote unless finished

  // One picture: rows from the top of red, green and blue, a byte each.
  void add(std::span<const unsigned char> rgb);
  void finish();

 private:
  void start(const std::vector<std::string>& arguments);
  void close_pipe();
  [[nodiscard]] bool ends_well(); // once all was written
  [[nodiscard]] std::string its_words();
  [[noreturn]] void fail_with_its_words();

  std::string path_, partial_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> words_; // what ffmpeg says; unlinked
  pid_t process_ = -1;
  int pipe_ = -1;
  void (*former_sigpipe_)(int);
};

} // namespace bcc4
