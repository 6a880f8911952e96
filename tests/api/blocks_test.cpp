// SPDX-License-Identifier: Apache-2.0
// Series written in blocks of space, each by a writer that sees its own samples and a few around them, and
// joined: the bytes of one writer. Boxes that miss or double samples, and what no block can do, are refused
// by name.
#include <limits>

#ifndef _WIN32
#include <sys/resource.h>
#endif

#include "block_series.h"

namespace host::block_series {
namespace {

TEST(Blocks, GiveTheBytesOfOneWriter) {
  const Device device = make_device();
  const std::vector<Case> cases{
      {"bytes", [](Asked&) {}},
      {"u16 on a coarse lattice",
       [](Asked& a) { a.type = BCCSPLAT_TYPE_U16, a.options.scale = 1.4, a.options.time_scale = 1.7; }},
      {"floats", [](Asked& a) { a.type = BCCSPLAT_TYPE_F32; }},
      {"floats as bytes",
       [](Asked& a) {
         a.type = BCCSPLAT_TYPE_F32, a.channel.value_type = BCCSPLAT_TYPE_U8;
         a.channel.set_mask |= BCCSPLAT_CHANNEL_SET_RANGE, a.channel.range[1] = 150;
       }},
      {"mirrors",
       [](Asked& a) {
         a.options.fixed_predictions = 0;
         a.options.ends = BCCSPLAT_ENDS_MIRROR, a.options.faces = BCCSPLAT_FACES_MIRROR;
       }},
      {"predicted",
       [](Asked& a) { a.options.ends = BCCSPLAT_ENDS_PREDICT, a.options.faces = BCCSPLAT_FACES_PREDICT_X; }},
      {"Cartesian", [](Asked& a) { a.options.lattice = BCCSPLAT_LATTICE_CC; }},
      {"coarse Cartesian", [](Asked& a) { a.options.lattice = BCCSPLAT_LATTICE_CC, a.options.scale = 1.3; }},
      {"a threshold", [](Asked& a) { a.channel.air_threshold = 9; }},
      {"one frame", [](Asked& a) { a.dims[3] = 1; }},
      {"levels",
       [](Asked& a) {
         a.dims = {150, 100, 96, 3}, a.options.levels = 2;
       }},
      {"levels with mirrors",
       [](Asked& a) {
         a.dims = {90, 100, 96, 5}, a.options.levels = 3;
         a.options.faces = BCCSPLAT_FACES_MIRROR;
       }},
      {"levels of floats far from air, on a finer Cartesian lattice",
       [](Asked& a) {
         a.dims = {120, 60, 64, 3}, a.options.levels = 2, a.type = BCCSPLAT_TYPE_F32;
         a.options.lattice = BCCSPLAT_LATTICE_CC, a.options.scale = .8, a.channel.air = -150;
         a.options.faces = BCCSPLAT_FACES_PREDICT_X;
       }},
      {"many bricks along x", [](Asked& a) {
         a.dims = {150, 30, 24, 5};
       }}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const Folder folder;
    Asked asked;
    c.change(asked);
    const auto& n = asked.dims;
    expect_same(device, folder, asked, {{{0, n[0] * 2 / 5, n[0]}, {0, 21, n[1]}, {0, n[2]}, {0, n[3]}}});
  }
}

// Land with a coast, one that moves through the blob, single samples, and for some frames all of the first
// block.
bool no_data(double x, double y, double z, uint32_t t) {
  const bool land = x < 9 + 5 * std::sin(y / 4) + 3 * std::sin(1.3 * z);
  const bool drifting = std::hypot(x - 20 - 4 * t, y - 21, z - 18) < 7;
  const bool single = static_cast<int>(x * 7 + y * 13 + z * 29 + t) % 97 == 0;
  return land || drifting || single || (t % 3 == 1 && x < 30 && y < 21 && z < 12);
}

Asked with_missing_data() {
  Asked asked;
  asked.type = BCCSPLAT_TYPE_F32, asked.missing = no_data;
  asked.options.nonfinite = BCCSPLAT_NONFINITE_HOLE;
  return asked;
}

TEST(Blocks, WithMissingDataGiveTheBytesOfOneWriter) {
  const Device device = make_device();
  const std::vector<Case> cases{{"samples", [](Asked&) {}},
                                {"far from air", [](Asked& a) { a.channel.air = -150; }},
                                {"codes",
                                 [](Asked& a) {
                                   a.channel.value_type = BCCSPLAT_TYPE_U8;
                                   a.channel.set_mask |= BCCSPLAT_CHANNEL_SET_RANGE, a.channel.range[1] = 210;
                                 }},
                                {"a coarse lattice", [](Asked& a) { a.options.scale = 1.4; }},
                                {"Cartesian", [](Asked& a) { a.options.lattice = BCCSPLAT_LATTICE_CC; }},
                                {"one frame", [](Asked& a) { a.dims[3] = 1; }},
                                {"levels", [](Asked& a) {
                                   a.dims = {140, 80, 72, 3}, a.options.levels = 2;
                                 }}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const Folder folder;
    Asked asked = with_missing_data();
    c.change(asked);
    const auto& n = asked.dims;
    std::vector<uint64_t> frames{0, n[3]};
    if (n[3] > 4) frames = {0, 5, n[3]};
    expect_same(device, folder, asked, {{{0, 30, n[0]}, {0, 21, n[1]}, {0, 12, n[2]}, frames}});
    auto info = sized<bccsplat_channel_info>();
    const Volume volume = open(device, folder.file("joined.bcc4"));
    ASSERT_OK(bccsplat_volume_get_channel_info(volume.get(), 0, &info));
    uint64_t missing = 0;
    for (uint32_t t = 0; t < n[3]; ++t)
      for (uint32_t z = 0; z < n[2]; ++z)
        for (uint32_t y = 0; y < n[1]; ++y)
          for (uint32_t x = 0; x < n[0]; ++x) missing += no_data(x, y, z, t) ? 1 : 0;
    EXPECT_EQ(info.missing, missing);
  }
}

TEST(Blocks, AFrameThatIsMissingAltogetherIsRefused) {
  const Device device = make_device();
  const Folder folder;
  Asked asked = with_missing_data();
  asked.missing = [](double x, double, double, uint32_t t) { return t == 4 || (t == 5 && x < 40); };
  bccsplat_writer_options o = asked.writer_options();
  const Writer one = make_writer(device, folder.file("x.bcc4"), o);
  const Box all{{{0, 0, 0}, {64, 40, 36}}};
  for (uint32_t t = 0; t < 4; ++t) ASSERT_OK(add_box(one.get(), asked, all, t));
  EXPECT_EQ(add_box(one.get(), asked, all, 4), BCCSPLAT_ERROR_NONFINITE_VALUE);
  EXPECT_NE(std::string(bccsplat_last_error()).find("frame 4: none of its values is finite"),
            std::string::npos);
  Blocks blocks(device, folder, asked);
  blocks.write_all({{{0, 30, 64}, {0, 40}, {0, 36}, {0, 9}}});
  EXPECT_EQ(blocks.join(folder.file("y.bcc4")), BCCSPLAT_ERROR_NONFINITE_VALUE);
  EXPECT_NE(std::string(bccsplat_last_error()).find("frame 4: none of its values is finite in any block"),
            std::string::npos)
      << bccsplat_last_error();
  // Replaced by air it is a frame like any other.
  asked.options.nonfinite = BCCSPLAT_NONFINITE_CLAMP;
  asked.channel.set_mask |= BCCSPLAT_CHANNEL_SET_RANGE, asked.channel.range[1] = 210;
  expect_same(device, folder, asked, {{{0, 30, 64}, {0, 40}, {0, 36}, {0, 9}}});
}

TEST(Blocks, OfFramesAndOfAnyShape) {
  const Device device = make_device();
  const Folder folder;
  Asked asked;
  asked.dims = {64, 64, 64, 12};
  write(device, folder.file("whole.bcc4"), asked);
  Blocks blocks(device, folder, asked);
  // Early frames as two halves, the later ones in other pieces, one of them too thin for a brick of its own.
  blocks.write_block({{{0, 0, 0}, {64, 64, 30}}}, 0, 7);
  blocks.write_block({{{0, 0, 30}, {64, 64, 64}}}, 0, 7);
  blocks.write_block({{{0, 0, 0}, {41, 64, 64}}}, 7, 12);
  blocks.write_block({{{41, 0, 0}, {43, 64, 64}}}, 7, 12);
  blocks.write_block({{{43, 0, 0}, {64, 50, 64}}}, 7, 12);
  blocks.write_block({{{43, 50, 0}, {64, 64, 64}}}, 7, 12);
  ASSERT_OK(blocks.join(folder.file("joined.bcc4")));
  EXPECT_TRUE(bytes_of(folder.file("joined.bcc4")) == bytes_of(folder.file("whole.bcc4")));
}

#ifndef _WIN32
// While it lives no more than so many files can be opened beside those that are open.
class FewFiles {
 public:
  explicit FewFiles(rlim_t count) {
    const int next = ::dup(STDERR_FILENO);
    ::close(next);
    EXPECT_EQ(getrlimit(RLIMIT_NOFILE, &old_), 0);
    rlimit now = old_;
    now.rlim_cur = static_cast<rlim_t>(next) + count;
    EXPECT_EQ(setrlimit(RLIMIT_NOFILE, &now), 0);
  }
  FewFiles(const FewFiles&) = delete;
  FewFiles& operator=(const FewFiles&) = delete;
  ~FewFiles() { setrlimit(RLIMIT_NOFILE, &old_); }

