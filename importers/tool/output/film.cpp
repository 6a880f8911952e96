// SPDX-License-Identifier: Apache-2.0
// Runs ffmpeg without a shell, in a process group of its own: Ctrl-C on a terminal reaches the tool, which
// ends ffmpeg and takes the half of a film away. ffmpeg's words go to a file, since a pipe that nobody reads
// would stop it.
#include "tool/output/film.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <thread>

#include "readers/error.h"
#include "tool/interrupt.h"
#include "tool/output/output_file.h"

extern char** environ; // NOLINT(readability-redundant-declaration): not in every unistd.h

namespace bcc4 {
namespace fs = std::filesystem;
namespace {

constexpr int wake_up_ms = 100; // to look whether the run was interrupted
constexpr size_t most_words = 2000;

bool is_webm(const std::string& path) { return lower(path).ends_with(".webm"); }
bool is_webp(const std::string& path) { return lower(path).ends_with(".webp"); }

// The options of an encoder: near to what the eye tells from the pictures, in a file of moderate size. An
// animated picture is for web pages: smaller, and shown again without end.
std::vector<std::string> encoder(const std::string& path) {
  if (is_webp(path)) return {"-c:v", "libwebp_anim", "-quality", "75", "-loop", "0"};
  if (is_webm(path))
    return {"-c:v",    "libvpx-vp9", "-crf",      "24",   "-b:v",      "0",
            "-row-mt", "1",          "-deadline", "good", "-cpu-used", "2"};
  return {"-c:v", "libx264", "-preset", "medium", "-crf", "18", "-movflags", "+faststart"};
}

// What a film says of its colours. WebP has no place for that: they are BT.601, as all read them.
std::vector<std::string> color_options(const std::string& path) {
  if (is_webp(path)) return {"-pix_fmt", "yuv420p"};
  return {"-pix_fmt", "yuv420p",          "-color_range", "tv",         "-colorspace",
          "bt709",    "-color_primaries", "bt709",        "-color_trc", "bt709"};
}

const char* container(const std::string& path) {
  return is_webp(path) ? "webp" : is_webm(path) ? "webm" : "mp4";
}

// Paths are named with their protocol: otherwise a colon in one would be taken for another protocol's.
std::vector<std::string> ffmpeg_arguments(const std::string& path, const std::string& partial,
                                          const FilmFormat& f) {
  std::vector<std::string> a{"ffmpeg", "-hide_banner", "-loglevel", "error", "-nostdin", "-y"};
  const auto append = [&a](const std::vector<std::string>& more) {
    a.insert(a.end(), more.begin(), more.end());
  };
  append({"-f", "rawvideo", "-pixel_format", "rgb24", "-video_size", concat(f.width, "x", f.height)});
  append({"-framerate", concat(f.fps[0], "/", f.fps[1]), "-i", "pipe:0", "-an"});
  const std::string again =
      f.shown > 1 ? concat("loop=loop=", f.shown - 1, ":size=", f.pictures, ":start=0,") : "";
  append({"-vf", concat(again, "scale=out_color_matrix=", is_webp(path) ? "bt601" : "bt709",
                        ":out_range=tv:flags=bicubic+accurate_rnd+full_chroma_int")});
  append(encoder(path));
  append(color_options(path));
  if (f.threads > 0) append({"-threads", concat(f.threads)});
  if (!f.comment.empty()) append({"-metadata", "comment=" + f.comment});
  append({"-f", container(path), "file:" + partial});
  return a;
}

bool mentions(const std::string& text, const std::vector<std::string>& phrases) {
  return std::any_of(phrases.begin(), phrases.end(),
                     [&](const std::string& phrase) { return text.find(phrase) != std::string::npos; });
}

// Actions and attributes of a child, released with their scope.
struct SpawnSettings {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  SpawnSettings(int input, int words) {
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, input, 0);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, words, 2);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    posix_spawnattr_setpgroup(&attributes, 0);
    sigset_t usual;
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE);
    posix_spawnattr_setsigdefault(&attributes, &usual);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
  }
};

} // namespace

