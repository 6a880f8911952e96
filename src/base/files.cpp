// SPDX-License-Identifier: Apache-2.0
// Sources and sinks of bytes over files, memory and host streams. A file that is written lies beside its
// final name, locked against other writers, until commit() renames it.
#include "base/files.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "base/lru_cache.h"
#include "base/os/file.h"
#include "base/sizes.h"
#include "base/would_block.h"

namespace bccsplat {
namespace {

[[noreturn]] void fail_range(const std::string& name, uint64_t offset, uint64_t count, uint64_t size) {
  fail(Code::truncated, name, ": ", count, " bytes wanted at offset ", offset, ", the file ends at ", size);
}

class FileSource final : public ByteSource {
 public:
  explicit FileSource(const std::string& path) : name_(path), file_(OsFile::open_to_read(path)) {}
  // Returns the size of the moment: a file that is being written grows.
  uint64_t size() const override { return file_.size(); }
  const std::string& name() const override { return name_; }
  void read_at(uint64_t offset, std::span<std::byte> out) const override {
    if (offset > INT64_MAX || out.size() > INT64_MAX - offset || file_.read_at(offset, out) != out.size())
      fail_range(name_, offset, out.size(), size());
  }

 private:
  std::string name_;
  OsFile file_;
};

// One of many files: it is opened when it is read, and stays open until others were read more lately.
class FileOfMany final : public ByteSource {
 public:
  using OpenFiles = LruCache<std::string, OsFile>;
  FileOfMany(const std::string& path, std::shared_ptr<OpenFiles> open)
      : name_(path), open_(std::move(open)), size_(file()->size()) {}
  uint64_t size() const override { return size_; }
  const std::string& name() const override { return name_; }
  void read_at(uint64_t offset, std::span<std::byte> out) const override {
    if (offset > size_ || out.size() > size_ - offset || file()->read_at(offset, out) != out.size())
      fail_range(name_, offset, out.size(), size_);
  }

 private:
  // Whoever reads it keeps it open, too.
  std::shared_ptr<const OsFile> file() const {
    if (auto found = open_->find(name_)) return found;
    auto opened = std::make_shared<const OsFile>(OsFile::open_to_read(name_));
    open_->insert(name_, opened, 1, nullptr);
    return opened;
  }

  std::string name_;
  std::shared_ptr<OpenFiles> open_;
  uint64_t size_;
};

class MemorySource final : public ByteSource {
 public:
  explicit MemorySource(std::span<const std::byte> bytes) : bytes_(bytes) {}
  uint64_t size() const override { return bytes_.size(); }
  const std::string& name() const override { return name_; }
  void read_at(uint64_t offset, std::span<std::byte> out) const override {
    if (offset > bytes_.size() || out.size() > bytes_.size() - offset)
      fail_range(name_, offset, out.size(), bytes_.size());
    if (!out.empty()) std::memcpy(out.data(), bytes_.data() + offset, out.size());
  }

 private:
  std::span<const std::byte> bytes_;
  std::string name_ = "memory";
};

class StreamSource final : public ByteSource {
 public:
  StreamSource(uint64_t size, ReadAt read, uint64_t merge_gap, std::string name)
      : size_(size), merge_gap_(merge_gap), read_(std::move(read)), name_(std::move(name)) {}
  uint64_t size() const override { return size_; }
  uint64_t merge_gap() const override { return merge_gap_; }
  const std::string& name() const override { return name_; }
  void read_at(uint64_t offset, std::span<std::byte> out) const override {
    if (offset > size_ || out.size() > size_ - offset) fail_range(name_, offset, out.size(), size_);
    if (out.empty()) return;
    const int64_t n = read_(offset, out);
    if (n == read_would_block)
      throw WouldBlock(concat(name_, ": ", out.size(), " bytes at offset ", offset, " are not there yet"),
                       {{offset, out.size()}});
    if (n < 0 || static_cast<uint64_t>(n) > out.size())
      fail(Code::io_error, name_, ": the host could not read ", out.size(), " bytes at offset ", offset);
    if (static_cast<uint64_t>(n) != out.size()) fail_range(name_, offset, out.size(), offset + n);
  }

 private:
  uint64_t size_, merge_gap_;
  ReadAt read_;
  std::string name_;
};

class FileSink final : public ByteSink {
 public:
  FileSink(std::string path, bool overwrite, Partial mode)
      : path_(std::move(path)), partial_(path_ + ".partial"), overwrite_(overwrite), mode_(mode) {
    if (path_.empty()) fail(Code::invalid_argument, "the path of the file to write is empty");
    if (!overwrite && name_is_taken(path_))
      fail(Code::file_exists, path_, ": exists already; choose another name or allow overwriting");
    // A rename would take the name of a device or a pipe away, too.
    if (const PathKind kind = path_kind(path_); kind != PathKind::nothing && kind != PathKind::file)
      fail(Code::io_error, path_, kind == PathKind::folder ? ": is a folder" : ": is no regular file");
    for (int attempt = 0; !open_alone(); ++attempt)
      if (attempt == 100) fail(Code::io_error, partial_, ": is taken away again and again");
    if (mode_ != Partial::taken_over) file_.resize(0, "create");
  }
  ~FileSink() override {
    if (file_.is_open() && mode_ == Partial::removed) remove_file(partial_);
  }
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

