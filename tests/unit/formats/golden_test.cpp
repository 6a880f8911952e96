// SPDX-License-Identifier: Apache-2.0
// Files of every released version stay readable: samples and account as the second reader printed them when
// the file was made (tests/spec_reader), bad files refused with the code they were made for.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

#include "base/bytes.h"
#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/deflate.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

using namespace test;

const std::filesystem::path folder = BCCSPLAT_GOLDEN_DIR;

std::shared_ptr<Bcc4Reader> open(const std::string& name) {
  return Bcc4Reader::open(open_file_source((folder / (name + ".bcc4")).string()));
}

std::vector<std::string> names(const std::string& prefix) {
  std::vector<std::string> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".bcc4" && entry.path().stem().string().starts_with(prefix))
      found.push_back(entry.path().stem().string());
  return found;
}

void write_samples(ByteWriter& out, const ResidualList& list) {
  for (const ResidualSample& s : list) out.write(s.voxel), out.write(s.steps);
}

// The lines `corrections` of the second reader.
std::string describe_corrections(const Bcc4Reader& reader, int channel) {
  const ResidualInfo& info = reader.info().channels[channel].residuals;
  if (info == ResidualInfo{}) return "";
  std::string text = concat("corrections step ", info.step, " bound ", info.bound, " shape ",
                            info.local ? static_cast<int>(info.shape) : -1);
  text += info.base ? concat(" base ", static_cast<double>(*info.base), "\n") : "\n";
  for (uint32_t f = 0; f < reader.info().lattice.dims[3]; ++f) {
    ByteWriter all;
    size_t added = 0;
    for (const CorrectionBrick& brick : reader.correction_bricks(channel, f)) {
      const auto list = reader.corrections(channel, brick);
      all.write(uint64_t{brick.brick});
      write_samples(all, list);
      added += list.size();
    }
    const FrameResiduals whole = reader.residuals(channel, f);
    write_samples(all, whole.add), write_samples(all, whole.set);
    char crc[16];
    std::snprintf(crc, sizeof crc, "%08x", crc32_of(all.bytes()));
    text += concat("corrections frame ", f, " add ", added + whole.add.size(), " set ", whole.set.size(),
                   " crc ", crc, "\n");
  }
  return text;
}

// The lines `mask` of the second reader.
std::string describe_masks(const Bcc4Reader& reader, int channel) {
  const auto& n = reader.info().lattice.dims;
  std::string text;
  for (uint32_t f = 0; f < reader.info().channels[channel].masks.size(); ++f) {
    std::vector<std::byte> missing(size_t{n[0]} * n[1] * n[2]);
    uint64_t count = 0;
    reader.mask_runs(channel, f, [&](uint64_t begin, uint64_t end) {
      std::fill(missing.begin() + begin, missing.begin() + end, std::byte{1});
      count += end - begin;
    });
    char crc[16];
    std::snprintf(crc, sizeof crc, " crc %08x", crc32_of(missing));
    text += concat("mask frame ", f, " missing ", count, count > 0 ? crc : "", "\n");
  }
  return text;
}

// The lines `layer` of the second reader, of a channel of a level.
std::string describe_layers(const std::vector<BrickLayer>& layers, const std::string& name) {
  std::string text;
  for (size_t m = 0; m < layers.size(); ++m) {
    const BrickLayer& layer = layers[m];
    const Int3 n = layer.dims();
    ByteWriter bytes;
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x) {
          const Brick* b = layer.brick(x / 16, y / 16, z / 16);
          const int site = (z % 16 * 16 + y % 16) * 16 + x % 16;
          const bool kept = b && b->kept[site / 16] >> (site % 16) & 1;
          bytes.write(static_cast<uint8_t>(!kept ? 0 : b->is_hole(site) ? 2 : 1));
          bytes.write(layer.value(x, y, z));
        }
    char crc[16];
    std::snprintf(crc, sizeof crc, "%08x", crc32_of(bytes.bytes()));
    text += concat(name, "layer ", m, " sites ", n[0], " ", n[1], " ", n[2], " crc ", crc, "\n");
  }
  return text;
}