Film::Film(std::string path, const FilmFormat& format)
    : path_(std::move(path)), partial_(partial_path(path_)), words_(std::tmpfile(), std::fclose),
      former_sigpipe_(std::signal(SIGPIPE, SIG_IGN)) { // an encoder that dies is an error of a write
  try {
    require_writable_folder(path_);
    if (!words_) fail_resources(path_, ": no temporary file for ffmpeg's words (", std::strerror(errno), ")");
    start(ffmpeg_arguments(path_, partial_, format));
  } catch (...) {
    std::signal(SIGPIPE, former_sigpipe_);
    throw;
  }
}

void Film::start(const std::vector<std::string>& arguments) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) fail_resources(path_, ": no pipe (", std::strerror(errno), ")");
  std::vector<char*> words;
  for (const std::string& a : arguments) words.push_back(const_cast<char*>(a.c_str()));
  words.push_back(nullptr);
  const SpawnSettings settings(ends[0], ::fileno(words_.get()));
  const int error =
      ::posix_spawnp(&process_, words[0], &settings.actions, &settings.attributes, words.data(), environ);
  ::close(ends[0]);
  pipe_ = ends[1];
  if (error != 0) {
    process_ = -1;
    close_pipe();
    if (error == ENOENT)
      fail_input(path_, ": films are encoded by ffmpeg, which is not installed (no ffmpeg in PATH); -o ",
                 fs::path(path_).stem().string(), ".%04d.png writes the pictures");
    fail_input(path_, ": ffmpeg cannot be run (", std::strerror(error), ")");
  }
  ::fcntl(pipe_, F_SETFL, O_NONBLOCK); // so that an encoder that hangs can be interrupted
}

Film::~Film() {
  close_pipe();
  if (process_ > 0) {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  std::error_code ignored;
  if (!partial_.empty()) fs::remove(partial_, ignored);
  std::signal(SIGPIPE, former_sigpipe_);
}

void Film::close_pipe() {
  if (pipe_ >= 0) ::close(pipe_);
  pipe_ = -1;
}

std::string Film::its_words() {
  std::string text(most_words, '\0');
  std::rewind(words_.get());
  text.resize(std::fread(text.data(), 1, text.size(), words_.get()));
  return std::string(trim(text));
}

void Film::fail_with_its_words() {
  const std::string said = its_words();
  const bool full = mentions(said, {std::strerror(ENOSPC), std::strerror(EFBIG), std::strerror(EDQUOT)});
  throw Error(full ? Code::no_space : Code::io_error,
              concat(path_, ": ffmpeg failed", said.empty() ? std::string(" without a word") : ":\n" + said));
}

void Film::add(std::span<const unsigned char> rgb) {
  while (!rgb.empty()) {
    stop_if_interrupted();
    pollfd writable{pipe_, POLLOUT, 0};
    if (::poll(&writable, 1, wake_up_ms) <= 0) continue;
    const ssize_t count = ::write(pipe_, rgb.data(), rgb.size());
    if (count >= 0) {
      rgb = rgb.subspan(count);
    } else if (errno == EPIPE) {
      (void)ends_well(); // its words are whole when it is gone
      fail_with_its_words();
    } else if (errno != EAGAIN && errno != EINTR) {
      fail_resources(path_, ": ffmpeg cannot be written to (", std::strerror(errno), ")");
    }
  }
}

bool Film::ends_well() {
  close_pipe();
  int status = 0;
  while (::waitpid(process_, &status, WNOHANG) == 0) {
    stop_if_interrupted();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  process_ = -1;
  std::error_code error;
  // When the disk fills up while the end is written, ffmpeg 5.1 prints an error and still exits with 0.
  return WIFEXITED(status) && WEXITSTATUS(status) == 0 && fs::file_size(partial_, error) > 0 && !error &&
         !mentions(its_words(), {"Error writing trailer", "Error closing file"});
}

void Film::finish() {
  if (!ends_well()) fail_with_its_words();
  rename_finished(partial_, path_);
  partial_.clear();
}

} // namespace bcc4