  void write_at(uint64_t offset, std::span<const std::byte> bytes) override {
    file_.write_at(offset, bytes);
    end_ = std::max(end_, offset + bytes.size());
  }
  void flush() override { file_.make_durable(); }
  void commit() override {
    // An old file that was taken over may have been longer.
    if (mode_ == Partial::taken_over) file_.resize(end_, "write");
    flush();
    rename_file(partial_, path_, overwrite_ ? OldFile::replaced : OldFile::refused);
    file_.close();
  }

 private:
  // Opens and locks the unfinished file; returns false when another writer finished or removed the one that
  // was opened.
  bool open_alone() {
    file_ = OsFile::open_to_write(partial_, path_);
    const bool taken = !file_.lock();
    const bool same = file_.is_at(partial_);
    if (same && !taken) return true;
    file_.close();
    if (same) fail(Code::wrong_state, partial_, ": another writer is at work on it");
    return false;
  }

  std::string path_, partial_;
  bool overwrite_;
  Partial mode_;
  OsFile file_;
  uint64_t end_ = 0; // of what was written
};

class JournalSink final : public ByteSink {
 public:
  JournalSink(std::string path, uint64_t keep)
      : path_(std::move(path)), file_(OsFile::open_to_write(path_, path_)) {
    file_.resize(keep, "write");
  }
  void write_at(uint64_t offset, std::span<const std::byte> bytes) override { file_.write_at(offset, bytes); }
  void flush() override { file_.make_durable(); }
  void commit() override {
    file_.close(); // Windows keeps the name of what is open
    remove_file(path_);
  }

 private:
  std::string path_;
  OsFile file_;
};

class StreamSink final : public ByteSink {
 public:
  StreamSink(WriteAt write, Flush flush) : write_(std::move(write)), flush_(std::move(flush)) {}
  void write_at(uint64_t offset, std::span<const std::byte> bytes) override {
    if (bytes.empty()) return;
    unflushed_ = true;
    const int64_t n = write_(offset, bytes);
    if (n < 0 || static_cast<uint64_t>(n) != bytes.size())
      fail(Code::io_error, "stream: the host could not write ", bytes.size(), " bytes at offset ", offset);
  }
  void flush() override {
    if (!std::exchange(unflushed_, false) || !flush_) return;
    if (!flush_()) fail(Code::io_error, "stream: the host could not make what it has durable");
  }
  void commit() override { flush(); }

 private:
  WriteAt write_;
  Flush flush_;
  bool unflushed_ = false;
};

} // namespace

std::unique_ptr<ByteSource> open_file_source(const std::string& path) {
  return std::make_unique<FileSource>(path);
}

std::vector<std::unique_ptr<ByteSource>> open_file_sources(const std::vector<std::string>& paths,
                                                           size_t open_at_once) {
  const auto open = std::make_shared<FileOfMany::OpenFiles>(open_at_once);
  std::vector<std::unique_ptr<ByteSource>> sources;
  for (const std::string& path : paths) sources.push_back(std::make_unique<FileOfMany>(path, open));
  return sources;
}

std::unique_ptr<ByteSource> open_memory_source(std::span<const std::byte> bytes) {
  return std::make_unique<MemorySource>(bytes);
}

std::unique_ptr<ByteSource> open_stream_source(uint64_t size, ReadAt read, uint64_t merge_gap,
                                               std::string name) {
  return std::make_unique<StreamSource>(size, std::move(read), merge_gap, std::move(name));
}

std::unique_ptr<ByteSink> create_file_sink(const std::string& path, bool overwrite, Partial partial) {
  return std::make_unique<FileSink>(path, overwrite, partial);
}

std::unique_ptr<ByteSink> create_journal_sink(const std::string& path, uint64_t keep) {
  return std::make_unique<JournalSink>(path, keep);
}

bool file_exists(const std::string& path) { return name_is_taken(path); }

std::unique_ptr<ByteSink> create_stream_sink(WriteAt write, Flush flush) {
  return std::make_unique<StreamSink>(std::move(write), std::move(flush));
}

std::unique_ptr<ByteSink> create_memory_sink(std::vector<std::byte>& out) {
  return create_stream_sink([&out](uint64_t offset, std::span<const std::byte> bytes) {
    out.resize(std::max<uint64_t>(out.size(), checked_add(offset, bytes.size())));
    std::memcpy(out.data() + offset, bytes.data(), bytes.size());
    return static_cast<int64_t>(bytes.size());
  });
}

} // namespace bccsplat