// The lines `axis` and `coordinate` of the second reader.
std::string describe_axes(const VolumeInfo& info) {
  std::string text;
  for (size_t a = 0; a < 3 && info.has_uneven_axes(); ++a) {
    const AxisInfo& axis = info.axes[a];
    text += concat("axis ", "xyz"[a], " unit '", axis.unit, "'", axis.down ? " down" : "", " coordinates ",
                   axis.coordinates.size(), "\n");
    for (const double c : axis.coordinates) text += concat("coordinate ", c, "\n");
  }
  return text;
}

// The lines `axis`, `channel`, `layer`, `level`, `corrections` and `mask` of the second reader.
std::string describe(const std::shared_ptr<Bcc4Reader>& reader) {
  Bench bench;
  std::vector<Layers> all;
  for (int l = 0; l < reader->info().level_count(); ++l) all.push_back(read_all(reader, bench, l));
  std::string text = describe_axes(reader->info());
  for (size_t c = 0; c < all[0].size(); ++c) {
    const ChannelInfo& info = reader->info().channels[c];
    char air[32];
    std::snprintf(air, sizeof air, "%.9g", static_cast<double>(info.air));
    text += concat("channel ", c, " ", info.name, " type ", static_cast<int>(info.type), " air ", air,
                   " kept ", info.sites_kept, " holes ", info.holes, "\n");
    text += describe_layers(all[0][c], "");
    for (size_t l = 1; l < all.size(); ++l) {
      const LevelChannel& level = reader->info().levels[l - 1].channels[c];
      text += concat("level ", l, " channel ", c, " kept ", level.sites_kept, " holes ", level.holes, "\n");
      text += describe_layers(all[l][c], concat("level ", l, " "));
    }
    text += describe_corrections(*reader, static_cast<int>(c));
    text += describe_masks(*reader, static_cast<int>(c));
    if (info.sums)
      text += concat("sums corrected ", info.sums->corrections, " missing ", info.sums->missing, "\n");
  }
  return text;
}

TEST(Bcc4Golden, GoodFilesHoldTheirSamples) {
  const auto files = names("v");
  EXPECT_GE(files.size(), 20u);
  for (const std::string& name : files) {
    std::ifstream in(folder / (name + ".txt"));
    ASSERT_TRUE(in) << name;
    std::string expected, line;
    while (std::getline(in, line))
      if (line.starts_with("axis ") || line.starts_with("coordinate ") || line.starts_with("channel ") ||
          line.starts_with("layer ") || line.starts_with("level ") || line.starts_with("corrections ") ||
          line.starts_with("mask ") || line.starts_with("sums "))
        expected += line + "\n";
    EXPECT_EQ(describe(open(name)), expected) << name;
  }
}

TEST(Bcc4Golden, GoodFilesVerify) {
  Bench bench;
  for (const std::string& name : names("v")) {
    const auto result = open(name)->verify_all(bench.context);
    EXPECT_GT(result.chunks, 0u) << name;
    for (const auto& d : result.damage) ADD_FAILURE() << name << ": " << d.message;
  }
}

