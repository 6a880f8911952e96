// SPDX-License-Identifier: Apache-2.0
#include "tool/output/named_file.h"
#include "readers/system.h"

#include <filesystem>

#include "tool/output/output_file.h"

namespace bcc4 {
namespace {

class NamedFile : public VolumeFile {
 public:
  NamedFile(const std::string& path, const CreateFile& create) : path_(path), partial_(partial_path(path)) {
    try {
      file_ = create(partial_);
    } catch (...) {
      remove_partial();
      throw;
    }
  }
  NamedFile(const NamedFile&) = delete;
  NamedFile& operator=(const NamedFile&) = delete;
  ~NamedFile() override {
    file_.reset();
    if (!finished_) remove_partial();
  }

  void write(std::span<const std::byte> planes) override { file_->write(planes); }
  void finish() override {
    file_->finish();
    rename_finished(partial_, path_);
    finished_ = true;
  }

 private:
  void remove_partial() const {
    std::error_code ignored;
    std::filesystem::remove(to_path(partial_), ignored);
  }

  std::string path_, partial_;
  std::unique_ptr<VolumeFile> file_;
  bool finished_ = false;
};

} // namespace

std::unique_ptr<VolumeFile> create_named(const std::string& path, bool overwrite, const CreateFile& create) {
  refuse_existing(path, overwrite);
  require_writable_folder(path);
  return std::make_unique<NamedFile>(path, create);
}

} // namespace bcc4
