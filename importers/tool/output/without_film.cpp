// SPDX-License-Identifier: Apache-2.0
// Films where the tool starts no other program: on Windows. The pictures can be written, and ffmpeg makes a
// film of them.
#include <filesystem>

#include "readers/error.h"
#include "readers/system.h"
#include "tool/output/film.h"

namespace bcc4 {

Film::Film(std::string path, const FilmFormat& /*format*/)
    : path_(std::move(path)), words_(nullptr, std::fclose), former_sigpipe_(nullptr) {
  const std::string name = to_text(to_path(path_).stem());
  fail_input(path_, ": this bcc4 starts no ffmpeg; -o ", name,
             ".%04d.png writes the pictures, of which ffmpeg -i ", name, ".%04d.png makes a film");
}
Film::~Film() = default;
void Film::add(std::span<const unsigned char> /*rgb*/) {}
void Film::finish() {}

} // namespace bcc4
