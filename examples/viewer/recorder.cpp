// SPDX-License-Identifier: Apache-2.0
#include "viewer/recorder.h"

#include <csignal>
#include <cstdlib>
#include <filesystem>

namespace viewer {
namespace {

constexpr int pictures_per_second = 25;

std::string find_ffmpeg() {
  const char* path = std::getenv("PATH");
  std::string folders = path ? path : "";
  for (size_t from = 0; from <= folders.size();) {
    const size_t to = std::min(folders.find(':', from), folders.size());
    const std::filesystem::path program = std::filesystem::path(folders.substr(from, to - from)) / "ffmpeg";
    std::error_code none;
    if (std::filesystem::exists(program, none)) return program.string();
    from = to + 1;
  }
  return "";
}

// One word for a shell.
std::string shell_word(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

} // namespace

Recorder::Recorder() : ffmpeg_(find_ffmpeg()) {
  // An ffmpeg that ended is told by what is written to it.
  (void)std::signal(SIGPIPE, SIG_IGN);
}

void Recorder::apply(bool wanted, const Picture* shown, bool fresh) {
  const bool any = shown && shown->error.empty();
  if (on_ && (!wanted || (any && (shown->width != width_ || shown->height != height_)))) stop();
  if (!wanted || !any) return;
  if (!on_) start(*shown), fresh = true;
  if (ffmpeg_.empty() && fresh) write_picture(*shown);
  if (pipe_) write_film(*shown);
}

void Recorder::start(const Picture& picture) {
  on_ = true, written_ = 0, begin_ = Clock::now();
  width_ = picture.width, height_ = picture.height;
  do name_ = "viewer-" + std::to_string(++number_); // nothing that is there is written over
  while (std::filesystem::exists(name_ + ".mp4") || std::filesystem::exists(name_ + ".0001.png"));
  if (ffmpeg_.empty()) return;
  const std::string size = std::to_string(width_) + "x" + std::to_string(height_);
  const std::string command =
      shell_word(ffmpeg_) + " -nostdin -loglevel error -f rawvideo -pix_fmt rgba -s " + size + " -r " +
      std::to_string(pictures_per_second) + " -i - -vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' -pix_fmt yuv420p " +
      shell_word(name_ + ".mp4");
  pipe_ = popen(command.c_str(), "w");
  told_ = pipe_ ? "recording " + name_ + ".mp4" : "ffmpeg does not start";
}

// The picture stands as long as it is seen.
void Recorder::write_film(const Picture& picture) {
  const double seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
  while (written_ <= static_cast<int>(seconds * pictures_per_second)) {
    if (std::fwrite(picture.pixels.data(), sizeof(uint32_t), picture.pixels.size(), pipe_) !=
        picture.pixels.size()) {
      (void)pclose(pipe_);
      pipe_ = nullptr;
      told_ = "ffmpeg ended: " + name_ + ".mp4 is not whole";
      return;
    }
    ++written_;
  }
}

void Recorder::write_picture(const Picture& picture) {
  char place[24];
  std::snprintf(place, sizeof place, ".%04d.png", ++written_);
  bccsplat_image_options options{};
  options.struct_size = sizeof options;
  options.use_background = 1;
  const std::string path = name_ + place;
  const bccsplat_status status = bccsplat_frame_save_png(picture.frame.get(), path.c_str(), &options);
  told_ = status == BCCSPLAT_OK ? path + " (a film needs ffmpeg)" : bccsplat_last_error();
}

void Recorder::stop() {
  on_ = false;
  if (!pipe_) return;
  told_ = pclose(pipe_) == 0 ? name_ + ".mp4, " + std::to_string(written_) + " pictures"
                             : "ffmpeg failed on " + name_ + ".mp4";
  pipe_ = nullptr;
}

} // namespace viewer
