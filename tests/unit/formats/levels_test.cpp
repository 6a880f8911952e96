// SPDX-License-Identifier: Apache-2.0
// Coarser levels in the container: lattices, slabs, chunks and counts of their own.
#include <gtest/gtest.h>

#include <filesystem>

#include <unistd.h>

#include "formats/bcc4/part.h"
#include "formats/bcc4/write/journal.h"
#include "tests/unit/formats/rebuild.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

using namespace test;

std::shared_ptr<Bcc4Reader> open(const Bytes& file, const Bcc4Limits& limits = {}) {
  return Bcc4Reader::open(open_memory_source(file), limits);
}

TEST(Bcc4Levels, EachIsAsAVolumeOfItsOwn) {
  const Bytes file = levels_file();
  const auto reader = open(file);
  const VolumeInfo& info = reader->info();
  ASSERT_EQ(info.level_count(), 3);
  Bench bench(2);
  for (int l = 0; l < 3; ++l) {
    SCOPED_TRACE(l);
    const VolumeInfo one = volume_of_level(levels_info(), l);
    EXPECT_EQ(info.level(l), static_cast<const StoredLattice&>(one));
    const Bytes alone = write_file(one, ball);
    EXPECT_FALSE(difference(read_all(alone), read_all(reader, bench, l)));
    const auto other = open(alone);
    for (size_t c = 0; c < info.channels.size() && l > 0; ++c) {
      const LevelChannel& told = info.levels[static_cast<size_t>(l) - 1].channels[c];
      const ChannelInfo& expected = other->info().channels[c];
      EXPECT_EQ(told.sites_kept, expected.sites_kept);
      EXPECT_EQ(told.holes, expected.holes);
      EXPECT_EQ(told.kept_range, expected.kept_range);
    }
    EXPECT_EQ(reader->level_bytes(l), other->level_bytes(0));
    EXPECT_GT(reader->level_bytes(l), 100u);
  }
  const auto found = reader->verify_all(bench.context);
  EXPECT_EQ(found.chunks, reader->chunk_count());
  for (const Bcc4Damage& d : found.damage) ADD_FAILURE() << d.message;
}

TEST(Bcc4Levels, ACoarseSlabIsOneReadOfFewBytes) {
  const Bytes file = levels_file();
  Bench bench;
  const auto coarse = open(file), fine = open(file);
  (void)read_all(coarse, bench, 2), (void)read_all(fine, bench, 0);
  EXPECT_LT(3 * (coarse->bytes_read() - preamble_bytes), fine->bytes_read() - preamble_bytes);
}

TEST(Bcc4Levels, ThoseThatAreNotThereAreRefused) {
  const Bytes levels = levels_file();
  const auto reader = open(levels);
  Bench bench;
  EXPECT_THROW((void)reader->chunks({0, 3}, 0), Error);
  EXPECT_THROW(Bcc4Samples(reader, bench.memory, 0, RelativeTo::air, 3), Error);
  const Bytes plain =
      write_file(volume(LatticeKind::d4star, {12, 12, 12, 3}, {channel("a", ValueType::u8)}), ball);
  EXPECT_THROW(Bcc4Samples(open(plain), bench.memory, 0, RelativeTo::air, 1), Error);
}

TEST(Bcc4Levels, TheWriterKeepsThemApart) {
  const VolumeInfo info = levels_info();
  Bench bench;
  Bytes bytes;
  Bcc4Writer writer(create_memory_sink(bytes), info);
  const Layers fine = make_volume(volume_of_level(info, 0), ball);
  const auto slab = std::span(fine[0]).first(8);
  EXPECT_THROW(writer.write_slab(0, {0, 1}, slab, bench.context), Error) << "the lattice of another level";
  EXPECT_THROW(writer.write_slab(0, {0, 3}, slab, bench.context), Error) << "no such level";
  writer.write_slab(0, {0, 0}, slab, bench.context);
  writer.info().levels[0].slab_layers = 4;
  EXPECT_THROW(writer.write_slab(1, {0, 0}, slab, bench.context), Error) << "the layers of a level changed";
}

