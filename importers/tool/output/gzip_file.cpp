// SPDX-License-Identifier: Apache-2.0
#include "tool/output/gzip_file.h"

#include <zlib.h>

#include <algorithm>
#include <vector>

#include "readers/error.h"
#include "tool/output/output_file.h"

namespace bcc4 {
namespace {

class GzipFile : public ByteSink {
 public:
  GzipFile(const std::string& path, bool overwrite) : file_(path, overwrite), packed_(kPiece) {
    constexpr int gzip = 16, window = 15, memory = 8, level = 4; // level 4: a third of the time of zlib's own
    if (deflateInit2(&z_, level, Z_DEFLATED, window + gzip, memory, Z_DEFAULT_STRATEGY) != Z_OK)
      fail_resources(path, ": no memory to compress it");
  }
  GzipFile(const GzipFile&) = delete;
  GzipFile& operator=(const GzipFile&) = delete;
  ~GzipFile() override { deflateEnd(&z_); }

  void write(std::span<const std::byte> bytes) override {
    while (!bytes.empty()) {
      const auto piece = bytes.first(std::min(bytes.size(), kPiece));
      z_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(piece.data()));
      z_.avail_in = static_cast<uInt>(piece.size());
      while (z_.avail_in > 0) pack(Z_NO_FLUSH);
      bytes = bytes.subspan(piece.size());
    }
  }

  void finish() override {
    while (pack(Z_FINISH) != Z_STREAM_END) {
    }
    file_.finish();
  }

 private:
  static constexpr size_t kPiece = size_t{1} << 18;

  // Packs what there is room for and writes it.
  int pack(int flush) {
    z_.next_out = reinterpret_cast<Bytef*>(packed_.data());
    z_.avail_out = static_cast<uInt>(packed_.size());
    const int result = deflate(&z_, flush);
    file_.write(std::span(packed_).first(packed_.size() - z_.avail_out));
    return result;
  }

  OutputFile file_;
  std::vector<std::byte> packed_;
  z_stream z_{};
};

} // namespace

std::unique_ptr<ByteSink> create_gzip(const std::string& path, bool overwrite) {
  return std::make_unique<GzipFile>(path, overwrite);
}

} // namespace bcc4
