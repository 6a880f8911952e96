// SPDX-License-Identifier: Apache-2.0
// Sources and sinks of bytes over files, memory and host streams. A file that is written lies beside its
// final name, locked against other writers, until commit() renames it.
#include "base/files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "base/sizes.h"
#include "base/would_block.h"

namespace bccsplat {
namespace {

// What strerror_r gives: a text of its own, or as POSIX has it a status, the text in the buffer.
[[maybe_unused]] const char* error_text(const char* text, const char* /*buffer*/) { return text; }
[[maybe_unused]] const char* error_text(int /*status*/, const char* buffer) { return buffer; }

[[noreturn]] void fail_errno(const std::string& path, const char* doing, int error) {
  Code code = Code::io_error;
  const char* hint = "";
  switch (error) {
  case ENOENT:
    code = Code::file_not_found;
    break;
  case EACCES:
  case EPERM:
  case EROFS:
    code = Code::permission_denied;
    break;
  case EEXIST:
    code = Code::file_exists;
    break;
  case ENOSPC:
  case EDQUOT:
  case EFBIG:
    code = Code::no_space;
    hint = "; free some space or write elsewhere";
    break;
  case ENOMEM:
    code = Code::out_of_memory;
    break;
  default:
    break;
  }
  char buffer[256] = {};
  fail(code, path, ": cannot ", doing, ": ", error_text(strerror_r(error, buffer, sizeof buffer), buffer),
       hint);
}

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

[[noreturn]] void fail_range(const std::string& name, uint64_t offset, uint64_t count, uint64_t size) {
  fail(Code::truncated, name, ": ", count, " bytes wanted at offset ", offset, ", the file ends at ", size);
}

class FileSource final : public ByteSource {
 public:
  explicit FileSource(const std::string& path)
      : name_(path), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (file_.get() < 0) fail_errno(path, "open", errno);
    if (!S_ISREG(look().st_mode)) fail(Code::io_error, path, ": not a regular file");
  }
  // Returns the size of the moment: a file that is being written grows.
  uint64_t size() const override { return look().st_size; }
  const std::string& name() const override { return name_; }
  void read_at(uint64_t offset, std::span<std::byte> out) const override {
    if (offset > INT64_MAX || out.size() > INT64_MAX - offset) fail_range(name_, offset, out.size(), size());
    size_t done = 0;
    while (done < out.size()) {
      const auto n =
          ::pread(file_.get(), out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) fail_errno(name_, "read", errno);
      if (n == 0) fail_range(name_, offset, out.size(), size());
      done += n;
    }
  }

 private:
  [[nodiscard]] struct stat look() const {
    struct stat info {};
    if (::fstat(file_.get(), &info) != 0) fail_errno(name_, "read", errno);
    return info;
  }

  std::string name_;
  Descriptor file_;
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

// Writes all bytes at an offset, however many calls it takes. `path` is for error texts.
void write_all(int fd, const std::string& path, uint64_t offset, std::span<const std::byte> bytes) {
  size_t done = 0;
  while (done < bytes.size()) {
    const auto n = ::pwrite(fd, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail_errno(path, "write", errno);
    done += n;
  }
}

class FileSink final : public ByteSink {
 public:
  FileSink(std::string path, bool overwrite, Partial mode)
      : path_(std::move(path)), partial_(path_ + ".partial"), overwrite_(overwrite), mode_(mode) {
    if (path_.empty()) fail(Code::invalid_argument, "the path of the file to write is empty");
    struct stat info {};
    if (!overwrite && ::lstat(path_.c_str(), &info) == 0)
      fail(Code::file_exists, path_, ": exists already; choose another name or allow overwriting");
    // A rename would take the name of a device or a pipe away, too.
    if (::stat(path_.c_str(), &info) == 0 && !S_ISREG(info.st_mode))
      fail(Code::io_error, path_, S_ISDIR(info.st_mode) ? ": is a folder" : ": is no regular file");
    for (int attempt = 0; !open_alone(); ++attempt)
      if (attempt == 100) fail(Code::io_error, partial_, ": is taken away again and again");
    if (mode_ != Partial::taken_over && ::ftruncate(fd_, 0) != 0) {
      const int error = errno;
      ::close(std::exchange(fd_, -1));
      fail_errno(path_, "create", error);
    }
  }
  ~FileSink() override {
    if (fd_ < 0) return;
    if (mode_ == Partial::removed) ::unlink(partial_.c_str());
    ::close(fd_);
  }
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

  void write_at(uint64_t offset, std::span<const std::byte> bytes) override {
    write_all(fd_, path_, offset, bytes);
    end_ = std::max(end_, offset + bytes.size());
  }
  void flush() override {
    if (::fdatasync(fd_) != 0) fail_errno(path_, "write", errno);
  }
  void commit() override {
    // An old file that was taken over may have been longer.
    if (mode_ == Partial::taken_over && ::ftruncate(fd_, static_cast<off_t>(end_)) != 0)
      fail_errno(path_, "write", errno);
    flush();
    if (overwrite_) {
      if (::rename(partial_.c_str(), path_.c_str()) != 0) fail_errno(path_, "rename to", errno);
    } else {
      // link() refuses a name that appeared meanwhile; file systems without links fall back to rename.
      if (::link(partial_.c_str(), path_.c_str()) == 0)
        ::unlink(partial_.c_str());
      else if (errno == EEXIST || ::rename(partial_.c_str(), path_.c_str()) != 0)
        fail_errno(path_, "rename to", errno);
    }
    ::close(std::exchange(fd_, -1));
  }

 private:
  // Opens and locks the unfinished file; returns false when another writer finished or removed the one that
  // was opened.
  bool open_alone() {
    fd_ = ::open(partial_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (fd_ < 0) fail_errno(path_, "create", errno);
    const bool taken = ::flock(fd_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    struct stat opened {
    }, named{};
    const bool same = ::fstat(fd_, &opened) == 0 && ::stat(partial_.c_str(), &named) == 0 &&
                      opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
    if (same && !taken) return true;
    ::close(std::exchange(fd_, -1));
    if (same) fail(Code::wrong_state, partial_, ": another writer is at work on it");
    return false;
  }

  std::string path_, partial_;
  bool overwrite_;
  Partial mode_;
  int fd_ = -1;
  uint64_t end_ = 0; // of what was written
};

class JournalSink final : public ByteSink {
 public:
  JournalSink(std::string path, uint64_t keep)
      : path_(std::move(path)), file_(::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
    if (file_.get() < 0) fail_errno(path_, "create", errno);
    if (::ftruncate(file_.get(), static_cast<off_t>(keep)) != 0) fail_errno(path_, "write", errno);
  }
  void write_at(uint64_t offset, std::span<const std::byte> bytes) override {
    write_all(file_.get(), path_, offset, bytes);
  }
  void flush() override {
    if (::fdatasync(file_.get()) != 0) fail_errno(path_, "write", errno);
  }
  void commit() override { ::unlink(path_.c_str()); }

 private:
  std::string path_;
  Descriptor file_;
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

bool file_exists(const std::string& path) {
  struct stat info {};
  return ::lstat(path.c_str(), &info) == 0;
}

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
