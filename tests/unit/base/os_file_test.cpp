// SPDX-License-Identifier: Apache-2.0
// Files of the system by whichever calls it has: offsets beyond 32 bits, names in UTF-8, locks, names that
// change.
#include "base/os/file.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <vector>

#include "base/error.h"
#include "base/machine.h"
#include "base/text.h"

namespace bccsplat {
namespace {

namespace fs = std::filesystem;

// Paths are made of UTF-8, whatever the system makes of texts without a type.
fs::path named(const std::string& text) { return {std::u8string(text.begin(), text.end())}; }

// A folder of its own that goes with it, with a space and an umlaut in its name.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / named(concat("bccsplat \xc3\xb6s ", machine_process()))) {
    fs::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  // Returns the path of a file in it, in UTF-8.
  [[nodiscard]] std::string file(const char* name) const {
    const std::u8string text = (path_ / named(name)).u8string();
    return {text.begin(), text.end()};
  }

 private:
  fs::path path_;
};

constexpr std::array<std::byte, 4> word{std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}};

void make_file(const std::string& path, size_t bytes = word.size()) {
  OsFile::open_to_write(path, path).write_at(0, std::span(word).first(bytes));
}

template<class Work> Code code_of(const Work& work) {
  try {
    work();
  } catch (const Error& e) {
    return e.code();
  }
  return Code::ok;
}

TEST(OsFiles, ReadWhatWasWrittenAndNoMore) {
  const Folder folder;
  const std::string path = folder.file("gr\xc3\xbc\xc3\x9f"
                                       "e \xe2\x82\xac.bin");
  make_file(path);
  const OsFile file = OsFile::open_to_read(path);
  EXPECT_EQ(file.size(), word.size());
  std::array<std::byte, 8> got{};
  EXPECT_EQ(file.read_at(1, got), 3u);
  EXPECT_EQ(got[0], std::byte{2});
  EXPECT_EQ(got[2], std::byte{4});
  EXPECT_EQ(file.read_at(4, got), 0u);
  EXPECT_EQ(file.read_at(uint64_t{1} << 40, got), 0u);
}

TEST(OsFiles, OffsetsBeyond32Bits) {
  const Folder folder;
  const std::string path = folder.file("large.bin");
  constexpr uint64_t far = (uint64_t{5} << 30) + 3;
  OsFile file = OsFile::open_to_write(path, path);
  file.resize(far, "write"); // which leaves a hole, so that it takes no room
  file.write_at(far, word);
  EXPECT_EQ(file.size(), far + word.size());
  std::array<std::byte, 6> got{};
  EXPECT_EQ(file.read_at(far - 1, got), 5u);
  EXPECT_EQ(got[0], std::byte{0});
  EXPECT_EQ(got[4], std::byte{4});
  file.resize(2, "write");
  EXPECT_EQ(file.size(), 2u);
}

TEST(OsFiles, OneWriterLocksAndReadersRead) {
  const Folder folder;
  const std::string path = folder.file("locked.bin");
  make_file(path);
  OsFile first = OsFile::open_to_write(path, path);
  OsFile second = OsFile::open_to_write(path, path);
  EXPECT_TRUE(first.lock());
  EXPECT_FALSE(second.lock());
  std::array<std::byte, 4> got{};
  EXPECT_EQ(OsFile::open_to_read(path).read_at(0, got), 4u);
  EXPECT_EQ(got, word);
  first.close();
  EXPECT_TRUE(second.lock());
}

TEST(OsFiles, AFileIsAtItsNameUntilThatIsAnothers) {
  const Folder folder;
  const std::string path = folder.file("a.bin"), other = folder.file("b.bin");
  make_file(path);
  make_file(other);
  const OsFile file = OsFile::open_to_write(path, path);
  EXPECT_TRUE(file.is_at(path));
  EXPECT_FALSE(file.is_at(other));
  rename_file(path, folder.file("c.bin"), OldFile::refused); // while it is open
  EXPECT_FALSE(file.is_at(path));
  EXPECT_TRUE(file.is_at(folder.file("c.bin")));
}

TEST(OsFiles, ARenameReplacesOrRefuses) {
  const Folder folder;
  const std::string from = folder.file("from.bin"), to = folder.file("to.bin");
  make_file(from, 3);
  make_file(to, 1);
  EXPECT_EQ(code_of([&] { rename_file(from, to, OldFile::refused); }), Code::file_exists);
  EXPECT_EQ(OsFile::open_to_read(to).size(), 1u);
  EXPECT_TRUE(name_is_taken(from));
  rename_file(from, to, OldFile::replaced);
  EXPECT_EQ(OsFile::open_to_read(to).size(), 3u);
  EXPECT_FALSE(name_is_taken(from));
}

TEST(OsFiles, AReaderKeepsTheFileThatIsReplacedOrRemoved) {
  const Folder folder;
  const std::string from = folder.file("from.bin"), to = folder.file("to.bin");
  make_file(from, 3);
  make_file(to, 1);
  const OsFile reader = OsFile::open_to_read(to);
  try {
    rename_file(from, to, OldFile::replaced);
    EXPECT_EQ(OsFile::open_to_read(to).size(), 3u);
  } catch (const Error& e) { // Windows before 10, and Wine; both files are as they were
    EXPECT_EQ(e.code(), Code::permission_denied);
    EXPECT_EQ(OsFile::open_to_read(from).size(), 3u);
#ifndef _WIN32
    ADD_FAILURE() << e.what();
#endif
  }
  EXPECT_EQ(reader.size(), 1u);
  remove_file(to);
  EXPECT_EQ(reader.size(), 1u);
}

TEST(OsFiles, KindsOfPaths) {
  const Folder folder;
  const std::string path = folder.file("a.bin");
  EXPECT_EQ(path_kind(path), PathKind::nothing);
  EXPECT_FALSE(name_is_taken(path));
  make_file(path);
  EXPECT_EQ(path_kind(path), PathKind::file);
  EXPECT_TRUE(name_is_taken(path));
  EXPECT_EQ(path_kind(folder.file(".")), PathKind::folder);
  remove_file(path);
  EXPECT_EQ(path_kind(path), PathKind::nothing);
  remove_file(path); // which is nothing to tell
}

TEST(OsFiles, ErrorsNameThePathAndTheReason) {
  const Folder folder;
  const std::string missing = folder.file("missing.bin");
  EXPECT_EQ(code_of([&] { (void)OsFile::open_to_read(missing); }), Code::file_not_found);
  const std::string nowhere = folder.file("no/such/folder.bin");
  EXPECT_EQ(code_of([&] { (void)OsFile::open_to_write(nowhere, nowhere); }), Code::file_not_found);
  EXPECT_NE(code_of([&] { (void)OsFile::open_to_read(folder.file(".")); }), Code::ok);
  try {
    (void)OsFile::open_to_read(missing);
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find(missing + ": cannot open: "), std::string::npos) << e.what();
  }
}

} // namespace
} // namespace bccsplat
