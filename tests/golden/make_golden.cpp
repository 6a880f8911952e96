// SPDX-License-Identifier: Apache-2.0
// Makes the golden files of the format version of the day: make_golden FOLDER. Files of a released version
// are never made again; a new version gets new files beside them. v5_site_holes and v5_site_holes_longer were
// made by a writer that knew no masks.
#include <gtest/gtest.h> // for the helpers

#include <cstdio>
#include <limits>
#include <string>

#include "tests/unit/formats/rebuild.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat::test {
namespace {

std::string folder;

void save(const std::string& name, const Bytes& bytes) {
  const auto sink = create_file_sink(folder + "/" + name + ".bcc4", false);
  sink->write_at(0, bytes);
  sink->commit();
}

// A ramp of 16 bits that no predictor but the lattice's own neighbours foresees.
Sample bumpy(int c, double x, double y, double z, double t) {
  Sample s = ball(c, x, y, z, t);
  s.value =
      static_cast<float>(s.value + 3 * std::sin(2.1 * x) * std::cos(1.7 * y + z) + (s.kept ? 0.01 * t : 0));
  return s;
}

// Rows that have nothing to do with each other.
Sample rows(int, double x, double y, double z, double t) {
  const double noise = std::sin(12.9898 * y + 78.233 * z + 37.719 * t) * 43758.5453;
  return {static_cast<float>(100 * (noise - std::floor(noise)) + x), z < 9, false};
}

// On the lattice of 9^3 x 4 samples: noise on coset 0, on coset 1 the mean of the neighbours in the layer
// before.
Sample means(int, double x, double y, double z, double t) {
  const auto plane = [](double p) { return static_cast<int>(std::lround(p / (8.0 / 12))); };
  const auto noise = [](int i, int j, int k, int m) {
    const double v = std::sin(12.9898 * i + 78.233 * j + 37.719 * k + 5.31 * m) * 43758.5453;
    return 100 + 20 * (v - std::floor(v));
  };
  const int i = plane(x), j = plane(y), k = plane(z), m = static_cast<int>(std::lround(t * std::sqrt(2.0)));
  if (m % 2 == 0) return {static_cast<float>(noise(i, j, k, m)), true, false};
  double sum = 0;
  for (int n = 0; n < 8; ++n)
    sum += noise(i - 1 + 2 * (n & 1), j - 1 + 2 * (n >> 1 & 1), k - 1 + 2 * (n >> 2), m - 1);
  return {static_cast<float>(sum / 8), true, false};
}

// A file of tiles; their steps allow that error.
VolumeInfo tiles(LatticeKind kind, const std::array<uint32_t, 4>& dims, ChannelInfo channel, int edge) {
  channel.wavelet_error = channel.type == ValueType::u8 ? 1.5 : 0.2;
  VolumeInfo info = volume(kind, dims, {std::move(channel)});
  info.tile_edge = edge, info.slab_layers = 6;
  return info;
}

// Two patterns in turn, which cosines of time take many of and a matrix two.
Sample in_turn(int, double x, double y, double z, double t) {
  const bool odd = std::lround(t) % 2 == 1;
  const double v = std::sin((odd ? 1.9 : 1.1) * x + 0.7 * y) * std::cos((odd ? 0.4 : 1.6) * z);
  return {static_cast<float>(100 + 80 * v), true, false};
}

Bytes tile_levels() {
  VolumeInfo info = levels_info();
  info.tile_edge = 2;
  for (LevelInfo& level : info.levels) level.tile_edge = 2;
  for (ChannelInfo& c : info.channels) c.type = ValueType::u8, c.wavelet_error = 1;
  Bytes bytes;
  Bench bench;
  Bcc4Writer writer(create_memory_sink(bytes), info);
  write_levels(writer, info, ball, bench);
  writer.finish(bench.context);
  return bytes;
}

// What a tile may not say: its head is step, centres, halvings, basis.
void make_bad_tiles() {
  const Bytes good =
      write_file(tiles(LatticeKind::cc, {20, 18, 17, 6}, channel("value", ValueType::u8), 2), dense);
  constexpr size_t step = 0, halvings = 6, basis = 9;
  const auto poked = [&](const std::string& name, size_t at, auto value) {
    save(name, rebuild(good, {.chunk = [at, value](Bcc4Chunk&, Bytes& b) { poke(b, at, value); }}));
  };
  poked("bad_tiles_no_step", step, 0.F);
  poked("bad_tiles_step_nan", step, std::numeric_limits<float>::quiet_NaN());
  poked("bad_tiles_step_large", step, 3e7F);
  poked("bad_tiles_halvings", halvings + 1, uint8_t{6});
  poked("bad_tiles_basis", basis, uint8_t{2});
  save("bad_tiles_cut", rebuild(good, {.chunk = [](Bcc4Chunk& c, Bytes& b) {
                                  constexpr size_t left = 8; // of the head
                                  b.erase(b.begin() + left, b.begin() + c.values_bytes);
                                  c.values_bytes = left;
                                  b.resize(left + c.runs_bytes);
                                }}));
  save("bad_tiles_coding", rebuild(good, {.entries = [](std::vector<Bcc4Chunk>& e) {
                                     e[0].coding = static_cast<uint8_t>((e[0].coding & 0xf0) | 1);
                                   }}));
  save("bad_tiles_slot", rebuild(good, {.entries = [](std::vector<Bcc4Chunk>& e) { e.back().slot = 90; }}));
  const auto info = [&](const std::string& name, const std::function<void(VolumeInfo&)>& change) {
    save(name, rebuild(good, with_info(change)));
  };
  info("bad_tiles_edge", [](VolumeInfo& v) { v.tile_edge = 3; });
  info("bad_tiles_no_error", [](VolumeInfo& v) { v.channels[0].wavelet_error = 0; });
  info("bad_tiles_flags_of_samples", [](VolumeInfo& v) { v.channels[0].linear = true, v.tile_edge = 1; });
  info("bad_tiles_of_floats", [](VolumeInfo& v) {
    v.channels[0].type = ValueType::f32, v.channels[0].scale = 1, v.channels[0].offset = v.channels[0].air;
  });
}

// What a writer that goes on cannot see in a file of tiles.
void make_counts() {
  VolumeInfo info = tiles(LatticeKind::d4star, {12, 11, 10, 6}, channel("value", ValueType::u8), 2);
  info.counts = CountsInfo{1, {std::byte{1}, std::byte{2}, std::byte{3}}};
  const Bytes good = write_file(info, dense);
  save("v5_tiles_counts", good);
  save("bad_counts", rebuild(good, with_info([](VolumeInfo& v) {
                               v.counts = CountsInfo{v.slabs() + 1, {}};
                             })));
}

void make_tiles() {
  save("v5_tiles_matrix",
       write_file(tiles(LatticeKind::cc, {36, 34, 17, 8}, channel("value", ValueType::u8), 2), in_turn));
  save("v5_tiles_edge_8",
       write_file(tiles(LatticeKind::d4star, {70, 20, 18, 7}, channel("value", ValueType::u16, 2), 8), ball));
  save("v5_tiles_levels", tile_levels());
  make_bad_tiles();
  make_counts();
  ChannelInfo linear = channel("value", ValueType::u16, 5);
  linear.linear = true;
  save("v5_tiles_linear", write_file(tiles(LatticeKind::cc, {40, 35, 20, 8}, std::move(linear), 2), ball));
  save("v5_tiles_cc_u16",
       write_file(tiles(LatticeKind::cc, {41, 35, 20, 8}, channel("value", ValueType::u16, 5), 2), ball));
  save("v5_tiles_d4star_u8",
       write_file(tiles(LatticeKind::d4star, {40, 30, 26, 9}, channel("value", ValueType::u8), 4), dense));
}

void make_good() {
  const std::array<uint32_t, 4> dims{22, 20, 18, 8}, still{26, 24, 25, 1};
  save("v5_d4star_u8",
       write_file(volume(LatticeKind::d4star, dims, {channel("value", ValueType::u8)}), ball_without_holes));
  save("v5_d4star_u16_holes",
       write_file(volume(LatticeKind::d4star, dims, {channel("value", ValueType::u16, 5)}), ball));
  save(
      "v5_d4star_f16",
      write_file(volume(LatticeKind::d4star, {18, 20, 18, 4}, {channel("value", ValueType::f16, -2)}), ball));
  VolumeInfo uneven = volume(LatticeKind::d4star, {14, 18, 16, 5}, {channel("value", ValueType::f32)});
  uneven.time.uniform = false;
  uneven.time.times = {0, 6, 12, 24, 36.5};
  uneven.time.unit = "h";
  save("v5_d4star_f32_uneven_times", write_file(uneven, ball));
  save("v5_bcc_u8", write_file(volume(LatticeKind::bcc, still, {channel("value", ValueType::u8)}), ball));
  save("v5_bcc_u16_dense",
       write_file(volume(LatticeKind::bcc, {23, 23, 23, 1}, {channel("value", ValueType::u16)}), dense));
  save("v5_cc_u16",
       write_file(volume(LatticeKind::cc, {17, 18, 16, 6}, {channel("value", ValueType::u16)}), bumpy));
  save("v5_cc_f32_static",
       write_file(volume(LatticeKind::cc, {19, 16, 12, 1}, {channel("value", ValueType::f32, 1)}), ball));
  ChannelInfo half_values = channel("half", ValueType::f16, 3);
  half_values.offset = 0;
  VolumeInfo two =
      volume(LatticeKind::d4star, {18, 17, 16, 5}, {channel("density", ValueType::u16), half_values});
  two.slab_layers = 3;
  two.attributes = {{"title", "two channels"}, {"Autor", "Bücher & Söhne"}};
  two.recommended_kernel = "radial20+b3";
  two.affine.linear[0][0] = 0.5, two.affine.offset = {1, 2, 3};
  two.spatial_unit = "mm";
  save("v5_two_channels", write_file(two, bumpy));
  save("v5_raw_d4star",
       write_file(volume(LatticeKind::d4star, {12, 14, 13, 3}, {channel("value", ValueType::u16)}), ball, 1,
                  {.level = 0}));
  save("v5_rows",
       write_file(volume(LatticeKind::d4star, {15, 14, 14, 3}, {channel("value", ValueType::u16)}), rows));
  save("v5_d4star_means",
       write_file(volume(LatticeKind::d4star, {9, 9, 9, 4}, {channel("value", ValueType::u16)}), means));
  save("v5_fitted",
       write_file(volume(LatticeKind::d4star, {24, 24, 24, 10}, {channel("value", ValueType::u8)}), dense));
}

void make_ends() {
  VolumeInfo ends = volume(LatticeKind::d4star, {15, 14, 16, 6}, {channel("value", ValueType::u16)});
  ends.lattice = Lattice4::fit(LatticeKind::d4star, ends.lattice.dims, {1, 1, 1, 1}, 4);
  save("v5_ends", write_file(ends, ball));
}

// On both sides of air, with holes.
Sample both_sides(int c, double x, double y, double z, double t) {
  Sample s = ball(c, x, y, z, t);
  if (s.kept) s.value -= 20;
  return s;
}

// The appendix of formats/bcc4.md shows it.
void make_raw() {
  ChannelInfo value = channel("value", ValueType::u16);
  value.scale = 1.0 / 64, value.offset = -18.375;
  save("v5_raw",
       write_file(volume(LatticeKind::cc, {9, 10, 8, 3}, {std::move(value)}), both_sides, 1, {.level = 0}));
}

void make_corrections() {
  const Bytes good = corrected_file();
  save("v5_corrections", good);
  save("bad_sums", rebuild(good, {.metadata = [](Bytes& m) {
                             VolumeInfo v = read_metadata(m, 0, {});
                             v.channels[0].sums->corrections = v.cc_samples() + 1;
                             m = write_metadata(v);
                           }}));
  save("bad_corrections_shape", rebuild(good, {.metadata = [](Bytes& m) {
                                          VolumeInfo v = read_metadata(m, 0, {});
                                          v.channels[0].residuals.shape = static_cast<CorrectionShape>(2);
                                          m = write_metadata(v);
                                        }}));
  save("v5_corrections_base", corrected_file(12.5f));
  save("bad_corrections_base", rebuild(good, {.metadata = [](Bytes& m) {
                                         VolumeInfo v = read_metadata(m, 0, {});
                                         v.channels[0].residuals.base =
                                             std::numeric_limits<float>::infinity();
                                         m = write_metadata(v);
                                       }}));
}

// A mask of other runs in the place of the first one.
Bytes with_mask(const Bytes& good, std::initializer_list<int> runs) {
  Bytes decoded;
  for (const int v : runs) decoded.push_back(static_cast<std::byte>(v));
  PackedBlock block = pack_block(decoded);
  Bytes file = good;
  block.ref.offset = (file.size() + 7) / 8 * 8;
  file.resize(block.ref.offset);
  file.insert(file.end(), block.bytes.begin(), block.bytes.end());
  return rebuild(file, {.metadata = [&](Bytes& m) {
                   VolumeInfo v = read_metadata(m, 0, {});
                   v.channels[0].masks[0] = block.ref;
                   m = write_metadata(v);
                 }});
}

void make_masks() {
  const Bytes good = masked_file();
  save("v5_masks", good);
  save("bad_mask_beyond", with_mask(good, {0x10, 0xff, 0xff, 0x7f}));
  save("bad_mask_pair", with_mask(good, {1, 2, 0, 3}));
  save("bad_mask_cut", with_mask(good, {1, 2, 4}));
  save("bad_masks_frames", rebuild(good, {.metadata = [](Bytes& m) {
                                     VolumeInfo v = read_metadata(m, 0, {});
                                     v.channels[1].masks.pop_back();
                                     m = write_metadata(v);
                                   }}));
}

// The payload of a record of metadata.
size_t payload_of(const Bytes& metadata, uint16_t type) {
  size_t at = 0;
  while (peek<uint16_t>(metadata, at) != type) at += (8 + peek<uint32_t>(metadata, at + 4) + 7) / 8 * 8;
  return at + 8;
}

void make_domain() {
  VolumeInfo wide = volume(LatticeKind::d4star, {30, 12, 20, 6}, {channel("value", ValueType::u16)});
  wide.lattice = Lattice4::fit(LatticeKind::d4star, wide.lattice.dims, {1, 1.2, .8, 1}, 4, {4, 0, 2});
  const Bytes good = write_file(wide, ball);
  save("v5_domain", good);
  const auto save_bad = [&](const std::string& name, size_t byte, uint8_t value) {
    save(name,
         rebuild(good, {.metadata = [&](Bytes& m) { poke<uint8_t>(m, payload_of(m, 8) + byte, value); }}));
  };
  save_bad("bad_domain_end", 2, 4);
  save_bad("bad_domain_periodic", 4, 2); // at one end of an axis alone
  save_bad("bad_domain_odd", 8, 3);
  save_bad("bad_domain_planes", 12, 44);
  save_bad("bad_domain_lead", 11, 2);
}

// A turn of 6 frames in 10 layers; D4* asks for an even number.
void make_periodic() {
  VolumeInfo round = volume(LatticeKind::d4star, {14, 12, 16, 6}, {channel("value", ValueType::u16)});
  round.lattice = Lattice4::fit(LatticeKind::d4star, round.lattice.dims, {1, 1, 1, 1}, 0, {}, true);
  const Bytes good = write_file(round, ball);
  save("v5_periodic", good);
  const auto save_bad = [&](const std::string& name, const std::function<void(Bytes&)>& spoil) {
    save(name, rebuild(good, {.metadata = spoil}));
  };
  save_bad("bad_periodic_one_end", [](Bytes& m) { poke<uint8_t>(m, payload_of(m, 8) + 7, 0); });
  save_bad("bad_periodic_turn", [](Bytes& m) { poke<double>(m, payload_of(m, 1) + 64, 0.7); });
}

// Longitude along x: 14 samples in 20 planes; D4* asks for an even number.
void make_periodic_axis() {
  VolumeInfo round = volume(LatticeKind::d4star, {14, 12, 16, 6}, {channel("value", ValueType::u16)});
  round.lattice = Lattice4::fit(LatticeKind::d4star, round.lattice.dims, {1, 1, 1, 1}, 0, {0, 2, 0}, false,
                                {true, false, false});
  const Bytes good = write_file(round, ball);
  save("v5_periodic_axis", good);
  const auto save_bad = [&](const std::string& name, const std::function<void(Bytes&)>& spoil) {
    save(name, rebuild(good, {.metadata = spoil}));
  };
  save_bad("bad_periodic_axis_turn", [](Bytes& m) { poke<double>(m, payload_of(m, 1) + 40, 0.71); });
  save_bad("bad_periodic_axis_outside", [](Bytes& m) { poke<uint8_t>(m, payload_of(m, 8) + 8, 2); });
  save_bad("bad_periodic_axis_odd", [](Bytes& m) {
    poke<int32_t>(m, payload_of(m, 1) + 20, 20);
    poke<double>(m, payload_of(m, 1) + 40, 14.0 / 21);
  });
}

// Depths along z and pressures, which fall, along y; a reader that knows nothing of them skips them.
void make_uneven_axes() {
  VolumeInfo info = volume(LatticeKind::d4star, {14, 7, 12, 4}, {channel("value", ValueType::u16)});
  info.axes[0].unit = "degrees";
  info.axes[1] = {"hPa", false, {1000, 850, 700, 500, 300, 100, 10.5}};
  info.axes[2] = {"m", true, {0, 10, 20, 30, 50, 75, 100, 150, 200, 300, 500, 1000}};
  const Bytes good = write_file(info, ball);
  save("v5_uneven_axes", good);
  const auto save_bad = [&](const std::string& name, const std::function<void(Bytes&)>& spoil) {
    save(name, rebuild(good, {.metadata = spoil}));
  };
  // From the payload: "degrees", flags, count 0; "hPa", flags, count 7.
  constexpr size_t flags = 11, pressures = 4 + 7 + 8 + 4 + 3 + 8;
  save_bad("bad_coordinates_fall",
           [](Bytes& m) { poke<double>(m, payload_of(m, 0x8009) + pressures + 16, 850.5); });
  save_bad("bad_coordinates_nan", [](Bytes& m) {
    poke<double>(m, payload_of(m, 0x8009) + pressures + 8, std::numeric_limits<double>::quiet_NaN());
  });
  save_bad("bad_coordinates_count",
           [](Bytes& m) { poke<uint32_t>(m, payload_of(m, 0x8009) + pressures - 4, 6); });
  save_bad("bad_coordinates_flags", [](Bytes& m) { poke<uint32_t>(m, payload_of(m, 0x8009) + flags, 2); });
}

void make_optional() {
  const Bytes file =
      write_file(volume(LatticeKind::d4star, {14, 14, 14, 4}, {channel("value", ValueType::u8)}), ball);
  // A record and a column of some later version that readers of this one may skip.
  save("v5_optional_parts",
       rebuild(file, {.metadata =
                          [](Bytes& m) {
                            ByteWriter w;
                            w.write(uint16_t{0x8001}), w.write(uint16_t{0}), w.write(uint32_t{5});
                            w.write(uint64_t{0x0000000102030405});
                            m.insert(m.end(), w.bytes().begin(), w.bytes().end());
                          },
                      .page =
                          [](Bytes& p) {
                            const auto n = peek<uint32_t>(p, 0), columns = peek<uint32_t>(p, 4);
                            poke<uint32_t>(p, 4, columns + 1);
                            const std::array<std::byte, 4> id{std::byte{128}, std::byte{4}, {}, {}};
                            p.insert(p.begin() + 8 + 4 * columns, id.begin(), id.end());
                            p.insert(p.end(), n * 4, std::byte{7});
                          }}));
}

void make_levels() {
  save("v5_levels", levels_file());
  save("bad_level_planes", rebuild(levels_file(), {.metadata = [](Bytes& m) {
                                     VolumeInfo v = read_metadata(m, 0, {});
                                     std::swap(v.levels[0].lattice, v.levels[1].lattice);
                                     m = write_metadata(v);
                                   }}));
  save("bad_level_of_page",
       rebuild(levels_file(), {.pages = [](std::vector<PageRef>& p) { p.back().level = 3; }}));
  constexpr size_t lattices = 4 + 2 * 64; // what is said of channels follows
  save("bad_level_scale", rebuild(levels_file(), {.metadata = [](Bytes& m) {
                                    poke<double>(m, payload_of(m, 9) + lattices, 0.75);
                                  }}));
}

void make_unfinished() {
  const Bytes good = unfinished_file();
  save("v5_unfinished", good);
  save("bad_unfinished_frames", rebuild(good, {.root = [](Root& r) { r.frames = 99; }}));
  save("bad_finished_frames", rebuild(good, {.root = [](Root& r) { r.unfinished = false; }}));
  Bytes bad = good;
  bad.resize(bad.size() + 8);            // a copy of the root is none any more
  bad[root_offset + 104] = std::byte{2}; // state
  poke<uint32_t>(bad, root_offset + 124, crc32_of(std::span(bad).subspan(root_offset, 124)));
  save("bad_root_state", bad);
}

void make_bad() {
  const Bytes good =
      write_file(volume(LatticeKind::d4star, {14, 14, 14, 4}, {channel("value", ValueType::u8)}), ball);
  Bytes bad = good;
  bad.resize(good.size() - 8);
  save("bad_truncated", bad);
  bad = good;
  bad[0] = std::byte{0x09};
  save("bad_seven_bits", bad);
  bad = good;
  for (size_t i = 0; i < bad.size(); ++i)
    if (bad[i] == std::byte{0x0d} && bad[i + 1] == std::byte{0x0a}) bad.erase(bad.begin() + i);
  save("bad_text_mode", bad);
  bad = good;
  for (const auto& [name, version] : {std::pair{"bad_newer_version", 99}, {"bad_older_version", 4}}) {
    bad = good;
    bad[14] = static_cast<std::byte>(version); // lowest reader
    poke<uint32_t>(bad, 60, crc32_of(std::span(bad).first(60)));
    save(name, bad);
  }
  bad = good;
  bad[root_offset + 20] ^= std::byte{1};
  save("bad_root", bad);
  bad = good;
  bad[preamble_bytes + 40] ^= std::byte{16};
  save("bad_chunk", bad);
  const Root root = *read_preamble(std::span(good).first(preamble_bytes), "good").root;
  bad = good;
  bad[root.metadata.offset + 30] ^= std::byte{4};
  save("bad_metadata", bad);
  bad = good;
  bad[root.directory.offset + 3] ^= std::byte{128};
  save("bad_directory", bad);
  bad = good;
  bad[20] = std::byte{1}; // reserved
  poke<uint32_t>(bad, 60, crc32_of(std::span(bad).first(60)));
  save("bad_header", bad);
  save("bad_value_type",
       rebuild(good, {.metadata = [](Bytes& m) { poke<uint8_t>(m, payload_of(m, 5), 5); }}));
  save("bad_predictor", rebuild(good, {.entries = [](std::vector<Bcc4Chunk>& e) { e[0].predictor |= 16; }}));
  save("bad_run_list", rebuild(good, {.chunk = [](Bcc4Chunk& c, Bytes& b) {
                                 // One pair that sets more sites than there are.
                                 b.resize(c.values_bytes);
                                 for (const int v : {0, 0xff, 0xff, 0x7f})
                                   b.push_back(static_cast<std::byte>(v));
                                 c.runs_bytes = c.runs_decoded = 4;
                                 c.coding &= 15;
                               }}));
}

} // namespace
} // namespace bccsplat::test

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: make_golden FOLDER\n", stderr);
    return 2;
  }
  bccsplat::test::folder = argv[1];
  bccsplat::test::make_good();
  bccsplat::test::make_optional();
  bccsplat::test::make_ends();
  bccsplat::test::make_raw();
  bccsplat::test::make_corrections();
  bccsplat::test::make_masks();
  bccsplat::test::make_domain();
  bccsplat::test::make_periodic();
  bccsplat::test::make_periodic_axis();
  bccsplat::test::make_uneven_axes();
  bccsplat::test::make_levels();
  bccsplat::test::make_unfinished();
  bccsplat::test::make_tiles();
  bccsplat::test::make_bad();
  return 0;
}
