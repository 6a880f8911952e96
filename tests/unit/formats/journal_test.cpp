// SPDX-License-Identifier: Apache-2.0
// A writer that goes on from where an earlier one was stopped, and one that goes on from a finished file.
#include "formats/bcc4/write/journal.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>

#include "tests/unit/formats/test_data.h"

namespace bccsplat::test {
namespace {

using Bytes = std::vector<std::byte>;
namespace fs = std::filesystem;

constexpr std::array<uint32_t, 4> dims{40, 30, 20, 40};

VolumeInfo two_channels(const std::array<uint32_t, 4>& d = dims) {
  return volume(LatticeKind::d4star, d, {channel("a", ValueType::u8), channel("b", ValueType::u16, 3)});
}

Bytes read_file(const std::string& path) {
  const auto file = open_file_source(path);
  Bytes bytes(file->size());
  file->read_at(0, bytes);
  return bytes;
}

class Bcc4JournalTest : public testing::Test {
 protected:
  Bcc4JournalTest() {
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  ~Bcc4JournalTest() override { fs::remove_all(folder); }
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& e : fs::directory_iterator(folder)) all.push_back(e.path().filename().string());
    return all;
  }

  // Writes `slabs` slabs of every channel, each committed, and finishes when all are there. interval: bytes
  // from commit to commit.
  Bcc4Report write(bool resume, int32_t slabs, uint32_t fingerprint = 7, uint64_t interval = 1) {
    Bcc4WriterOptions o;
    o.journal = std::make_shared<Bcc4Journal>(path, resume, interval);
    o.fingerprint = fingerprint;
    Bcc4Writer writer(create_file_sink(path, false, resume ? Partial::taken_over : Partial::kept), info, o);
    for (int32_t s = 0; s < slabs; ++s)
      for (size_t c = 0; c < layers.size(); ++c) {
        const size_t first = s * info.slab_layers;
        const size_t count = std::min<size_t>(info.slab_layers, layers[c].size() - first);
        writer.write_slab(s, static_cast<int>(c), std::span(layers[c]).subspan(first, count), bench.context);
      }
    return slabs == info.slabs() ? writer.finish(bench.context) : Bcc4Report{};
  }
  Bench bench{2};
  const std::string folder =
      (fs::temp_directory_path() / ("bccsplat-journal-" + std::to_string(::getpid()))).string();
  const std::string path = folder + "/x.bcc4";
  const VolumeInfo info = two_channels();
  const Layers layers = make_volume(info, ball_without_holes);
  const Bytes undisturbed = write_file(info, layers);
};

TEST_F(Bcc4JournalTest, GoesOnToTheSameBytesFromAnySlab) {
  for (const int32_t stop : {1, 3, info.slabs() - 1}) {
    write(false, stop);
    ASSERT_EQ(names().size(), 2u) << "partial file and journal";
    const Bcc4Report report = write(true, info.slabs());
    EXPECT_EQ(read_file(path), undisturbed);
    EXPECT_EQ(names(), std::vector<std::string>{"x.bcc4"});
    // Slabs of air alone are not worth a commit.
    EXPECT_GE(report.slabs_reused, static_cast<uint64_t>(2 * std::min(stop, 3)));
    EXPECT_LE(report.slabs_reused, static_cast<uint64_t>(2 * stop));
    fs::remove(path);
  }
}

// What was coded since the last commit is not lost with a writer that is let go.
TEST_F(Bcc4JournalTest, ALetGoWriterLeavesAllThatItCoded) {
  for (const uint64_t interval : {uint64_t{1}, uint64_t{1} << 40}) {
    write(false, 3, 7, interval);
    const Bcc4Report report = write(true, info.slabs());
    EXPECT_EQ(report.slabs_reused, 6u);
    EXPECT_EQ(read_file(path), undisturbed);
    fs::remove(path);
  }
}

TEST_F(Bcc4JournalTest, AJournalCutAnywhereIsUsedAsFarAsItGoes) {
  write(false, 4);
  const Bytes journal = read_file(path + ".journal"), partial = read_file(path + ".partial");
  ASSERT_GT(journal.size(), 100u);
  for (size_t n = 0; n <= journal.size(); n += n < 40 ? 1 : 97) {
    // Both as they were, but for the end of the journal.
    const auto restore = [&](const std::string& to, std::span<const std::byte> bytes) {
      fs::remove(to);
      create_journal_sink(to, 0)->write_at(0, bytes);
    };
    restore(path + ".partial", partial);
    restore(path + ".journal", std::span(journal).first(n));
    Bcc4WriterOptions o;
    o.journal = std::make_shared<Bcc4Journal>(path, true, 1);
    o.fingerprint = 7;
    Bcc4Writer writer(create_file_sink(path, true, Partial::taken_over), info, o);
    for (int32_t s = 0; s < info.slabs(); ++s)
      for (size_t c = 0; c < layers.size(); ++c) {
        const size_t first = s * info.slab_layers;
        const size_t count = std::min<size_t>(info.slab_layers, layers[c].size() - first);
        writer.write_slab(s, static_cast<int>(c), std::span(layers[c]).subspan(first, count), bench.context);
      }
    static_cast<void>(writer.finish(bench.context));
    ASSERT_EQ(read_file(path), undisturbed) << n << " bytes of the journal";
  }
}

// A crash may leave zeros there; the most of them make a file of more than 1 GiB, with nothing on disk.
TEST_F(Bcc4JournalTest, ZerosBehindTheRecordsEndThem) {
  for (const uint64_t zeros : {uint64_t{3}, uint64_t{4096}, uint64_t{1} << 30}) {
    write(false, 3);
    fs::resize_file(path + ".journal", fs::file_size(path + ".journal") + zeros);
    const Bcc4Report report = write(true, info.slabs());
    EXPECT_EQ(report.slabs_reused, 6u) << zeros;
    EXPECT_EQ(read_file(path), undisturbed) << zeros;
    fs::remove(path);
  }
}

// What is taken over is in the file: it may be cut, damaged, gone, or somebody else's since.
TEST_F(Bcc4JournalTest, AnUnfinishedFileThatIsNotTheJournalsIsWrittenAnew) {
  write(false, 4);
  const Bytes journal = read_file(path + ".journal"), partial = read_file(path + ".partial");
  const auto restore = [&](const std::string& to, std::span<const std::byte> bytes) {
    fs::remove(to);
    create_journal_sink(to, 0)->write_at(0, bytes);
  };
  const Bcc4Report whole = write(true, info.slabs());
  std::vector<Bytes> others{
      {}, Bytes(partial.begin(), partial.begin() + (partial.size() / 2)), Bytes(partial.size())};
  for (size_t share = 1; share < 8; ++share) {
    Bytes& flipped = others.emplace_back(partial);
    flipped[preamble_bytes + (partial.size() - preamble_bytes) * share / 8] ^= std::byte{4};
  }
  for (size_t i = 0; i <= others.size(); ++i) {
    fs::remove(path);
    fs::remove(path + ".partial");
    if (i < others.size()) restore(path + ".partial", others[i]);
    restore(path + ".journal", journal);
    const Bcc4Report report = write(true, info.slabs());
    EXPECT_EQ(read_file(path), undisturbed) << i;
    EXPECT_LT(report.slabs_reused, whole.slabs_reused) << i;
  }
}

TEST_F(Bcc4JournalTest, RefusesAnotherImport) {
  write(false, 3);
  try {
    write(true, 1, 8);
    FAIL() << "went on with what was made otherwise";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::wrong_state);
    EXPECT_NE(e.message().find("other options"), std::string::npos) << e.message();
  }
  EXPECT_EQ(names().size(), 2u) << "what is there stays";
}

TEST_F(Bcc4JournalTest, TwoWritersDoNotShareAFile) {
  const auto one = create_file_sink(path, false, Partial::kept);
  EXPECT_THROW(static_cast<void>(create_file_sink(path, false, Partial::taken_over)), Error);
}

TEST_F(Bcc4JournalTest, FirstSlabsOfAFinishedFileAreCopied) {
  const VolumeInfo shorter = two_channels({40, 30, 20, 24});
  const Bytes old = write_file(shorter, make_volume(shorter, ball_without_holes));
  Bcc4WriterOptions o;
  o.earlier = Bcc4Reader::open(open_memory_source(old));
  o.earlier_slabs = 3;
  Bytes bytes;
  const Bcc4Report report = write_to(create_memory_sink(bytes), info, layers, bench, o);
  EXPECT_EQ(bytes, undisturbed);
  EXPECT_EQ(report.slabs_reused, 6u);
}

} // namespace
} // namespace bccsplat::test