TEST(Bcc4Levels, DamageSaysItsLevel) {
  const Bytes file = levels_file();
  const auto whole = open(file);
  const Bcc4Chunk victim = whole->chunks({0, 2}, 0).front();
  Bytes bad = file;
  bad[victim.offset + 3] ^= std::byte{8};
  Bench bench;
  const auto found = open(bad)->verify_all(bench.context);
  ASSERT_EQ(found.damage.size(), 1u);
  EXPECT_EQ(found.damage[0].level, 2);
  EXPECT_NE(found.damage[0].message.find("channel value, level 2, samples x"), std::string::npos)
      << found.damage[0].message;
  EXPECT_EQ(found.survivors, "no sample of level 0 is lost");
  const auto salvaged = open(bad, {.salvage = true});
  EXPECT_FALSE(difference(read_all(whole, bench, 0), read_all(salvaged, bench, 0)));
  EXPECT_TRUE(difference(read_all(whole, bench, 2), read_all(salvaged, bench, 2)));
}

TEST(Bcc4Levels, AJournalKnowsThem) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("bccsplat-levels-" + std::to_string(::getpid()));
  fs::create_directories(folder);
  const std::string path = (folder / "x.bcc4").string();
  const VolumeInfo info = levels_info();
  Bench bench;
  const auto writer = [&](bool resume) {
    Bcc4WriterOptions o;
    o.journal = std::make_shared<Bcc4Journal>(path, resume, 1);
    return Bcc4Writer(create_file_sink(path, true, resume ? Partial::taken_over : Partial::kept), info, o);
  };
  {
    Bcc4Writer interrupted = writer(false);
    write_levels(interrupted, info, ball_without_holes, bench);
  }
  Bcc4Writer resumed = writer(true);
  write_levels(resumed, info, ball_without_holes, bench);
  EXPECT_GT(resumed.finish(bench.context).slabs_reused, 3u);
  Bytes bytes(fs::file_size(path));
  open_file_source(path)->read_at(0, bytes);
  EXPECT_EQ(bytes, levels_file(ball_without_holes));
  fs::remove_all(folder);
}

TEST(Bcc4Levels, WritesOfPartsHaveAnOrder) {
  // By trigger and channel; masks, then coarse levels, then finer ones with their corrections.
  const std::vector<PartWrite> order{{3, 0, PartWrite::mask, 3},
                                     {3, 0, 1, PartWrite::chunks, 2},
                                     {3, 0, 2, PartWrite::chunks, 2},
                                     {3, 0, 1, PartWrite::chunks, 1},
                                     {3, 0, 1},
                                     {3, 0, 1, 5},
                                     {3, 0, 2},
                                     {3, 1, 0, PartWrite::chunks, 2},
                                     {4, 0, 0}};
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  EXPECT_EQ(std::adjacent_find(order.begin(), order.end()), order.end());
  PartInfo part{SeriesBlock::of_frames(0, 6), 1, order, {}};
  ByteWriter out;
  write_part(out, part);
  ByteReader in(out.bytes(), "part");
  EXPECT_EQ(read_part(in, 6, 2, 3), part);
  ByteReader again(out.bytes(), "part");
  EXPECT_THROW((void)read_part(again, 6, 2, 2), Error) << "level 2 of 2";
}

// What a file says that breaks a rule of record 9, or of the directory.
struct BrokenLevel {
  const char* text;
  Edit edit;
};

// Changes the payload of record 9.
Edit with_record(const std::function<void(Bytes&, size_t at)>& change) {
  return {.metadata = [change](Bytes& m) {
    size_t at = 0;
    while (peek<uint16_t>(m, at) != 9) at += 8 + (peek<uint32_t>(m, at + 4) + 7) / 8 * 8;
    change(m, at + 8);
  }};
}

