// SPDX-License-Identifier: Apache-2.0
// Unpacks the files of a sequence into a folder of its own, and puts the names of the packed files back into
// all that is told of them.
#include "readers/unpacked.h"

#include <filesystem>
#include <fstream>

#include "readers/decoders.h"
#include "readers/error.h"
#include "readers/system.h"

namespace bcc4 {
namespace fs = std::filesystem;
namespace {

// A folder of its own that goes with it.
class TemporaryFolder {
 public:
  TemporaryFolder() : path_(make_temporary_folder()) {
    if (path_.empty()) fail_resources("no folder for temporary files: set TMPDIR to one that can be written");
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(to_path(path_), ignored);
  }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::string name_unpacked(const std::string& path) {
  const std::string name = to_text(to_path(path).filename());
  return lower(name).ends_with(".gz") ? name.substr(0, name.size() - std::string_view(".gz").size()) : name;
}

// What names other files would look for them in the wrong folder.
void refuse_header(const std::string& path) {
  const std::string name = lower(name_unpacked(path));
  for (const char* const suffix : {".nhdr", ".mhd", ".pvd"})
    if (name.ends_with(suffix))
      fail_input(path, ": names other files and is packed with gzip: unpack it first (gunzip --keep)");
}

void unpack(const std::string& from, const std::string& to) {
  constexpr size_t piece = size_t{1} << 20;
  const auto stream = open_gzip(std::make_unique<InputFile>(from), 0);
  std::ofstream out(to_path(to), std::ios::binary);
  Bytes bytes(piece);
  for (size_t got = piece; got == piece && out;) {
    got = stream->read(bytes);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(got));
  }
  out.close();
  if (!out)
    fail_resources(from, ": cannot be unpacked to ", to,
                   " (is the disk full?): set TMPDIR to a folder with more room, or unpack it yourself");
}

class UnpackedReader : public FrameReader {
  // Returns the text with the names of the packed files.
  [[nodiscard]] std::string packed_name(std::string text) const {
    for (const auto& [unpacked, packed] : names_)
      for (size_t at = text.find(unpacked); at != std::string::npos;
           at = text.find(unpacked, at + packed.size()))
        text.replace(at, unpacked.size(), packed);
    return text;
  }
  template<class Work> auto named(const Work& work) const {
    try {
      return work();
    } catch (const Error& e) {
      throw Error(e.code(), packed_name(e.what()));
    }
  }

 public:
  UnpackedReader(const Sequence& sequence,
                 const std::function<std::unique_ptr<FrameReader>(const Sequence&)>& open) {
    Sequence unpacked = sequence;
    for (size_t i = 0; i < sequence.files.size(); ++i) {
      const std::string& packed = sequence.files[i].path;
      refuse_header(packed);
      if (!read_start(packed, 2).gzip) continue;
      const fs::path folder = to_path(folder_.path()) / concat(i); // names may be those of several folders
      fs::create_directory(folder);
      unpacked.files[i].path = to_text(folder / to_path(name_unpacked(packed)));
      names_.emplace_back(unpacked.files[i].path, packed);
      unpack(packed, unpacked.files[i].path);
    }
    reader_ = named([&] { return open(unpacked); });
    description_ = reader_->description();
    for (SourceFile& file : description_.files)
      file = {packed_name(file.path), file_size(packed_name(file.path))};
    for (auto* const texts : {&description_.notes, &description_.warnings, &description_.gaps})
      for (std::string& text : *texts) text = packed_name(text);
  }
  const SeriesDescription& description() const override { return description_; }
  Frame read(uint64_t frame, size_t channel) override {
    return named([&] { return reader_->read(frame, channel); });
  }
  std::string frame_name(uint64_t frame) const override { return packed_name(reader_->frame_name(frame)); }

 private:
  TemporaryFolder folder_;
  std::vector<std::pair<std::string, std::string>> names_; // of a file unpacked and packed
  std::unique_ptr<FrameReader> reader_;
  SeriesDescription description_;
};

} // namespace

std::unique_ptr<FrameReader>
open_unpacked(const Sequence& sequence,
              const std::function<std::unique_ptr<FrameReader>(const Sequence& sequence)>& open) {
  return std::make_unique<UnpackedReader>(sequence, open);
}

} // namespace bcc4