 private:
  rlimit old_{};
};

TEST(Blocks, MayBeMoreThanTheFilesOfAProcess) {
  const Device device = make_device();
  const Folder folder;
  const Asked asked;
  (void)write(device, folder.file("whole.bcc4"), asked);
  Blocks blocks(device, folder, asked);
  blocks.write_all({{{0, 16, 32, 48, 64}, {0, 16, 40}, {0, 16, 36}, {0, 5, 9}}});
  ASSERT_EQ(blocks.names().size(), 32u);
  const FewFiles few(20);
  EXPECT_OK(blocks.join(folder.file("joined.bcc4")));
  EXPECT_TRUE(bytes_of(folder.file("joined.bcc4")) == bytes_of(folder.file("whole.bcc4")));
}
#endif

TEST(Blocks, TakeTheirSamplesAndAHalo) {
  const Device device = make_device();
  const Folder folder;
  Asked asked;
  asked.dims = {160, 80, 72, 9};
  Blocks blocks(device, folder, asked);
  const Box box = blocks.write_block({{{0, 43, 0}, {80, 80, 72}}}, 0, 9).box;
  EXPECT_EQ(box[0], (std::array<uint64_t, 3>{0, 40, 0})); // the first site stands at 43.7
  EXPECT_EQ(box[1][1], 80u);
  EXPECT_EQ(box[1][2], 72u);
  // Bricks are made in fours along x: 64 sites are 90 samples and the reach of the filter.
  EXPECT_GE(box[1][0], 80u + 4);
  EXPECT_LE(box[1][0], 112u);
  auto info = sized<bccsplat_volume_info>();
  const Volume volume = open(device, blocks.names()[0]);
  ASSERT_OK(bccsplat_volume_get_info(volume.get(), &info));
  EXPECT_EQ(info.part_end, 9u);
  EXPECT_EQ(info.part_box_begin[1], 43u);
  EXPECT_EQ(info.part_box_end[0], 80u);
}

TEST(Blocks, MissingOrDoubledSamplesAreNamed) {
  const Device device = make_device();
  const Folder folder;
  Asked asked;
  Blocks blocks(device, folder, asked);
  blocks.write_all({{{0, 30, 64}, {0, 40}, {0, 20, 36}, {0, 9}}});
  const std::vector<std::string> all = blocks.names();
  const auto refused = [&](std::vector<std::string> names, const std::vector<std::string>& texts) {
    EXPECT_EQ(blocks.join(folder.file("x.bcc4"), names), BCCSPLAT_ERROR_INVALID_ARGUMENT);
    for (const std::string& text : texts)
      EXPECT_NE(std::string(bccsplat_last_error()).find(text), std::string::npos) << bccsplat_last_error();
    EXPECT_FALSE(std::filesystem::exists(folder.file("x.bcc4")));
  };
  refused({all[0], all[1], all[3]}, {"x 0:30, y 0:40, z 20:36 of 9 are in none of the parts", all[3]});
  refused({all[0], all[1], all[2], all[3], all[1]}, {"x 30:64, y 0:40, z 0:20 are both in ", all[1]});
  const Box wide{{{20, 0, 20}, {64, 40, 36}}};
  blocks.write_block(wide, 0, 9);
  refused({all[0], all[1], all[2], blocks.names().back()}, {"x 20:30, y 0:40, z 20:36 are both in ", all[2]});
  asked.channel.air = 4;
  Blocks other(device, folder, asked);
  other.write_block({{{30, 0, 20}, {64, 40, 36}}}, 0, 9); // in the place of the first one
  refused({all[0], all[1], all[2], all[3]}, {"air"});
}

TEST(Blocks, WhatNeedsMoreOfAFrameIsRefused) {
  const Device device = make_device();
  const Folder folder;
  const std::vector<double> times{0, 1, 2, 3, 4, 5, 6, 7, 8};
  const auto refused = [&](const char* text, bccsplat_status status,
                           const std::function<void(Asked&, bccsplat_series_part&)>& change) {
    Asked asked;
    auto part = sized<bccsplat_series_part>();
    part.end = 9, part.times = times.data();
    part.box_end[0] = 30, part.box_end[1] = 40, part.box_end[2] = 36;
    bccsplat_writer_options o = asked.writer_options();
    change(asked, part);
    const bccsplat_writer_options with = asked.options;
    o = with, o.channels = &asked.channel, o.channel_count = 1, o.part = &part;
    bccsplat_writer* w = nullptr;
    EXPECT_EQ(bccsplat_writer_create(device.get(), folder.file("x.bcc4").c_str(), &o, &w), status) << text;
    EXPECT_NE(std::string(bccsplat_last_error()).find(text), std::string::npos) << bccsplat_last_error();
    bccsplat_writer_release(w);
  };
  constexpr auto unsupported = BCCSPLAT_ERROR_UNSUPPORTED, invalid = BCCSPLAT_ERROR_INVALID_ARGUMENT;
  using Part = bccsplat_series_part;
  refused("lowpass holds whole frames", unsupported, [](Asked& a, Part&) { a.options.lowpass = 1; });
  refused("holes are filled", unsupported, [](Asked& a, Part&) {
    a.options.nonfinite = BCCSPLAT_NONFINITE_HOLE, a.options.fixed_predictions = 0;
    a.options.ends = BCCSPLAT_ENDS_MIRROR, a.options.faces = BCCSPLAT_FACES_MIRROR;
  });
  refused("measure SOME", unsupported, [](Asked& a, Part&) { a.options.measure = BCCSPLAT_MEASURE_SOME; });
  refused("periodic axis", unsupported,
          [](Asked& a, Part&) { a.options.periodic_axes = BCCSPLAT_PERIODIC_X; });
  refused("frames are halved", unsupported, [](Asked& a, Part&) {
    a.options.levels = 1, a.options.fixed_predictions = 0;
    a.options.ends = BCCSPLAT_ENDS_MIRROR, a.options.faces = BCCSPLAT_FACES_MIRROR;
  });
  refused("fixed_predictions", unsupported, [](Asked& a, Part&) {
    a.options.fixed_predictions = 0, a.options.faces = BCCSPLAT_FACES_PREDICT_X;
  });
  refused("give source_type", invalid, [](Asked& a, Part&) { a.channel.source_type = 0; });
  refused("the volume has 64", invalid, [](Asked&, Part& p) { p.box_end[0] = 65; });
  refused("a block has at least one", invalid, [](Asked&, Part& p) { p.box_begin[1] = 40; });
  refused("the volume has 36", invalid,
          [](Asked&, Part& p) { p.box_end[2] = std::numeric_limits<uint64_t>::max(); });
}

} // namespace
} // namespace host::block_series
