// SPDX-License-Identifier: Apache-2.0
// What is seen, as a film: viewer-1.mp4, viewer-2.mp4 ..., through ffmpeg; where that is not installed each
// picture once, viewer-1.0001.png and so on.
#pragma once

#include "viewer/worker.h"

#include <chrono>
#include <cstdio>

namespace viewer {

class Recorder {
 public:
  Recorder();
  ~Recorder() { stop(); }
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Called with every round of the window: `shown` is on screen (or null), `fresh` if it was not before. A
  // film ends when it is no longer wanted or the window has another size.
  void apply(bool wanted, const Picture* shown, bool fresh);
  [[nodiscard]] const std::string& told() const { return told_; } // what was written last, or what went wrong

 private:
  using Clock = std::chrono::steady_clock;

  void start(const Picture& picture);
  void stop();
  void write_film(const Picture& picture);
  void write_picture(const Picture& picture);

  std::string ffmpeg_; // empty: it is not installed
  std::FILE* pipe_ = nullptr;
  std::string name_, told_;
  Clock::time_point begin_;
  int number_ = 0, written_ = 0; // of films, and of pictures of the one under way
  int width_ = 0, height_ = 0;
  bool on_ = false;
};

} // namespace viewer