TEST(Bcc4Golden, GoodFilesUseEverythingTheFormatHas) {
  std::set<int> types, predictors, value_codings, run_codings, kinds, depths;
  for (const std::string& name : names("v")) {
    const auto reader = open(name);
    const VolumeInfo& info = reader->info();
    kinds.insert(static_cast<int>(info.lattice.kind));
    depths.insert(info.slab_layers);
    for (size_t c = 0; c < info.channels.size(); ++c) {
      types.insert(static_cast<int>(info.channels[c].type));
      for (int32_t s = 0; s < info.slabs(); ++s)
        for (const Bcc4Chunk& chunk : reader->chunks(static_cast<int>(c), s)) {
          predictors.insert(chunk.predictor);
          value_codings.insert(chunk.coding & 15), run_codings.insert(chunk.coding >> 4);
        }
    }
  }
  EXPECT_EQ(types, (std::set<int>{1, 2, 3, 4}));
  EXPECT_EQ(predictors, (std::set<int>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(value_codings, (std::set<int>{0, 1, 2}));
  EXPECT_EQ(run_codings, (std::set<int>{0, 1}));
  EXPECT_EQ(kinds, (std::set<int>{1, 2, 3}));
  EXPECT_EQ(depths, (std::set<int>{3, 4, 6, 8}));
}

TEST(Bcc4Golden, TilesHaveEveryBasisOfTimeAndEdges) {
  std::set<int> bases, edges, kinds;
  for (const std::string& name : names("v5_tiles")) {
    const auto reader = open(name);
    std::ifstream file(folder / (name + ".bcc4"), std::ios::binary);
    edges.insert(reader->info().tile_edge);
    kinds.insert(static_cast<int>(reader->info().lattice.kind));
    for (const Bcc4Chunk& chunk : reader->chunks(0, 0)) {
      constexpr int basis = 9; // of a tile's head
      file.seekg(static_cast<std::streamoff>(chunk.offset) + basis);
      bases.insert(file.get());
    }
  }
  EXPECT_EQ(bases, (std::set<int>{0, 1}));
  EXPECT_EQ(edges, (std::set<int>{2, 4, 8}));
  EXPECT_EQ(kinds, (std::set<int>{1, 3}));
}

TEST(Bcc4Golden, DomainsHavePlanesOutside) {
  const Lattice4 lattice = open("v5_domain")->info().lattice;
  EXPECT_EQ(lattice.before, (Int3{4, 0, 2}));
  EXPECT_EQ(lattice.behind, (Int3{4, 0, 2}));
  EXPECT_EQ(lattice.lead, 4);
  EXPECT_NEAR(lattice.plane_position(2, lattice.space.last[2] - 2), 19, 1e-9);
}

TEST(Bcc4Golden, PeriodicSeriesGoRound) {
  const Lattice4 lattice = open("v5_periodic")->info().lattice;
  EXPECT_TRUE(lattice.periodic);
  EXPECT_FALSE(open("v5_domain")->info().lattice.periodic);
  EXPECT_EQ(lattice.layers(), 10);
  EXPECT_NEAR(lattice.layer_frame(lattice.layers()), 6, 1e-9);
  EXPECT_EQ(lattice.mirror_layer(-1), 9);
}

TEST(Bcc4Golden, PeriodicAxesGoRound) {
  const Lattice4 lattice = open("v5_periodic_axis")->info().lattice;
  EXPECT_TRUE(lattice.turns(0));
  EXPECT_FALSE(lattice.turns(1) || lattice.turns(2) || lattice.turns(3));
  EXPECT_EQ(lattice.space.planes(0), 20);
  EXPECT_EQ(lattice.domain_end(0), 14);
  EXPECT_NEAR(lattice.plane_position(0, 20), 14, 1e-9);
  EXPECT_EQ(lattice.space.mirror(0, 1, -1), 9);
}

TEST(Bcc4Golden, CorrectionsAndWhatWasMeasured) {
  const auto reader = open("v5_corrections");
  const VolumeInfo& info = reader->info();
  EXPECT_EQ(info.channels[0].residuals.shape, CorrectionShape::smooth);
  const auto bricks = reader->correction_bricks(0, 0);
  ASSERT_EQ(bricks.size(), 3u); // x on both sides of 64, and the far corner
  EXPECT_EQ(bricks[0].low, -7.5f);
  EXPECT_EQ(bricks[0].high, 8.25f);
  EXPECT_EQ(bricks[2].brick, 3u);
  EXPECT_TRUE(reader->correction_bricks(0, 1).empty());
  EXPECT_EQ(reader->residuals(0, 2).set.size(), 1u);
  ASSERT_EQ(info.errors.size(), 2u);
  EXPECT_EQ(info.errors[1].kind, MeasuredError::corrected);
  EXPECT_EQ(info.errors[1].rmse, 0.25);
}

TEST(Bcc4Golden, FramesThatMissTheSameShareAMask) {
  const auto reader = open("v5_masks");
  const auto& a = reader->info().channels[0].masks;
  const auto& b = reader->info().channels[1].masks;
  ASSERT_EQ(a.size(), 5u);
  for (const size_t f : {0u, 1u, 2u, 3u}) EXPECT_EQ(a[f], a[0]);
  EXPECT_EQ(a[4].stored, 0u);
  EXPECT_EQ(b[0], a[0]); // channels share them, too
  EXPECT_NE(b[1].offset, a[0].offset);
  EXPECT_EQ(b[2].stored, 0u);
}

TEST(Bcc4Golden, ASeriesUnderWay) {
  const auto reader = open("v5_unfinished");
  const VolumeInfo& info = reader->info();
  EXPECT_TRUE(info.unfinished);
  EXPECT_EQ(info.expected_frames, 30u);
  EXPECT_EQ(info.lattice.layers(), 16);
  EXPECT_EQ(info.lattice.dims[3], 11u);
}

TEST(Bcc4Golden, UnevenTimes) {
  const TimeMap t = open("v5_d4star_f32_uneven_times")->info().time;
  EXPECT_FALSE(t.uniform);
  EXPECT_EQ(t.times, (std::vector<double>{0, 6, 12, 24, 36.5}));
  EXPECT_EQ(t.unit, "h");
}

TEST(Bcc4Golden, BadFilesAreRefused) {
  const std::map<std::string, Code> expected = {{"bad_truncated", Code::truncated},
                                                {"bad_coordinates_count", Code::corrupt},
                                                {"bad_coordinates_fall", Code::corrupt},
                                                {"bad_coordinates_flags", Code::corrupt},
                                                {"bad_coordinates_nan", Code::corrupt},
                                                {"bad_corrections_base", Code::corrupt},
                                                {"bad_seven_bits", Code::corrupt},
                                                {"bad_text_mode", Code::corrupt},
                                                {"bad_newer_version", Code::unsupported_version},
                                                {"bad_older_version", Code::unsupported_version},
                                                {"bad_root", Code::checksum_mismatch},
                                                {"bad_metadata", Code::checksum_mismatch},
                                                {"bad_directory", Code::checksum_mismatch},
                                                {"bad_header", Code::corrupt},
                                                {"bad_chunk", Code::checksum_mismatch},
                                                {"bad_run_list", Code::corrupt},
                                                {"bad_domain_end", Code::corrupt},
                                                {"bad_domain_periodic", Code::corrupt},
                                                {"bad_domain_odd", Code::corrupt},
                                                {"bad_periodic_axis_odd", Code::corrupt},
                                                {"bad_periodic_axis_outside", Code::corrupt},
                                                {"bad_periodic_axis_turn", Code::corrupt},
                                                {"bad_periodic_one_end", Code::corrupt},
                                                {"bad_periodic_turn", Code::corrupt},
                                                {"bad_domain_planes", Code::corrupt},
                                                {"bad_domain_lead", Code::corrupt},
                                                {"bad_masks_frames", Code::corrupt},
                                                {"bad_mask_beyond", Code::corrupt},
                                                {"bad_mask_pair", Code::corrupt},
                                                {"bad_sums", Code::corrupt},
                                                {"bad_mask_cut", Code::truncated},
                                                {"bad_counts", Code::corrupt},
                                                {"bad_corrections_shape", Code::corrupt},
                                                {"bad_unfinished_frames", Code::corrupt},
                                                {"bad_finished_frames", Code::checksum_mismatch},
                                                {"bad_root_state", Code::checksum_mismatch},
                                                {"bad_level_planes", Code::corrupt},
                                                {"bad_tiles_basis", Code::corrupt},
                                                {"bad_tiles_coding", Code::corrupt},
                                                {"bad_tiles_cut", Code::truncated},
                                                {"bad_tiles_edge", Code::corrupt},
                                                {"bad_tiles_flags_of_samples", Code::corrupt},
                                                {"bad_tiles_halvings", Code::corrupt},
                                                {"bad_tiles_no_error", Code::corrupt},
                                                {"bad_tiles_no_step", Code::corrupt},
                                                {"bad_tiles_of_floats", Code::corrupt},
                                                {"bad_tiles_slot", Code::corrupt},
                                                {"bad_tiles_step_large", Code::corrupt},
                                                {"bad_tiles_step_nan", Code::corrupt},
                                                {"bad_level_of_page", Code::corrupt},
                                                {"bad_level_scale", Code::corrupt},
                                                {"bad_predictor", Code::corrupt},
                                                {"bad_value_type", Code::corrupt}};
  std::set<std::string> seen;
  for (const std::string& name : names("bad")) {
    seen.insert(name);
    ASSERT_TRUE(expected.contains(name)) << name;
    try {
      const auto reader = open(name);
      static_cast<void>(describe(reader));
      ADD_FAILURE() << name << " was read";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), expected.at(name)) << name << ": " << e.message();
    }
  }
  EXPECT_EQ(seen.size(), expected.size());
}

} // namespace
} // namespace bccsplat
