// SPDX-License-Identifier: Apache-2.0
// Files that are seen while they are written: the root that is replaced, pages that grow, and what a hostile
// root says.
#include <gtest/gtest.h>

#include "formats/bcc4/layout.h"
#include "tests/unit/formats/rebuild.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

using namespace test;

std::string refusal(const Bytes& file, Code code) {
  try {
    static_cast<void>(Bcc4Reader::open(open_memory_source(file)));
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), code) << e.message();
    return e.message();
  }
  return "it was read";
}

uint64_t damages(const std::shared_ptr<Bcc4Reader>& reader) {
  Bench bench;
  const auto result = reader->verify_all(bench.context);
  for (const Bcc4Damage& d : result.damage) ADD_FAILURE() << d.message;
  return result.damage.size();
}

// A crash while the root was being replaced, after any of its bytes; where nothing came behind the state.
TEST(Bcc4Unfinished, ARootThatIsTornIsReadFromItsCopy) {
  const Bytes file = unfinished_file();
  const auto newest = Bcc4Reader::open(open_memory_source(file));
  EXPECT_EQ(newest->info().lattice.layers(), 16);
  EXPECT_EQ(damages(newest), 0u);
  for (const size_t at : {0u, 12u, 40u, 127u}) {
    Bytes torn = file;
    torn[root_offset + at] ^= std::byte{8};
    Bytes went_on = torn;
    went_on.insert(went_on.end(), 8, std::byte{1});
    EXPECT_NE(refusal(went_on, Code::checksum_mismatch).find("no valid root record"), std::string::npos);
    const auto reader = Bcc4Reader::open(open_memory_source(torn));
    EXPECT_TRUE(reader->root_damaged());
    EXPECT_EQ(reader->info(), newest->info());
    Bench bench;
    const auto found = reader->verify_all(bench.context);
    ASSERT_EQ(found.damage.size(), 1u);
    EXPECT_NE(found.damage[0].message.find("a copy of it is read"), std::string::npos);
    torn[torn.size() - 1] ^= std::byte{1}; // and the copy
    EXPECT_NE(refusal(torn, Code::checksum_mismatch).find("no valid root record"), std::string::npos);
  }
  // What a writer put behind the head is no copy where it says another size.
  Bytes moved = file;
  const Bytes copy(moved.end() - root_bytes, moved.end());
  moved[root_offset] ^= std::byte{1};
  moved.insert(moved.end(), copy.begin(), copy.end());
  EXPECT_NE(refusal(moved, Code::checksum_mismatch).find("no valid root record"), std::string::npos);
}

TEST(Bcc4Unfinished, FewerFramesMayBeShownThanTheSeriesHas) {
  const Bytes file = rebuild(unfinished_file(), {.metadata =
                                                     [](Bytes& m) {
                                                       VolumeInfo v = read_metadata(m, 0, {});
                                                       v.time.uniform = false;
                                                       for (int i = 0; i < 11; ++i)
                                                         v.time.times.push_back(i * i);
                                                       for (ChannelInfo& c : v.channels) c.frames.resize(11);
                                                       m = write_metadata(v);
                                                     },
                                                 .root = [](Root& r) { r.frames = 3; }});
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  EXPECT_EQ(reader->info().lattice.dims[3], 3u);
  EXPECT_EQ(reader->info().lattice.layers(), 16); // the others are there for kernels
  EXPECT_EQ(reader->info().time.times, (std::vector<double>{0, 1, 4}));
  EXPECT_EQ(reader->info().channels[1].frames.size(), 3u);
  EXPECT_EQ(damages(reader), 0u);
}

TEST(Bcc4Unfinished, HostileRootsAreRefusedByName) {
  const Bytes good = unfinished_file();
  EXPECT_NE(refusal(rebuild(good, {.root = [](Root& r) { r.frames = 12; }}), Code::corrupt)
                .find("12 frames can be looked at, the series has 11"),
            std::string::npos);
  EXPECT_NE(refusal(rebuild(good, {.root = [](Root& r) { r.frames = 0; }}), Code::checksum_mismatch)
                .find("0 frames of an unfinished series"),
            std::string::npos);
  EXPECT_NE(refusal(rebuild(good, {.root = [](Root& r) { r.unfinished = false; }}), Code::checksum_mismatch)
                .find("11 frames of a finished series"),
            std::string::npos);
  Bytes bad = good;
  bad.resize(bad.size() + 8); // its copy of the root is none any more
  poke<uint32_t>(bad, root_offset + 104, 2);
  poke<uint32_t>(bad, root_offset + 124, crc32_of(std::span(bad).subspan(root_offset, 124)));
  EXPECT_NE(refusal(bad, Code::checksum_mismatch).find("unknown state 2"), std::string::npos);
}

// Showing every slab costs little: pages are merged as they grow.
TEST(Bcc4Unfinished, WhatIsLeftBehindStaysSmall) {
  VolumeInfo info = volume(LatticeKind::d4star, {90, 90, 90, 90}, {channel("a", ValueType::u8)});
  info.slab_layers = 1;
  std::vector<BrickLayer> layers;
  for (int coset = 0; coset < 2; ++coset) {
    BrickLayer& layer = layers.emplace_back(info.lattice.space, coset);
    for (size_t s = 0; s < layer.brick_slots(); ++s) {
      auto brick = std::make_shared<Brick>();
      brick->value[s % brick_sites] = 1, brick->keep_above(0);
      if (brick->count() > 0) layer.set(s, std::move(brick));
    }
  }
  Bench bench;
  const auto write = [&](bool shows) {
    std::vector<std::byte> bytes;
    Bcc4Writer writer(create_memory_sink(bytes), info);
    for (int32_t s = 0; s < info.slabs(); ++s) {
      writer.write_slab(s, 0, std::span(&layers[s % 2], 1), bench.context);
      if (shows && s > 2 && s + 1 < info.slabs()) writer.show(first_slabs(info, s + 1), bench.context);
    }
    return writer.finish(bench.context);
  };
  const Bcc4Report plain = write(false), shown = write(true);
  EXPECT_GT(plain.chunks, page_entries); // a full page, and one that is not
  EXPECT_EQ(plain.bytes.unused, 0u);
  // Chunks are further apart, which takes a few bytes to tell.
  const auto index = static_cast<double>(plain.bytes.index);
  EXPECT_NEAR(static_cast<double>(shown.bytes.index), index, 0.01 * index);
  // Merging halves leaves behind each entry once for each doubling, where writing a page anew would for each
  // state; a state has a directory and metadata besides.
  const uint64_t states = info.slabs() - 4;
  EXPECT_LT(shown.bytes.unused, 3 * plain.bytes.index + 1024 * states);
}

} // namespace
} // namespace bccsplat
