// SPDX-License-Identifier: Apache-2.0
#include "tool/output/flat_file.h"

#include <bit>

namespace bcc4 {
namespace {

class FlatFile : public VolumeFile {
 public:
  FlatFile(std::unique_ptr<ByteSink> file, Type type, const std::string& head, std::string tail)
      : file_(std::move(file)), type_(type), tail_(std::move(tail)) {
    file_->write(std::as_bytes(std::span(head)));
  }

  void write(std::span<const std::byte> planes) override {
    if constexpr (std::endian::native == std::endian::little) {
      file_->write(planes);
    } else {
      swapped_.assign(planes.begin(), planes.end());
      swap_bytes(swapped_, type_size(type_));
      file_->write(swapped_);
    }
  }

  void finish() override {
    file_->write(std::as_bytes(std::span(tail_)));
    file_->finish();
  }

 private:
  std::unique_ptr<ByteSink> file_;
  Type type_;
  std::string tail_;
  std::vector<std::byte> swapped_;
};

} // namespace

std::unique_ptr<VolumeFile> create_flat(std::unique_ptr<ByteSink> file, Type type, const std::string& head,
                                        std::string tail) {
  return std::make_unique<FlatFile>(std::move(file), type, head, std::move(tail));
}

} // namespace bcc4
