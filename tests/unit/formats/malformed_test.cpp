// SPDX-License-Identifier: Apache-2.0
// Damage and malice: every rule of formats/bcc4.md has a file that breaks it, checksums right where they can
// be.
#include <gtest/gtest.h>

#include "tests/support/emulated.h"
#include "tests/unit/formats/rebuild.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

using namespace test;

const Bytes& small_file() {
  static const Bytes file = [] {
    VolumeInfo info = volume(LatticeKind::d4star, {24, 14, 12, 9},
                             {channel("a", ValueType::u8), channel("b", ValueType::f16)});
    info.attributes = {{"key", "value"}};
    info.channels[0].histogram.assign(256, 1);
    return write_file(info, ball);
  }();
  return file;
}

void read_everything(const Bytes& file, const Bcc4Limits& limits = {}) {
  Bench bench;
  const auto reader = Bcc4Reader::open(open_memory_source(file), limits);
  static_cast<void>(read_all(reader, bench));
}

void expect_refused(const Bytes& file, Code code, const char* text, const Bcc4Limits& limits = {}) {
  try {
    read_everything(file, limits);
    ADD_FAILURE() << "read in spite of: " << text;
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), code) << e.message();
    EXPECT_NE(e.message().find(text), std::string::npos) << text << " expected: " << e.message();
  }
}

TEST(Bcc4Malformed, ARebuiltFileIsRead) {
  // The tool of the tests below changes nothing by itself.
  for (const bool raw : {false, true}) {
    Edit edit;
    edit.raw_blocks = raw;
    edit.chunk = [](Bcc4Chunk&, Bytes&) {};
    const Bytes file = rebuild(small_file(), edit);
    EXPECT_FALSE(difference(read_all(small_file()), read_all(file)));
    Bench bench;
    for (const auto& d : Bcc4Reader::open(open_memory_source(file))->verify_all(bench.context).damage)
      ADD_FAILURE() << d.message;
  }
}

// ---- Damage without malice ----

// Everything a file has: samples and corrections of all frames.
struct Content {
  Layers layers;
  std::vector<FrameResiduals> corrections; // and those in bricks, with voxels of the bricks
  std::vector<uint64_t> masks;             // ends of runs
  bool operator==(const Content& other) const {
    return !difference(layers, other.layers) && corrections == other.corrections && masks == other.masks;
  }
};

Content content_of(const std::shared_ptr<Bcc4Reader>& reader, Bench& bench) {
  Content all{read_all(reader, bench), {}, {}};
  const VolumeInfo& info = reader->info();
  for (size_t c = 0; c < info.channels.size(); ++c)
    for (uint64_t f = 0; f < info.lattice.dims[3]; ++f) {
      all.corrections.push_back(reader->residuals(static_cast<int>(c), f));
      for (const CorrectionBrick& brick : reader->correction_bricks(static_cast<int>(c), f))
        all.corrections.push_back({.add = reader->corrections(static_cast<int>(c), brick), .set = {}});
      reader->mask_runs(static_cast<int>(c), f, [&](uint64_t begin, uint64_t end) {
        all.masks.push_back(begin), all.masks.push_back(end);
      });
    }
  return all;
}

// A part of a series with corrections: the records that most files lack.
Bytes part_with_corrections() {
  VolumeInfo info = volume(LatticeKind::d4star, {12, 12, 10, 3}, {channel("a", ValueType::u16)});
  info.channels[0].residuals.step = 0.25, info.channels[0].residuals.bound = 0.125;
  info.part = PartInfo{
      .block = SeriesBlock::of_frames(1, 3), .series = 77, .writes = {{3, 0, 0, 1}}, .statistics = {}};
  Bytes bytes;
  Bench bench;
  Bcc4Writer writer(create_memory_sink(bytes), info);
  const Layers layers = make_volume(info, ball);
  writer.write_slab(0, 0, layers[0], bench.context);
  writer.write_residuals(0, 1, {.add = {{3, -2}, {700, 5}}, .set = {{9, 1}}}, bench.context);
  writer.finish(bench.context);
  return bytes;
}

// Corrections in bricks, and what was measured.
Bytes file_with_bricks() {
  VolumeInfo info = volume(LatticeKind::d4star, {66, 4, 5, 2}, {channel("a", ValueType::u8)});
  ResidualInfo& fix = info.channels[0].residuals;
  fix.step = fix.bound = 0.25, fix.local = true, fix.shape = CorrectionShape::smooth;
  info.errors = {{.kind = 1, .frames = 2, .samples = 9, .rmse = 1, .largest = 2, .range = 3}};
  Bytes bytes;
  Bench bench;
  Bcc4Writer writer(create_memory_sink(bytes), info);
  const Layers layers = make_volume(info, ball);
  writer.write_slab(0, 0, layers[0], bench.context);
  writer.write_residuals(0, 1, {.add = {{3, -2}, {65, 5}, {700, 1}}, .set = {{9, 1}}}, bench.context);
  writer.finish(bench.context);
  return bytes;
}

TEST(Bcc4Malformed, EveryFlippedBitIsSeenOrHarmless) {
  const std::vector<Bytes> files = {
      write_file(volume(LatticeKind::d4star, {12, 12, 10, 3}, {channel("a", ValueType::u8)}), ball),
      write_file(
          volume(LatticeKind::cc, {9, 8, 7, 2}, {channel("a", ValueType::f32), channel("b", ValueType::f16)}),
          ball_without_holes, 1, {.level = 0}),
      part_with_corrections(), file_with_bricks(), masked_file()};
  for (const Bytes& good : files) {
    Bench bench;
    Bytes bad = good;
    size_t refused = 0;
    // Every bit; under an emulator one of every byte.
    for (size_t at = 0; at < good.size(); ++at) {
      for (int bit = test::emulated ? static_cast<int>(at % 8) : 0; bit < 8; bit += test::emulated ? 8 : 1) {
        bad[at] ^= static_cast<std::byte>(1 << bit);
        try {
          static_cast<void>(content_of(Bcc4Reader::open(open_memory_source(bad)), bench));
          ADD_FAILURE() << "byte " << at << " bit " << bit;
        } catch (const Error&) {
          ++refused;
        }
        bad[at] ^= static_cast<std::byte>(1 << bit);
      }
    }
    EXPECT_EQ(refused, (test::emulated ? 1 : 8) * good.size());
  }
}

// What verifying and salvaging make of a flipped bit behind the preamble: it is reported, and what is read in
// spite of it is as it was, or a hole.
TEST(Bcc4Malformed, EveryFlippedBitIsReportedAndTheRestSalvaged) {
  const Bytes good =
      write_file(volume(LatticeKind::d4star, {12, 12, 10, 3}, {channel("a", ValueType::u8)}), ball);
  const Layers expected = read_all(good);
  Bytes bad = good;
  size_t salvaged = 0, lost = 0;
  for (size_t at = preamble_bytes; at < good.size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      bad[at] ^= static_cast<std::byte>(1 << bit);
      Bench bench;
      try {
        EXPECT_FALSE(Bcc4Reader::open(open_memory_source(bad))->verify_all(bench.context).damage.empty());
        const Layers got = read_all(Bcc4Reader::open(open_memory_source(bad), {.salvage = true}), bench);
        ++salvaged;
        for (size_t m = 0; m < got[0].size(); ++m)
          for (size_t s = 0; s < got[0][m].brick_slots(); ++s) {
            const Brick *was = expected[0][m].brick(s), *is = got[0][m].brick(s);
            for (int i = 0; i < brick_sites; ++i) {
              if (is && is->is_hole(i)) {
                ++lost;
                continue;
              }
              const size_t site = i;
              ASSERT_EQ(is ? is->value[site] : 0, was ? was->value[site] : 0)
                  << "byte " << at << " bit " << bit;
            }
          }
      } catch (const Error&) {
        // Metadata or the list of pages: salvaging needs them whole.
      }
      bad[at] ^= static_cast<std::byte>(1 << bit);
    }
  EXPECT_GT(salvaged, 1000u);
  EXPECT_GT(lost, salvaged);
}