TEST(Bcc4Levels, HostileOnesAreRefusedByName) {
  const Bytes file = levels_file();
  const std::vector<BrokenLevel> all{
      {"0 levels in", with_record([](Bytes& m, size_t at) { poke<uint32_t>(m, at, 0); })},
      {"16 levels in", with_record([](Bytes& m, size_t at) { poke<uint32_t>(m, at, 16); })},
      {"1 levels in", with_record([](Bytes& m, size_t at) { poke<uint32_t>(m, at, 1); })},
      {"reserved bytes of a level",
       with_record([](Bytes& m, size_t at) { poke<uint8_t>(m, at + 4 + 1, 1); })},
      {"reserved bytes of a level",
       with_record([](Bytes& m, size_t at) { poke<uint8_t>(m, at + 4 + 11, 1); })},
      {"reserved bytes of a level",
       with_record([](Bytes& m, size_t at) { poke<uint32_t>(m, at + 4 + 28, 1); })},
      {"level 1: 0 layers in a slab", with_info([](VolumeInfo& v) { v.levels[0].slab_layers = 0; })},
      {"level 1: 33 layers in a slab", with_info([](VolumeInfo& v) { v.levels[0].slab_layers = 33; })},
      {"level 2: last plane 0", with_info([](VolumeInfo& v) { v.levels[1].lattice.space.last[1] = 0; })},
      {"level 2: the last plane of axis 1",
       with_info([](VolumeInfo& v) { ++v.levels[1].lattice.space.last[1]; })},
      {"level 1: the last plane of axis 2",
       with_info([](VolumeInfo& v) { v.levels[0].lattice.space_step[2] *= 2; })},
      {"level 1: the last plane of axis 0",
       with_info([](VolumeInfo& v) { v.levels[0].lattice.behind[0] = 0; })},
      {"level 1: 1 planes before axis 0",
       with_info([](VolumeInfo& v) { v.levels[0].lattice.before[0] = 1; })},
      {"level 2: 1 layers before the first frame",
       with_info([](VolumeInfo& v) { v.levels[1].lattice.lead = 1; })},
      {"level 1: the last layer stands",
       with_info([](VolumeInfo& v) { v.levels[0].lattice.last_layer = 3; })},
      {"level 1: 7 frames need a lattice in time",
       with_info([](VolumeInfo& v) { v.levels[0].lattice.time_step = NAN; })},
      {"level 2: planes of axis 0",
       with_info([](VolumeInfo& v) { std::swap(v.levels[0].lattice, v.levels[1].lattice); })},
      {"level 1: layers are", with_info([](VolumeInfo& v) {
         Lattice4& l = v.levels[0].lattice;
         l.time_step /= 2, l.last_layer *= 2;
       })},
      {"a level with scale 0.75 of channel value, which has 0.5",
       with_record([](Bytes& m, size_t at) { poke<double>(m, at + 4 + 2 * 64, 0.75); })},
      {"a level with scale nan of channel other",
       with_record([](Bytes& m, size_t at) { poke<double>(m, at + 4 + 2 * 64 + 3 * 48, NAN); })},
      {"level 1: 1000000000 kept sites",
       with_info([](VolumeInfo& v) { v.levels[0].channels[0].sites_kept = 1000000000; })},
      {"kept sites of", with_info([](VolumeInfo& v) {
         v.levels[1].channels[1].holes = v.levels[1].channels[1].sites_kept + 1;
       })},
      {"samples from 1 to 0", with_info([](VolumeInfo& v) {
         v.levels[1].channels[1].kept_range = {1, 0};
       })},
      {"level 3 of 3", with_pages([](auto& p) { p.back().level = 3; })},
      {"reserved bytes are not zero", {.directory = [](Bytes& d) { poke<uint32_t>(d, 60, 1); }}},
      {"pages do not rise at channel 0, level 1", with_pages([](auto& p) { std::swap(p[1], p[2]); })},
      {"a page from slab", with_pages([](auto& p) { p[2].last_slab = 90; })},
      // A chunk that only the finer lattice has.
      {"do not exist",
       {.entries = [](std::vector<Bcc4Chunk>& e) { e.back().slot += 100; },
        .pages =
            [](std::vector<PageRef>& p) {
              for (PageRef& r : p) r.last_slot -= 100;
            }}}};
  Bench bench;
  EXPECT_NO_THROW((void)read_all(rebuild(file, {}), 1));
  for (const BrokenLevel& b : all) {
    SCOPED_TRACE(b.text);
    try {
      const Bytes broken = rebuild(file, b.edit);
      const auto reader = open(broken);
      for (int l = 0; l < reader->info().level_count(); ++l) (void)read_all(reader, bench, l);
      ADD_FAILURE() << "was read";
    } catch (const Error& e) {
      EXPECT_NE(e.message().find(b.text), std::string::npos) << e.message();
      EXPECT_EQ(e.code(), Code::corrupt) << e.message();
    }
  }
  try {
    (void)open(file, {.bricks_per_layer = 3});
    ADD_FAILURE() << "a limit was passed over";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::limit_exceeded);
  }
}

} // namespace
} // namespace bccsplat