TEST(Bcc4Malformed, TruncationAnywhere) {
  const Bytes& good = small_file();
  for (size_t n = 0; n < good.size(); n += 64) {
    const Bytes cut(good.begin(), good.begin() + n);
    try {
      read_everything(cut);
      ADD_FAILURE() << n << " bytes were read";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), n < 5 ? Code::not_bcc4 : Code::truncated) << n << " bytes: " << e.message();
    }
  }
  Bytes longer = good; // what an interrupted append leaves
  longer.resize(good.size() + 1000, std::byte{0x55});
  EXPECT_FALSE(difference(read_all(good), read_all(longer)));
}

TEST(Bcc4Malformed, NotOurs) {
  Bytes bytes(20'000, std::byte{'x'});
  expect_refused(bytes, Code::not_bcc4, "not a .bcc4 file");
  std::fill(bytes.begin(), bytes.end(), std::byte{0});
  expect_refused(bytes, Code::not_bcc4, "never finished");
  expect_refused({}, Code::not_bcc4, "not a .bcc4 file");
}

TEST(Bcc4Malformed, TextModeAndSevenBits) {
  const Bytes& good = small_file();
  const auto replace = [&](std::initializer_list<int> from, std::initializer_list<int> to) {
    Bytes out;
    for (size_t i = 0; i < good.size();) {
      bool match = i + from.size() <= good.size();
      size_t k = 0;
      for (const int b : from)
        match = match && good[std::min(i + k++, good.size() - 1)] == static_cast<std::byte>(b);
      if (match) {
        for (const int b : to) out.push_back(static_cast<std::byte>(b));
        i += from.size();
      } else {
        out.push_back(good[i++]);
      }
    }
    return out;
  };
  expect_refused(replace({0x0d, 0x0a}, {0x0a}), Code::corrupt, "as text");
  expect_refused(replace({0x0a}, {0x0d, 0x0a}), Code::corrupt, "as text");
  Bytes seven = good;
  for (std::byte& b : seven) b &= std::byte{0x7f};
  expect_refused(seven, Code::corrupt, "as text");
}

// Whoever asks for the sums takes them as they are; a check of the file counts.
TEST(Bcc4Malformed, SumsThatAreNotThoseOfTheBlocksAreListed) {
  Bench bench;
  const auto damage = [&](const Bytes& good, uint64_t FrameSums::*which) {
    const Bytes bad = rebuild(good, with_info([&](VolumeInfo& v) { --((*v.channels[0].sums).*which); }));
    return Bcc4Reader::open(open_memory_source(bad))->verify_all(bench.context).damage;
  };
  const auto corrections = damage(corrected_file(), &FrameSums::corrections);
  const auto told = [](const std::vector<Bcc4Damage>& all, std::string_view text) {
    return std::any_of(all.begin(), all.end(),
                       [&](const Bcc4Damage& d) { return d.message.find(text) != std::string::npos; });
  };
  EXPECT_TRUE(told(corrections, "28 samples are corrected, the metadata say 27"));
  const auto missing = damage(masked_file(), &FrameSums::missing);
  EXPECT_TRUE(told(missing, "1776 samples are missing, the metadata say 1775"));
}

TEST(Bcc4Malformed, DamageIsListedAndTheRestRead) {
  const Bytes& good = small_file();
  const auto whole = Bcc4Reader::open(open_memory_source(good));
  const Bcc4Chunk victim = whole->chunks(1, 1).front();
  Bytes bad = good;
  bad[victim.offset + 3] ^= std::byte{8};
  Bench bench;
  const auto reader = Bcc4Reader::open(open_memory_source(bad));
  const Bcc4VerifyResult result = reader->verify_all(bench.context);
  EXPECT_EQ(result.chunks, reader->chunk_count());
  EXPECT_EQ(result.chunks_damaged, 1u);
  ASSERT_EQ(result.damage.size(), 1u);
  const Bcc4Damage& d = result.damage[0];
  EXPECT_EQ(d.code, Code::checksum_mismatch);
  EXPECT_EQ(d.offset, victim.offset);
  EXPECT_EQ(d.channel, 1);
  EXPECT_EQ(d.first_layer, 8);
  EXPECT_EQ(d.last_layer, reader->info().lattice.last_layer);
  EXPECT_FALSE(d.whole_layers);
  EXPECT_EQ(d.brick, whole->brick_position(victim.slot));
  const Bcc4Samples samples(reader, bench.memory);
  EXPECT_THROW(static_cast<void>(samples.read_layer(1, 9, {}, bench.context)), Error);
  EXPECT_NO_THROW(static_cast<void>(samples.read_layer(1, 2, {}, bench.context)));
  EXPECT_NO_THROW(static_cast<void>(samples.read_layer(0, 9, {}, bench.context)));
}

// ---- Rules, each broken by a writer that gets its checksums right ----

struct Broken {
  const char* text; // of the message
  Code code;
  Edit edit;
};

Edit with_metadata(const std::function<void(Bytes&)>& change) {
  Edit e;
  e.metadata = change;
  return e;
}
// Counts of 8 bytes, in the last record of the file, of which it says that they are `bytes`.
Edit with_counts_of(uint32_t bytes) {
  return with_metadata([bytes](Bytes& m) {
    VolumeInfo v = read_metadata(m, 0, {});
    v.counts = CountsInfo{0, Bytes(8)};
    m = write_metadata(v);
    poke<uint32_t>(m, m.size() - 12, bytes);
  });
}
Edit with_first_entry(const std::function<void(Bcc4Chunk&)>& change) {
  Edit e;
  e.entries = [change](std::vector<Bcc4Chunk>& entries) { change(entries[0]); };
  return e;
}
Edit with_chunk(const std::function<void(Bcc4Chunk&, Bytes&)>& change) {
  Edit e;
  e.chunk = change;
  return e;
}
Edit with_page(const std::function<void(Bytes&)>& change) {
  Edit e;
  e.page = change;
  return e;
}
Edit with_directory(const std::function<void(Bytes&)>& change) {
  Edit e;
  e.directory = change;
  return e;
}
Edit with_root(const std::function<void(Root&)>& change) {
  Edit e;
  e.root = change;
  return e;
}

void expect_each_refused(const std::vector<Broken>& all, const Bytes& file = small_file()) {
  for (const Broken& b : all) {
    SCOPED_TRACE(b.text);
    expect_refused(rebuild(file, b.edit), b.code, b.text);
  }
}

void seal_header(Bytes& file) { poke<uint32_t>(file, 60, crc32_of(std::span(file).first(60))); }

// Where the first record of a type has its fields.
size_t fields_of(const Bytes& metadata, uint16_t type) {
  size_t at = 0;
  while (peek<uint16_t>(metadata, at) != type) at += 8 + (peek<uint32_t>(metadata, at + 4) + 7) / 8 * 8;
  return at + 8;
}
// Says that the air of the first channel is another code.
void damage_air_code(Bytes& metadata) {
  const size_t at = fields_of(metadata, 5) + 4;
  poke<uint32_t>(metadata, at, peek<uint32_t>(metadata, at) + 1);
}

TEST(Bcc4Malformed, Header) {
  Bytes bad = small_file();
  poke<uint16_t>(bad, 14, bcc4_version + 1);
  seal_header(bad);
  expect_refused(bad, Code::unsupported_version, "needs a reader of version 6");
  for (const uint16_t older : std::array<uint16_t, 3>{0, 1, 4}) {
    poke<uint16_t>(bad, 14, older);
    seal_header(bad);
    expect_refused(bad, Code::unsupported_version, "made by a build before 0.1.0");
  }
  poke<uint16_t>(bad, 12, 7), poke<uint16_t>(bad, 14, bcc4_version); // a newer writer that used nothing new
  seal_header(bad);
  EXPECT_NO_THROW(read_everything(bad));
  poke<uint8_t>(bad, 30, 1);
  seal_header(bad);
  expect_refused(bad, Code::corrupt, "reserved");
}

TEST(Bcc4Malformed, Roots) {
  expect_each_refused({
      {"a file of", Code::checksum_mismatch, with_root([](Root& r) { r.file_bytes = 100; })},
      {"a file of", Code::checksum_mismatch, with_root([](Root& r) { r.file_bytes = UINT64_MAX; })},
      {"cut short", Code::truncated, with_root([](Root& r) { r.file_bytes += 1000; })},
      {"metadata", Code::checksum_mismatch, with_root([](Root& r) { r.metadata.offset = r.file_bytes + 8; })},
      {"metadata", Code::checksum_mismatch, with_root([](Root& r) { r.metadata.offset = 64; })},
      {"metadata", Code::checksum_mismatch, with_root([](Root& r) { r.metadata.offset += 4; })},
      {"metadata", Code::checksum_mismatch, with_root([](Root& r) { r.metadata.offset = UINT64_MAX - 7; })},
      {"metadata", Code::checksum_mismatch, with_root([](Root& r) { r.metadata.stored = UINT32_MAX; })},
      {"unknown coding", Code::checksum_mismatch, with_root([](Root& r) { r.metadata.coding = 2; })},
      {"cannot stand for", Code::checksum_mismatch,
       with_root([](Root& r) { r.metadata.decoded = UINT32_MAX; })},
      {"cannot stand for", Code::checksum_mismatch, with_root([](Root& r) { r.metadata.decoded = 1; })},
      {"cannot stand for", Code::checksum_mismatch, with_root([](Root& r) { r.metadata.coding = 0; })},
      {"no deflate stream", Code::corrupt, with_root([](Root& r) { ++r.metadata.decoded; })},
      {"no deflate stream", Code::corrupt, with_root([](Root& r) { --r.metadata.decoded; })},
      {"metadata", Code::checksum_mismatch, with_root([](Root& r) { r.metadata.crc ^= 1; })},
      {"index directory", Code::checksum_mismatch, with_root([](Root& r) { r.directory.offset = 0; })},
      {"larger than the file", Code::checksum_mismatch,
       with_root([](Root& r) { r.runs_bytes = r.file_bytes; })},
      {"size overflow", Code::checksum_mismatch,
       with_root([](Root& r) { r.runs_bytes = r.values_bytes = UINT64_MAX; })},
      {"chunks, the root says", Code::corrupt, with_root([](Root& r) { ++r.chunks; })},
  });
}

TEST(Bcc4Malformed, SequenceNumbersStartAtOne) {
  Bytes file = small_file();
  Root root = *read_preamble(std::span(file).first(preamble_bytes), "file").root;
  root.sequence = 0;
  const Bytes head = write_preamble(root);
  std::copy(head.begin(), head.end(), file.begin());
  expect_refused(file, Code::checksum_mismatch, "sequence number 0");
}

TEST(Bcc4Malformed, MetadataRecords) {
  constexpr size_t world_at = 8 + 88; // behind the lattice
  expect_each_refused({
      {"padding of record", Code::corrupt, with_metadata([](Bytes& m) {
         // The last record, attributes, ends with zeros when its text does not fill eight bytes.
         m.back() = std::byte{1};
       })},
      {"reserved bytes of record", Code::corrupt, with_metadata([](Bytes& m) { poke<uint16_t>(m, 2, 1); })},
      {"record 1 after record 1", Code::corrupt,
       with_metadata([](Bytes& m) { m.insert(m.begin(), m.begin(), m.begin() + world_at); })},
      {"a record is missing", Code::corrupt,
       with_metadata([](Bytes& m) { m.erase(m.begin(), m.begin() + world_at); })},
      {"unknown record 14", Code::unsupported_version, with_metadata([](Bytes& m) {
         const std::array<uint8_t, 8> record{14, 0, 0, 0, 0, 0, 0, 0};
         m.insert(m.end(), std::as_bytes(std::span(record)).begin(), std::as_bytes(std::span(record)).end());
       })},
      {"needs", Code::truncated, with_metadata([](Bytes& m) { poke<uint32_t>(m, 4, UINT32_MAX); })},
      {"bytes too many", Code::corrupt, with_metadata([](Bytes& m) {
         poke<uint32_t>(m, 4, 96);
         m.insert(m.begin() + world_at, 8, std::byte{0});
       })},
      {"needs", Code::truncated, with_metadata([](Bytes& m) { poke<uint32_t>(m, 4, 80); })},
      {"needs", Code::truncated, with_metadata([](Bytes& m) { m.resize(m.size() - 8); })},
      {"reserved bytes of the lattice", Code::corrupt,
       with_metadata([](Bytes& m) { poke<uint8_t>(m, 8 + 3, 1); })},
      {"1 layers before the first frame", Code::corrupt,
       with_metadata([](Bytes& m) { poke<uint8_t>(m, 8 + 2, 1); })},
      {"reserved bytes of the lattice", Code::corrupt,
       with_metadata([](Bytes& m) { poke<uint8_t>(m, 8 + 36, 1); })},
      {"the tail counts 9999 slabs", Code::corrupt, with_info([](VolumeInfo& v) {
         v.tail = TailInfo{9999, std::vector<uint64_t>(v.channels.size())};
       })},
      {"the counts are of 9999 slabs", Code::corrupt, with_info([](VolumeInfo& v) {
         v.counts = CountsInfo{9999, {std::byte{1}}};
       })},
      {"the counts are of -1 slabs", Code::corrupt, with_info([](VolumeInfo& v) {
         v.counts = CountsInfo{-1, {}};
       })},
      {"needs", Code::truncated, with_counts_of(9)},
      {"bytes too many", Code::corrupt, with_counts_of(7)},
      {"the tail counts -1 slabs", Code::corrupt, with_info([](VolumeInfo& v) {
         v.tail = TailInfo{-1, std::vector<uint64_t>(v.channels.size())};
       })},
      {"clamped samples of", Code::corrupt, with_info([](VolumeInfo& v) {
         v.tail = TailInfo{0, std::vector<uint64_t>(v.channels.size(), 1u << 30)};
       })},
      {"bytes too many", Code::corrupt, with_info([](VolumeInfo& v) {
         v.tail = TailInfo{0, std::vector<uint64_t>(v.channels.size() + 1)};
       })},
      {"needs", Code::truncated, with_info([](VolumeInfo& v) {
         v.tail = TailInfo{0, {}};
       })},
      // A text and a list that claim more than there is.
      {"text of", Code::limit_exceeded,
       with_metadata([](Bytes& m) { poke<uint32_t>(m, world_at + 8 + 96, 1u << 30); })},
      {"times for 9 frames", Code::corrupt,
       with_metadata([](Bytes& m) { poke<uint32_t>(m, world_at + 8 + 104 + 8 + 24, 1u << 30); })},
  });
}

TEST(Bcc4Malformed, Lattice) {
  expect_each_refused({
      {"unknown kind 9", Code::corrupt,
       with_info([](VolumeInfo& v) { v.lattice.kind = static_cast<LatticeKind>(9); })},
      {"a dimension is 0", Code::corrupt, with_info([](VolumeInfo& v) { v.lattice.dims[1] = 0; })},
      {"more than 2^63 source", Code::corrupt, with_info([](VolumeInfo& v) {
         v.lattice.dims = {UINT32_MAX, UINT32_MAX, 9, 9};
       })},
      {"last plane 0", Code::corrupt, with_info([](VolumeInfo& v) { v.lattice.space.last[2] = 0; })},
      {"last plane", Code::corrupt, with_info([](VolumeInfo& v) { v.lattice.space.last[2] = INT32_MAX; })},
      {"distance of planes", Code::corrupt, with_info([](VolumeInfo& v) { v.lattice.space_step[0] = -1; })},
      {"distance of planes", Code::corrupt, with_info([](VolumeInfo& v) { v.lattice.space_step[0] = NAN; })},
      {"the last plane of axis 0", Code::corrupt,
       with_info([](VolumeInfo& v) { v.lattice.space_step[0] *= 1.001; })},
      {"need a lattice in time", Code::corrupt, with_info([](VolumeInfo& v) { v.lattice.time_step = 0; })},
      {"need a lattice in time", Code::corrupt, with_info([](VolumeInfo& v) { v.lattice.last_layer = -5; })},
      {"need a lattice in time", Code::corrupt,
       with_info([](VolumeInfo& v) { v.lattice.kind = LatticeKind::bcc; })},
      {"the last layer stands", Code::corrupt, with_info([](VolumeInfo& v) { v.lattice.last_layer = 2; })},
      {"one frame needs", Code::corrupt, with_info([](VolumeInfo& v) { v.lattice.dims[3] = 1; })},
      {"scales must be", Code::corrupt, with_info([](VolumeInfo& v) { v.time_scale = 0; })},
      {"layers in a slab", Code::corrupt, with_info([](VolumeInfo& v) { v.slab_layers = 0; })},
      {"layers in a slab", Code::corrupt, with_info([](VolumeInfo& v) { v.slab_layers = 33; })},
      {"affine: not finite", Code::corrupt,
       with_info([](VolumeInfo& v) { v.affine.linear[1][2] = INFINITY; })},
      {"determinant 0", Code::corrupt,
       with_info([](VolumeInfo& v) { v.affine.linear[1] = v.affine.linear[0]; })},
      {"times: first", Code::corrupt, with_info([](VolumeInfo& v) { v.time.step = 0; })},
      {"for 9 frames", Code::corrupt, with_info([](VolumeInfo& v) {
         v.time.uniform = false, v.time.times = {1, 2};
       })},
      {"does not rise", Code::corrupt,
       with_info([](VolumeInfo& v) { v.time.uniform = false, v.time.times = {1, 2, 3, 4, 4, 5, 6, 7, 8}; })},
      {"not UTF-8", Code::corrupt, with_info([](VolumeInfo& v) { v.time.unit = "\xc0\x80"; })},
      {"not UTF-8", Code::corrupt, with_info([](VolumeInfo& v) { v.spatial_unit = std::string("m\0m", 3); })},
      {"attribute key", Code::corrupt,
       with_info([](VolumeInfo& v) { v.attributes.push_back(v.attributes[0]); })},
  });
}

// Record 4 of a file without a kernel has three numbers.
// Coordinates along z, of 12 samples; of x two samples that nobody gave.
Edit with_axes(const std::function<void(VolumeInfo&)>& change) {
  return with_info([change](VolumeInfo& v) {
    v.axes[2] = {"m", true, {0, 10, 20, 30, 50, 75, 100, 150, 200, 300, 500, 1000}};
    change(v);
  });
}

TEST(Bcc4Malformed, Coordinates) {
  expect_each_refused({
      {"11 coordinates for 12 samples", Code::corrupt,
       with_axes([](VolumeInfo& v) { v.axes[2].coordinates.pop_back(); })},
      {"2 coordinates for 24 samples", Code::corrupt, with_axes([](VolumeInfo& v) {
         v.axes[0].coordinates = {0, 1};
       })},
      {"sample 4 is not beyond", Code::corrupt,
       with_axes([](VolumeInfo& v) { v.axes[2].coordinates[4] = 30; })},
      {"sample 1 is not beyond", Code::corrupt,
       with_axes([](VolumeInfo& v) { v.axes[2].coordinates.back() = -1; })},
      {"sample 3 is not beyond", Code::corrupt,
       with_axes([](VolumeInfo& v) { v.axes[2].coordinates[3] = NAN; })},
      {"sample 11 is not beyond", Code::corrupt,
       with_axes([](VolumeInfo& v) { v.axes[2].coordinates.back() = INFINITY; })},
      {"too far apart", Code::corrupt, with_axes([](VolumeInfo& v) {
         v.axes[2].coordinates.front() = -1.7e308, v.axes[2].coordinates.back() = 1.7e308;
       })},
      {"are one place", Code::corrupt,
       with_axes([](VolumeInfo& v) { v.axes[2].coordinates.front() = -1e18; })},
      {"space has the unit mm", Code::corrupt, with_axes([](VolumeInfo& v) { v.spatial_unit = "mm"; })},
      {"not UTF-8", Code::corrupt, with_axes([](VolumeInfo& v) { v.axes[1].unit = "\xff"; })},
      {"coordinates of no axis", Code::corrupt, with_metadata([](Bytes& m) {
         const std::array<uint32_t, 11> record{0x8009, 36, 0, 0, 0, 0, 0, 0, 0, 0, 0};
         const auto bytes = std::as_bytes(std::span(record));
         m.insert(m.end(), bytes.begin(), bytes.end());
         m.insert(m.end(), 4, std::byte{0});
       })},
      {"flags 2 of an axis", Code::corrupt, with_metadata([](Bytes& m) {
         const std::array<uint32_t, 11> record{0x8009, 36, 0, 2, 0, 0, 0, 0, 0, 0, 0};
         const auto bytes = std::as_bytes(std::span(record));
         m.insert(m.end(), bytes.begin(), bytes.end());
         m.insert(m.end(), 4, std::byte{0});
       })},
      {"coordinates for 24 samples", Code::corrupt, with_metadata([](Bytes& m) {
         const std::array<uint32_t, 11> record{0x8009, 36, 0, 0, 1u << 30, 0, 0, 0, 0, 0, 0};
         const auto bytes = std::as_bytes(std::span(record));
         m.insert(m.end(), bytes.begin(), bytes.end());
         m.insert(m.end(), 4, std::byte{0});
       })},
      {"needs", Code::truncated, with_metadata([](Bytes& m) {
         const std::array<uint32_t, 10> record{0x8009, 32, 0, 0, 0, 0, 0, 0, 0, 0};
         const auto bytes = std::as_bytes(std::span(record));
         m.insert(m.end(), bytes.begin(), bytes.end());
       })},
  });
  VolumeInfo periodic = volume(LatticeKind::d4star, {24, 14, 12, 9}, {channel("a", ValueType::u8)});
  periodic.lattice =
      Lattice4::fit(LatticeKind::d4star, {24, 14, 12, 9}, {1, 1, 1, 1}, 0, {}, false, {false, false, true});
  periodic.axes[2].coordinates = {0, 1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  EXPECT_THROW(check_axes(periodic, Code::corrupt), Error);
}

TEST(Bcc4Malformed, HugeDeclaredSizesAllocateNothing) {
  // 10^9 planes per axis would be 10^17 bricks; 10^6 still ask for 256 TiB per layer.
  const auto planes = [](int32_t n) {
    return with_info([n](VolumeInfo& v) {
      for (size_t a = 0; a < 3; ++a) {
        v.lattice.dims[a] = n;
        v.lattice.space.last[a] = n;
        v.lattice.space_step[a] = (n - 1.0) / n;
      }
      v.lattice.dims[3] = 2;
    });
  };
  expect_refused(rebuild(small_file(), planes(1'000'000)), Code::corrupt, "more than");
  expect_refused(rebuild(small_file(), planes(20'000)), Code::limit_exceeded, "bricks, the limit is");
  expect_refused(small_file(), Code::limit_exceeded, "bricks, the limit is", {.bricks_per_layer = 1});
  expect_refused(small_file(), Code::limit_exceeded, "channels", {.channels = 1});
  expect_refused(small_file(), Code::limit_exceeded, "metadata of", {.metadata_bytes = 100});
  expect_refused(small_file(), Code::limit_exceeded, "directory of", {.directory_bytes = 100});
}

TEST(Bcc4Malformed, PlacesAndTimesThatNoHostMayGive) {
  const auto times = [](std::vector<double> t) {
    return with_info([t](VolumeInfo& v) { v.time.uniform = false, v.time.times = t; });
  };
  expect_each_refused({
      {"a mean voxel of", Code::limit_exceeded, with_info([](VolumeInfo& v) {
         v.affine.linear[0] = {5e-312, 0, 0};
       })},
      {"a mean voxel of", Code::limit_exceeded, with_info([](VolumeInfo& v) {
         v.affine.linear[2] = {0, 0, 1e-200};
       })},
      {"affine: 1e+31, the limit is", Code::limit_exceeded,
       with_info([](VolumeInfo& v) { v.affine.linear[1][2] = 1e31; })},
      {"affine: -1e+300, the limit is", Code::limit_exceeded,
       with_info([](VolumeInfo& v) { v.affine.offset[1] = -1e300; })},
      {"times: first 2e+30, the limit is", Code::limit_exceeded,
       with_info([](VolumeInfo& v) { v.time.first = 2e30; })},
      {"times: step 1e+31, the limit is", Code::limit_exceeded,
       with_info([](VolumeInfo& v) { v.time.step = 1e31; })},
      {"times: step 1e-300, the limit is", Code::limit_exceeded,
       with_info([](VolumeInfo& v) { v.time.step = 1e-300; })},
      {"times: 1e+31, the limit is", Code::limit_exceeded, times({1, 2, 3, 4, 5, 6, 7, 8, 1e31})},
      {"axes: a coordinate of -1e+40, the limit is", Code::limit_exceeded, with_info([](VolumeInfo& v) {
         v.axes[2].coordinates = {-1e40, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
         v.spatial_unit.clear();
       })},
  });
}

TEST(Bcc4Malformed, Channels) {
  expect_each_refused({
      {"unknown value type 5", Code::corrupt,
       with_info([](VolumeInfo& v) { v.channels[0].type = static_cast<ValueType>(5); })},
      {"unknown source type", Code::corrupt,
       with_info([](VolumeInfo& v) { v.channels[0].source_type = static_cast<SourceType>(10); })},
      {"scale", Code::corrupt, with_info([](VolumeInfo& v) { v.channels[0].scale = -1; })},
      {"2^22 steps", Code::corrupt,
       with_info([](VolumeInfo& v) { v.channels[0].scale = 1e-9, v.channels[0].offset = 1; })},
      {"range of floats", Code::corrupt, with_info([](VolumeInfo& v) { v.channels[0].scale = 1e34; })},
      {"offset = air", Code::corrupt, with_info([](VolumeInfo& v) { v.channels[1].offset = 5; })},
      {"air or threshold", Code::corrupt, with_info([](VolumeInfo& v) { v.channels[1].threshold = -1; })},
      {"a channel has no name", Code::corrupt, with_info([](VolumeInfo& v) { v.channels[1].name.clear(); })},
      {"two channels", Code::corrupt,
       with_info([](VolumeInfo& v) { v.channels[1].name = v.channels[0].name; })},
      {"a record is missing", Code::corrupt, with_info([](VolumeInfo& v) { v.channels.clear(); })},
      {"255 counts for 256 bins", Code::corrupt,
       with_info([](VolumeInfo& v) { v.channels[0].histogram.resize(255); })},
      {"percentiles do not rise", Code::corrupt, with_info([](VolumeInfo& v) {
         v.channels[0].percentiles = {{50, 1}, {40, 2}};
       })},
      {"percentiles do not rise", Code::corrupt, with_info([](VolumeInfo& v) {
         v.channels[0].percentiles = {{101, 1}};
       })},
      {"3 ranges for 9 frames", Code::corrupt,
       with_info([](VolumeInfo& v) { v.channels[0].frames.resize(3); })},
      {"range of a frame", Code::corrupt, with_info([](VolumeInfo& v) {
         v.channels[0].frames.assign(9, {2, 1});
       })},
      {"range from", Code::corrupt, with_info([](VolumeInfo& v) {
         v.channels[0].source_range = {NAN, 1};
       })},
      {"kept sites of", Code::corrupt,
       with_info([](VolumeInfo& v) { v.channels[0].sites_kept = UINT64_MAX; })},
      {"holes", Code::corrupt,
       with_info([](VolumeInfo& v) { v.channels[0].holes = v.channels[0].sites_kept + 1; })},
      {"code of air", Code::corrupt, with_metadata(damage_air_code)},
  });
  // Levels have the scale of their channel, which is no number of a type that is not known.
  const Edit unknown = with_info(
      [](VolumeInfo& v) { v.channels[0].type = static_cast<ValueType>(5), v.channels[0].scale = NAN; });
  expect_refused(rebuild(levels_file(), unknown), Code::corrupt, "unknown value type 5");
}

TEST(Bcc4Malformed, CorrectionsAndParts) {
  const Bytes file = part_with_corrections();
  EXPECT_NO_THROW(read_everything(file));
  const auto refused = [&](const char* text, const std::function<void(ChannelInfo&, PartInfo&)>& change) {
    SCOPED_TRACE(text);
    expect_refused(rebuild(file, with_info([&](VolumeInfo& v) { change(v.channels[0], *v.part); })),
                   Code::corrupt, text);
  };
  refused("corrections in steps of -1", [](ChannelInfo& c, PartInfo&) { c.residuals.step = -1; });
  refused("bound inf", [](ChannelInfo& c, PartInfo&) { c.residuals.bound = INFINITY; });
  refused("2 blocks for 3 frames", [](ChannelInfo& c, PartInfo&) { c.residuals.frames.pop_back(); });
  refused("corrections of 3 frames", [](ChannelInfo& c, PartInfo&) { c.residuals.step = 0; });
  refused("frames 1 .. 1", [](ChannelInfo&, PartInfo& p) { p.block.end[3] = 1; });
  refused("frames 1 .. 4", [](ChannelInfo&, PartInfo& p) { p.block.end[3] = 4; });
  refused("a write of", [](ChannelInfo&, PartInfo& p) { p.writes[0].trigger = 4; });
  refused("a write of channel 1", [](ChannelInfo&, PartInfo& p) { p.writes[0].channel = 1; });
  refused("a write of slab 1 of 1", [](ChannelInfo&, PartInfo& p) { p.writes[0].slab = 1; });
  refused("a write of", [](ChannelInfo&, PartInfo& p) { p.writes[0].frame = 3; });
  refused("a write of", [](ChannelInfo&, PartInfo& p) { p.writes[0].slab = -2; });
  refused("a write of", [](ChannelInfo&, PartInfo& p) {
    p.writes[0].slab = PartWrite::mask, p.writes[0].frame = PartWrite::chunks;
  });

  // Corrections are looked at when they are asked for, and when all is verified.
  const auto broken = [&](const char* text, const std::function<void(BlockRef&)>& change) {
    SCOPED_TRACE(text);
    const Bytes bad =
        rebuild(file, with_info([&](VolumeInfo& v) { change(v.channels[0].residuals.frames[1]); }));
    Bench bench;
    const auto reader = Bcc4Reader::open(open_memory_source(bad));
    EXPECT_NO_THROW(static_cast<void>(reader->residuals(0, 0)));
    EXPECT_THROW(static_cast<void>(reader->residuals(0, 1)), Error);
    const auto damage = reader->verify_all(bench.context).damage;
    ASSERT_FALSE(damage.empty());
    EXPECT_NE(damage[0].message.find(text), std::string::npos) << damage[0].message;
  };
  broken("bad checksum", [](BlockRef& r) { r.crc ^= 1; });
  broken("corrections", [](BlockRef& r) { r.offset = uint64_t{1} << 40; });
  broken("corrections", [](BlockRef& r) { r.offset += 4; });
  broken("corrections", [](BlockRef& r) { r.decoded = UINT32_MAX; });
}

// What a hostile writer may say of corrections in bricks.
TEST(Bcc4Malformed, BricksOfCorrections) {
  const Bytes file = file_with_bricks();
  EXPECT_NO_THROW(read_everything(file));
  const auto refused = [&](const char* text, const std::function<void(VolumeInfo&)>& change) {
    SCOPED_TRACE(text);
    expect_refused(rebuild(file, with_info(change)), Code::corrupt, text);
  };
  refused("corrections of shape 7",
          [](VolumeInfo& v) { v.channels[0].residuals.shape = static_cast<CorrectionShape>(7); });
  refused("corrections of a field above inf", [](VolumeInfo& v) { v.channels[0].residuals.base = INFINITY; });
  refused("corrections in steps of inf", [](VolumeInfo& v) { v.channels[0].residuals.step = INFINITY; });
  refused("1 blocks for 2 frames", [](VolumeInfo& v) { v.channels[0].residuals.tables.pop_back(); });
  refused("measured errors of channel 1", [](VolumeInfo& v) { v.errors[0].channel = 1; });
  refused("kind 3", [](VolumeInfo& v) { v.errors[0].kind = 3; });
  refused("a measured error is", [](VolumeInfo& v) { v.errors[0].rmse = -1; });
  refused("measured errors", [](VolumeInfo& v) { v.errors.push_back(v.errors[0]); });

  // A table with other entries, behind the file.
  Bench bench;
  const auto good = Bcc4Reader::open(open_memory_source(file));
  const std::vector<CorrectionBrick> table = good->correction_bricks(0, 1);
  ASSERT_EQ(table.size(), 2u);
  using Change = std::function<void(std::vector<CorrectionBrick>&)>;
  const auto broken = [&](const char* text, const Change& change, const Change& more = {}) {
    SCOPED_TRACE(text);
    std::vector<CorrectionBrick> other = table;
    change(other);
    if (more) more(other);
    ByteWriter decoded;
    write_correction_table(decoded, other);
    PackedBlock packed = pack_block(decoded.bytes());
    packed.ref.offset = file.size();
    Bytes longer = file;
    longer.insert(longer.end(), packed.bytes.begin(), packed.bytes.end());
    const Bytes bad =
        rebuild(longer, with_info([&](VolumeInfo& v) { v.channels[0].residuals.tables[1] = packed.ref; }));
    const auto damage = Bcc4Reader::open(open_memory_source(bad))->verify_all(bench.context).damage;
    ASSERT_FALSE(damage.empty());
    EXPECT_TRUE(std::any_of(damage.begin(), damage.end(), [&](const Bcc4Damage& d) {
      return d.message.find(text) != std::string::npos;
    })) << damage[0].message;
    // What is lost is left out when salvaging, and nothing else.
    const auto salvaged = Bcc4Reader::open(open_memory_source(bad), {.salvage = true});
    for (const CorrectionBrick& b : salvaged->correction_bricks(0, 1))
      EXPECT_NO_THROW(static_cast<void>(salvaged->corrections(0, b)));
  };
  broken("brick 2 of 2", [](auto& t) { t[1].brick = 2; });
  broken("do not rise", [](auto& t) { t[1].brick = 0; });
  broken("bounds nan", [](auto& t) { t[0].low = NAN; });
  broken("bounds -0.5 and inf", [](auto& t) { t[0].high = INFINITY; });
  broken("bounds", [](auto& t) { t[0].low = 2, t[0].high = 1; });
  broken("is not between the bounds", [](auto& t) { t[0].high = 0; });
  broken("the table says 7", [](auto& t) { t[0].count = 7; });
  broken("corrections in a brick", [](auto& t) { t[0].count = 0; });
  broken(
      "share the bytes", [](auto& t) { t[1].block = t[0].block; },
      [](auto& t) { t[1].low = t[0].low, t[1].high = t[0].high, t[1].count = t[0].count; });
  broken("bad checksum", [](auto& t) { t[0].block.crc ^= 1; });
  broken("corrections", [](auto& t) { t[0].block.offset += 4; });
  broken("corrections", [](auto& t) { t[0].block.offset = uint64_t{1} << 50; });

  // Voxels and counts of a brick.
  const auto voxels = [](std::initializer_list<uint64_t> at) {
    ResidualList list;
    for (const uint64_t v : at) list.push_back({v, 1});
    return list;
  };
  const CorrectionBricks bricks({66, 4, 5, 2});
  const auto check = [&](uint32_t brick, std::initializer_list<uint64_t> at) {
    CorrectionBrick entry;
    entry.brick = brick, entry.count = static_cast<uint32_t>(at.size()), entry.low = 0, entry.high = 1;
    check_corrections(bricks, entry, voxels(at), 0.25);
  };
  EXPECT_NO_THROW(check(1, {1, 64 * 3 + 1}));
  EXPECT_THROW(check(1, {2}), Error);           // x = 66
  EXPECT_THROW(check(0, {64 * 4}), Error);      // y = 4
  EXPECT_THROW(check(0, {64 * 64 * 5}), Error); // z = 5
  const auto bytes = write_corrections(voxels({0, 5, 262143}));
  EXPECT_EQ(read_corrections(bytes, 262144, 0), voxels({0, 5, 262143}));
  EXPECT_THROW((void)read_corrections(bytes, 262143, 0), Error);
  for (size_t n = 0; n < bytes.size(); ++n)
    EXPECT_THROW((void)read_corrections(std::span(bytes).first(n), 262144, 0), Error) << n;
}

// What a hostile writer may say of masks.
TEST(Bcc4Malformed, Masks) {
  const Bytes file = masked_file();
  EXPECT_NO_THROW(read_everything(file));
  expect_refused(rebuild(file, with_info([](VolumeInfo& v) { v.channels[0].masks.pop_back(); })),
                 Code::corrupt, "4 blocks for 5 frames");
  Bench bench;
  const auto broken = [&](const char* text, const std::function<void(BlockRef&)>& change) {
    SCOPED_TRACE(text);
    const Bytes bad = rebuild(file, with_info([&](VolumeInfo& v) { change(v.channels[1].masks[1]); }));
    const auto reader = Bcc4Reader::open(open_memory_source(bad));
    const auto ignore = [](uint64_t, uint64_t) {};
    EXPECT_NO_THROW(reader->mask_runs(1, 0, ignore));
    EXPECT_THROW(reader->mask_runs(1, 1, ignore), Error);
    const auto damage = reader->verify_all(bench.context).damage;
    ASSERT_FALSE(damage.empty());
    EXPECT_TRUE(std::any_of(damage.begin(), damage.end(), [&](const Bcc4Damage& d) {
      return d.message.find(text) != std::string::npos;
    })) << damage[0].message;
  };
  broken("channel other are missing, from frame 1", [](BlockRef& r) { r.crc ^= 1; });
  broken("mask", [](BlockRef& r) { r.offset = uint64_t{1} << 40; });
  broken("mask", [](BlockRef& r) { r.offset += 4; });
  broken("mask", [](BlockRef& r) { r.decoded = UINT32_MAX; });
  broken("mask", [](BlockRef& r) { r.coding = 2; });
}

TEST(Bcc4Malformed, MaskRuns) {
  const auto runs = [](std::initializer_list<int> bytes, uint64_t voxels) {
    std::vector<std::byte> list;
    for (const int v : bytes) list.push_back(static_cast<std::byte>(v));
    std::vector<std::pair<uint64_t, uint64_t>> found;
    read_mask_runs(list, voxels, 0, [&](uint64_t begin, uint64_t end) { found.emplace_back(begin, end); });
    return found;
  };
  EXPECT_EQ(runs({0, 3, 2, 1}, 6), (std::vector<std::pair<uint64_t, uint64_t>>{{0, 3}, {5, 6}}));
  EXPECT_THROW((void)runs({0, 3, 2, 1}, 5), Error); // beyond the frame
  EXPECT_THROW((void)runs({7, 1}, 6), Error);
  EXPECT_THROW((void)runs({0, 3, 0, 1}, 6), Error); // two that touch
  EXPECT_THROW((void)runs({0, 0}, 6), Error);       // an empty one
  EXPECT_THROW((void)runs({1}, 6), Error);          // cut short
  EXPECT_THROW((void)runs({}, 6), Error);
  EXPECT_THROW((void)runs({0, 0x81, 0x00}, 6), Error); // not the shortest form
  // Sums that wrap.
  EXPECT_THROW((void)runs({1, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x01}, 6), Error);
  // Runs that touch become one.
  MaskRunWriter writer;
  for (uint64_t v = 4; v < 9; ++v) writer.add(v, v + 1);
  writer.add(300, 301), writer.add(301, 301);
  EXPECT_EQ(writer.finish().size(), 5u);
  EXPECT_TRUE(writer.finish().empty());
}

TEST(Bcc4Malformed, DirectoryAndPages) {
  expect_each_refused({
      {"no whole number of records", Code::corrupt, with_directory([](Bytes& d) { d.resize(d.size() - 8); })},
      {"reserved bytes are not zero", Code::corrupt, with_directory([](Bytes& d) { d[60] = std::byte{1}; })},
      {"channel 2 of 2", Code::corrupt, with_pages([](auto& p) { p.back().channel = 2; })},
      {"pages do not rise", Code::corrupt, with_pages([](auto& p) { p.back().channel = 0; })},
      {"pages do not rise", Code::corrupt, with_pages([](auto& p) { std::swap(p[0], p[1]); })},
      {"a page of 0 entries", Code::corrupt, with_pages([](auto& p) { p[0].entries = 0; })},
      {"a page of 65537 entries", Code::corrupt, with_pages([](auto& p) { p[0].entries = 65537; })},
      {"a page from slab", Code::corrupt, with_pages([](auto& p) { p[0].last_slab = 2; })},
      {"a page from slab", Code::corrupt, with_pages([](auto& p) { p[0].first_slab = -1; })},
      {"a page from slab", Code::corrupt, with_pages([](auto& p) { p[0].last_slot = 1'000'000; })},
      {"do not lie in the file", Code::corrupt, with_pages([](auto& p) { p[0].block.offset = 1u << 30; })},
      {"first or last entry", Code::corrupt, with_pages([](auto& p) { ++p[0].first_slot; })},
      {"smallest or largest sample", Code::corrupt, with_pages([](auto& p) { ++p[0].max_code; })},
      {"index page", Code::checksum_mismatch, with_pages([](auto& p) { p[0].block.crc ^= 4; })},
      {"the directory says", Code::corrupt,
       with_page([](Bytes& p) { poke<uint32_t>(p, 0, peek<uint32_t>(p, 0) + 1); })},
      {"columns", Code::corrupt, with_page([](Bytes& p) { poke<uint32_t>(p, 4, UINT32_MAX); })},
      {"reserved bytes of column", Code::corrupt, with_page([](Bytes& p) { poke<uint8_t>(p, 8 + 3, 1); })},
      {"out of place or unknown", Code::unsupported_version,
       with_page([](Bytes& p) { poke<uint8_t>(p, 8, 14); })},
      {"out of place or unknown", Code::unsupported_version,
       with_page([](Bytes& p) { poke<uint8_t>(p, 9, 5); })},
      {"bytes too many", Code::corrupt, with_page([](Bytes& p) { p.resize(p.size() + 8); })},
      {"needs", Code::truncated, with_page([](Bytes& p) { p.resize(p.size() - 8); })},
      {"columns are missing", Code::corrupt, with_page([](Bytes& p) {
         const auto n = peek<uint32_t>(p, 0);
         poke<uint32_t>(p, 4, 12);
         p.erase(p.begin() + 8 + 48, p.begin() + 8 + 52);
         p.resize(p.size() - n);
       })},
  });
}

TEST(Bcc4Malformed, Entries) {
  Edit swapped;
  swapped.entries = [](std::vector<Bcc4Chunk>& e) { std::swap(e[0], e[1]); };
  // The page's first entry is not the first any more; the directory follows, so that order is what is wrong.
  swapped.pages = [](std::vector<PageRef>& p) {
    for (PageRef& r : p) std::tie(r.first_slab, r.first_slot) = std::pair(0, 0u);
  };
  Edit nowhere;
  nowhere.entries = [](std::vector<Bcc4Chunk>& e) { e.back().slot = 77; };
  nowhere.pages = [](std::vector<PageRef>& p) {
    for (PageRef& r : p) r.last_slot = 1;
  };
  expect_each_refused({
      {"entries do not rise", Code::corrupt, swapped},
      {"do not exist", Code::corrupt, nowhere},
      {"do not lie in the file", Code::corrupt,
       with_first_entry([](Bcc4Chunk& c) { c.offset += uint64_t{1} << 40; })},
      {"do not lie in the file", Code::corrupt, with_first_entry([](Bcc4Chunk& c) { c.offset = 0; })},
      {"do not lie in the file", Code::corrupt, with_first_entry([](Bcc4Chunk& c) { c.offset += 4; })},
      {"kept sites of", Code::corrupt, with_first_entry([](Bcc4Chunk& c) { c.kept = 0; })},
      {"kept sites of", Code::corrupt, with_first_entry([](Bcc4Chunk& c) { c.kept = 1'000'000; })},
      {"holes in", Code::corrupt, with_first_entry([](Bcc4Chunk& c) { c.holes = c.kept + 1; })},
      {"unknown coding", Code::corrupt, with_first_entry([](Bcc4Chunk& c) { c.coding = 2; })},
      {"unknown coding", Code::corrupt, with_first_entry([](Bcc4Chunk& c) { c.coding |= 32; })},
      {"unknown predictor 6", Code::corrupt, with_first_entry([](Bcc4Chunk& c) { c.predictor = 6; })},
      {"unknown predictor", Code::corrupt, with_first_entry([](Bcc4Chunk& c) { c.predictor |= 0x10; })},
      {"unknown predictor", Code::corrupt, with_first_entry([](Bcc4Chunk& c) { // raw values have none
         c.coding &= 0xf0, c.predictor = 1, c.values_bytes = c.kept;
       })},
      {"bytes of values", Code::corrupt, with_first_entry([](Bcc4Chunk& c) { c.values_bytes = c.kept; })},
      {"bytes of values", Code::corrupt,
       with_first_entry([](Bcc4Chunk& c) { c.coding &= 0xf0, c.predictor = 0; })},
      {"run lists of", Code::corrupt, with_first_entry([](Bcc4Chunk& c) { c.runs_decoded = UINT32_MAX; })},
      {"bytes of runs", Code::corrupt, with_first_entry([](Bcc4Chunk& c) { c.coding &= 0x0f; })},
      {"samples from code", Code::corrupt,
       with_first_entry([](Bcc4Chunk& c) { std::swap(c.min_code, c.max_code); })},
      {"samples from code", Code::corrupt,
       with_first_entry([](Bcc4Chunk& c) { c.max_code = 0xffff; })}, // no u8, a NaN
      {"bad checksum", Code::checksum_mismatch, with_first_entry([](Bcc4Chunk& c) { c.crc ^= 1; })},
  });
}

TEST(Bcc4Malformed, Chunks) {
  // Raw run lists in place of the file's own.
  const auto runs = [](Bcc4Chunk& c, Bytes& b, const auto& fill) {
    ByteWriter list;
    fill(list);
    b.resize(c.values_bytes);
    b.insert(b.end(), list.bytes().begin(), list.bytes().end());
    c.runs_bytes = c.runs_decoded = static_cast<uint32_t>(list.size());
    c.coding &= 0x0f;
  };
  expect_each_refused({
      {"no deflate stream", Code::corrupt, with_chunk([](Bcc4Chunk& c, Bytes& b) {
         b[c.values_bytes / 2] ^= std::byte{64}, b[0] = std::byte{7};
       })},
      {"padding is not zero", Code::corrupt, with_chunk([](Bcc4Chunk& c, Bytes& b) {
         // One byte less of runs: what was the last is padding now.
         --c.runs_bytes;
         b.back() = std::byte{9};
       })},
      {"the index says", Code::corrupt, with_chunk([](Bcc4Chunk& c, Bytes&) { --c.max_code; })},
      {"goes beyond", Code::corrupt, with_chunk([&](Bcc4Chunk& c, Bytes& b) {
         runs(c, b, [&](ByteWriter& w) { w.write_varint(0), w.write_varint(c.kept + 1); });
       })},
      {"not canonical", Code::corrupt, with_chunk([&](Bcc4Chunk& c, Bytes& b) {
         runs(c, b, [&](ByteWriter& w) {
           w.write_varint(0), w.write_varint(1), w.write_varint(0), w.write_varint(c.kept - 1);
         });
       })},
      {"needs", Code::truncated, with_chunk([&](Bcc4Chunk& c, Bytes& b) {
         runs(c, b, [&](ByteWriter& w) { w.write_varint(0), w.write_varint(c.kept - 1); });
       })},
      {"bytes too many", Code::corrupt, with_chunk([&](Bcc4Chunk& c, Bytes& b) {
         runs(c, b, [&](ByteWriter& w) {
           w.write_varint(0), w.write_varint(c.kept);
           if (c.holes > 0) w.write_varint(0), w.write_varint(c.holes);
           w.write_varint(5);
         });
       })},
  });
}

TEST(Bcc4Malformed, FittedWeightsAreBounded) {
  const Bytes file =
      write_file(volume(LatticeKind::d4star, {24, 24, 24, 10}, {channel("a", ValueType::u8)}), dense);
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  const auto chunks = reader->chunks(0, 0);
  ASSERT_EQ(chunks[0].predictor, 5);
  Edit edit;
  edit.chunk = [](Bcc4Chunk& c, Bytes& b) {
    if (c.slab != 0 || c.slot != 0) return;
    // 10 + 18 + 25 weights: layers without neighbours, with a cross layer, with both.
    Bytes decoded(2 * 53 + size_t{c.kept});
    ASSERT_TRUE(inflate_bytes(std::span(b).first(c.values_bytes), decoded));
    poke<int16_t>(decoded, 0, 32767), poke<int16_t>(decoded, 2, -32768);
    Bytes stream = deflate_bytes(decoded, 6, DeflateKind::noise);
    const Bytes tail(b.begin() + c.values_bytes, b.begin() + c.values_bytes + c.runs_bytes);
    c.values_bytes = static_cast<uint32_t>(stream.size());
    stream.insert(stream.end(), tail.begin(), tail.end());
    b = stream;
  };
  expect_refused(rebuild(file, edit), Code::corrupt, "weights sum to");
}

TEST(Bcc4Malformed, VerifyComparesSums) {
  const auto damage_of = [](const Edit& edit) {
    Bench bench;
    const Bytes file = rebuild(small_file(), edit);
    std::string all;
    for (const auto& d : Bcc4Reader::open(open_memory_source(file))->verify_all(bench.context).damage)
      all += d.message + "\n";
    return all;
  };
  EXPECT_EQ(damage_of({}), "");
  EXPECT_NE(damage_of(with_root([](Root& r) { --r.runs_bytes; })).find("sums of bytes"), std::string::npos);
  EXPECT_NE(damage_of(with_info([](VolumeInfo& v) { --v.channels[0].sites_kept; })).find("counts or range"),
            std::string::npos);
  EXPECT_NE(
      damage_of(with_info([](VolumeInfo& v) { v.channels[1].kept_range.high += 1; })).find("counts or range"),
      std::string::npos);
}

TEST(Bcc4Malformed, TwoChunksDoNotShareBytes) {
  const Bytes file =
      write_file(volume(LatticeKind::cc, {32, 16, 16, 1}, {channel("a", ValueType::u8)}), dense);
  Edit shared;
  shared.entries = [](std::vector<Bcc4Chunk>& e) { e[1] = e[0], e[1].slot = 1; };
  Bench bench;
  const auto result = Bcc4Reader::open(open_memory_source(rebuild(file, shared)))->verify_all(bench.context);
  ASSERT_FALSE(result.damage.empty());
  EXPECT_NE(result.damage[0].message.find("share the bytes"), std::string::npos);
}

} // namespace
} // namespace bccsplat
