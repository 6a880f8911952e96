// SPDX-License-Identifier: Apache-2.0
// A writer that would go on with what it does not fit is refused when it is made, by the name of the option,
// and leaves what is there as it is.
#include "host_streams.h"

namespace host {
namespace {

// Options of a writer and what they point to.
struct Asked {
  static constexpr uint32_t frames = 20;
  bccsplat_writer_options o = sized<bccsplat_writer_options>();
  std::vector<bccsplat_channel_options> channels{2, sized<bccsplat_channel_options>()};
  std::optional<bccsplat_series_part> part;
  std::vector<double> times;

  Asked() {
    o.dims[0] = 24, o.dims[1] = 20, o.dims[2] = 18, o.dims[3] = frames;
    channels[0].name = "density", channels[1].name = "heat";
    for (bccsplat_channel_options& c : channels) c.source_type = BCCSPLAT_TYPE_U8;
    for (uint32_t t = 0; t < 2 * frames; ++t) times.push_back(t);
  }
  void only(uint64_t first, uint64_t end) {
    part = sized<bccsplat_series_part>();
    part->first = first, part->end = end, part->times = times.data();
  }
  bccsplat_status create(const Device& device, const std::string& path, Writer& writer) {
    o.channels = channels.data(), o.channel_count = static_cast<uint32_t>(channels.size());
    o.part = part ? &*part : nullptr;
    bccsplat_writer* w = nullptr;
    const bccsplat_status status = bccsplat_writer_create(device.get(), path.c_str(), &o, &w);
    writer.reset(w);
    return status;
  }
};
using Change = void (*)(Asked&);

struct Misfit {
  const char* text; // in the error
  Change change;
};

bccsplat_status add(const Writer& writer, const Asked& asked, uint32_t frames, uint32_t first = 0) {
  const auto& n = asked.o.dims;
  std::vector<uint8_t> values(size_t{n[0]} * n[1] * n[2]);
  bccsplat_status status = BCCSPLAT_OK;
  for (uint32_t t = first; t < frames && status == BCCSPLAT_OK; ++t)
    for (uint32_t c = 0; c < asked.channels.size() && status == BCCSPLAT_OK; ++c) {
      for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<uint8_t>((i * 7 + t * 3 + c) % 200);
      auto box = sized<bccsplat_box>();
      box.type = BCCSPLAT_TYPE_U8, box.data = values.data();
      for (int a = 0; a < 3; ++a) box.dims[a] = n[a];
      status = bccsplat_writer_add_frame(writer.get(), c, t, &box, 1);
    }
  return status;
}

// Files of a folder and their bytes.
std::map<std::string, std::vector<char>> all_in(const Folder& folder) {
  std::map<std::string, std::vector<char>> files;
  for (const auto& e : std::filesystem::directory_iterator(folder.path()))
    files[e.path().filename().string()] = file_bytes(e.path().string());
  return files;
}

struct Place {
  Folder folder;
  Device device = make_device();
  std::string path = folder.file("s.bcc4");

  void write(Asked asked) const {
    Writer writer;
    ASSERT_OK(asked.create(device, path, writer));
    ASSERT_OK(add(writer, asked, asked.o.dims[3]));
    ASSERT_OK(bccsplat_writer_finish(writer.get(), nullptr));
  }
  // Every misfit is refused at create.
  void expect_refused(const Asked& fitting, const std::vector<Misfit>& misfits) const {
    const auto before = all_in(folder);
    for (const Misfit& m : misfits) {
      SCOPED_TRACE(m.text);
      Asked asked = fitting;
      m.change(asked);
      Writer writer;
      EXPECT_EQ(asked.create(device, path, writer), BCCSPLAT_ERROR_WRONG_STATE);
      const std::string error = bccsplat_last_error();
      EXPECT_NE(error.find(m.text), std::string::npos) << error;
      EXPECT_NE(error.find(path), std::string::npos) << error;
      EXPECT_TRUE(all_in(folder) == before);
    }
  }
};

void store_wavelets(Asked& a) {
  static constexpr double errors[]{3, 3};
  a.o.store = BCCSPLAT_STORE_WAVELETS, a.o.wavelet_errors = errors;
}

const std::vector<Misfit> other_series{
    {"lattice is D4*", [](Asked& a) { a.o.lattice = BCCSPLAT_LATTICE_CC; }},
    {"samples along y", [](Asked& a) { a.o.dims[1] = 21; }},
    {"planes along x", [](Asked& a) { a.o.scale = 1.5; }},
    {"frames apart", [](Asked& a) { a.o.time_scale = 1.5; }},
    {"periodic along z", [](Asked& a) { a.o.periodic_axes = BCCSPLAT_PERIODIC_Z; }},
    {"the lattices of its series", store_wavelets},
    {"2 channels", [](Asked& a) { a.channels.pop_back(); }},
    {"channel 1 (heat)", [](Asked& a) { a.channels[1].name = "warmth"; }},
    {"air is 0", [](Asked& a) { a.channels[0].set_mask = BCCSPLAT_CHANNEL_SET_AIR, a.channels[0].air = 3; }},
    {"air_threshold", [](Asked& a) { a.channels[1].air_threshold = 2; }},
    {"type on disk", [](Asked& a) { a.channels[1].source_type = BCCSPLAT_TYPE_F32; }},
    {"type on disk",
     [](Asked& a) { a.channels[1].source_type = 0, a.channels[1].value_type = BCCSPLAT_TYPE_U16; }},
    {"step from code to code",
     [](Asked& a) { a.channels[1].set_mask = BCCSPLAT_CHANNEL_SET_RANGE, a.channels[1].range[1] = 500; }},
};

TEST(Misfit, IsNotAppended) {
  const Place place;
  place.write({});
  Asked fitting;
  fitting.o.partial = BCCSPLAT_PARTIAL_APPEND, fitting.o.dims[3] = Asked::frames + 10;
  place.expect_refused(fitting, other_series);
  place.expect_refused(fitting, {{"20 frames", [](Asked& a) { a.o.dims[3] = 12; }}});
  // Nor by its new frames alone.
  Asked more = fitting;
  std::vector<Misfit> of_part = other_series;
  of_part.push_back({"is at time 0", [](Asked& a) { a.times[0] = -0.5; }});
  for (const Misfit& m : of_part) {
    SCOPED_TRACE(m.text);
    Asked asked = fitting;
    m.change(asked);
    asked.only(Asked::frames, Asked::frames + 10);
    asked.times.resize(Asked::frames + 10), asked.part->times = asked.times.data();
    Writer writer;
    EXPECT_EQ(asked.create(place.device, place.path, writer), BCCSPLAT_ERROR_WRONG_STATE);
    EXPECT_NE(std::string(bccsplat_last_error()).find(m.text), std::string::npos) << bccsplat_last_error();
  }
  // What fits is taken, and so are types that the first box will tell, as far as they agree.
  for (bccsplat_channel_options& c : more.channels) c.source_type = 0;
  Writer writer;
  ASSERT_OK(more.create(place.device, place.path, writer));
  EXPECT_EQ(add(writer, more, more.o.dims[3]),
            BCCSPLAT_ERROR_WRONG_STATE); // channel 1 without a type has floats
  EXPECT_NE(std::string(bccsplat_last_error()).find("heat"), std::string::npos) << bccsplat_last_error();
  writer.reset();
  ASSERT_OK(fitting.create(place.device, place.path, writer));
  ASSERT_OK(add(writer, fitting, fitting.o.dims[3]));
  EXPECT_OK(bccsplat_writer_finish(writer.get(), nullptr));
}

// A host that does not know its number of frames is told at the end, and may still give the rest.
TEST(Misfit, NoFewerFramesAreAppended) {
  const Place place;
  place.write({});
  Asked asked;
  asked.o.partial = BCCSPLAT_PARTIAL_APPEND, asked.o.dims[3] = 0;
  Writer writer;
  ASSERT_OK(asked.create(place.device, place.path, writer));
  ASSERT_OK(add(writer, asked, 3));
  for (const auto finish : {bccsplat_writer_finish, bccsplat_writer_finish_short}) {
    EXPECT_EQ(finish(writer.get(), nullptr), BCCSPLAT_ERROR_WRONG_STATE);
    EXPECT_NE(std::string(bccsplat_last_error()).find("it has 20 frames already, 3"), std::string::npos);
  }
  ASSERT_OK(add(writer, asked, Asked::frames + 2, 3));
  ASSERT_OK(bccsplat_writer_finish(writer.get(), nullptr));
  auto info = sized<bccsplat_volume_info>();
  ASSERT_OK(bccsplat_volume_get_info(open(place.device, place.path).get(), &info));
  EXPECT_EQ(info.dims[3], Asked::frames + 2u);
}

TEST(Misfit, OfWaveletsIsNotAppended) {
  const Place place;
  Asked fitting;
  store_wavelets(fitting);
  place.write(fitting);
  fitting.o.partial = BCCSPLAT_PARTIAL_APPEND, fitting.o.dims[3] = Asked::frames + 10;
  place.expect_refused(fitting, {{"the lattices of its series", [](Asked& a) {
                                    a.o.store = BCCSPLAT_STORE_SAMPLES, a.o.wavelet_errors = nullptr;
                                  }}});
}

TEST(Misfit, NoSeriesIsNotAppended) {
  for (const bool one : {false, true}) {
    const Place place;
    Asked fitting;
    if (one)
      fitting.o.dims[3] = 1;
    else
      fitting.only(0, Asked::frames), fitting.times.resize(Asked::frames);
    if (one) place.write(fitting);
    if (!one) {
      Writer writer;
      ASSERT_OK(fitting.create(place.device, place.path, writer));
      ASSERT_OK(add(writer, fitting, Asked::frames));
      ASSERT_OK(bccsplat_writer_finish(writer.get(), nullptr));
    }
    Asked longer;
    longer.o.partial = BCCSPLAT_PARTIAL_APPEND, longer.o.dims[3] = Asked::frames + 10;
    place.expect_refused(longer, {{one ? "a single frame" : "a part of a series", [](Asked&) {}}});
  }
}

TEST(Misfit, IsNotResumed) {
  const Place place;
  Asked fitting;
  fitting.o.partial = BCCSPLAT_PARTIAL_KEEP;
  {
    Writer writer;
    ASSERT_OK(fitting.create(place.device, place.path, writer));
    ASSERT_OK(add(writer, fitting, Asked::frames - 2));
  }
  fitting.o.partial = BCCSPLAT_PARTIAL_RESUME;
  ASSERT_EQ(all_in(place.folder).size(), 2u);
  place.expect_refused(
      fitting,
      {
          {"dims: 24 20 18 20", [](Asked& a) { a.o.dims[1] = 21; }},
          {"dims", [](Asked& a) { a.o.dims[3] = 25; }},
          {"lattice: D4*, not CC", [](Asked& a) { a.o.lattice = BCCSPLAT_LATTICE_CC; }},
          {"lattice distances", [](Asked& a) { a.o.scale = 1.5; }},
          {"lattice distances", [](Asked& a) { a.o.time_scale = 1.5; }},
          {"lowpass", [](Asked& a) { a.o.lowpass = 1; }},
          {"nonfinite: refused, not holes", [](Asked& a) { a.o.nonfinite = BCCSPLAT_NONFINITE_HOLE; }},
          {"ends", [](Asked& a) { a.o.ends = BCCSPLAT_ENDS_MIRROR; }},
          {"ends", [](Asked& a) { a.o.ends = BCCSPLAT_ENDS_PERIODIC; }},
          {"faces", [](Asked& a) { a.o.faces = BCCSPLAT_FACES_PREDICT_Y; }},
          {"periodic_axes: none, not x", [](Asked& a) { a.o.periodic_axes = BCCSPLAT_PERIODIC_X; }},
          {"store: samples, not wavelets", store_wavelets},
          {"recommended_kernel", [](Asked& a) { a.o.recommended_kernel = "fine"; }},
          {"levels", [](Asked& a) { a.o.levels = 1; }},
          {"recommended_kernel", [](Asked& a) { a.o.psnr = 20; }}, // which a bound says
          {"abs_error: 0, not 3", [](Asked& a) { a.o.abs_error = 3; }},
          {"live", [](Asked& a) { a.o.live = 1; }},
          {"spatial_unit", [](Asked& a) { a.o.spatial_unit = "mm"; }},
          {"time_unit", [](Asked& a) { a.o.time_unit = "s"; }},
          {"affine",
           [](Asked& a) { a.o.affine[0] = 2, a.o.affine[5] = a.o.affine[10] = a.o.affine[15] = 1; }},
          {"part", [](Asked& a) { a.only(0, 10); }},
          {"channels: 2, not 1", [](Asked& a) { a.channels.pop_back(); }},
          {"channel 1, name: heat, not warmth", [](Asked& a) { a.channels[1].name = "warmth"; }},
          {"channel 1, unit", [](Asked& a) { a.channels[1].unit = "K"; }},
          {"channel 1, source_type", [](Asked& a) { a.channels[1].source_type = BCCSPLAT_TYPE_F32; }},
          {"channel 0, air: 0, not 3",
           [](Asked& a) { a.channels[0].set_mask = BCCSPLAT_CHANNEL_SET_AIR, a.channels[0].air = 3; }},
          {"channel 0, air_threshold", [](Asked& a) { a.channels[0].air_threshold = 2; }},
          {"channel 1, range: none, not 0 500",
           [](Asked& a) {
             a.channels[1].set_mask = BCCSPLAT_CHANNEL_SET_RANGE, a.channels[1].range[1] = 500;
           }},
      });
  // What only the first slab tells is refused there, and costs as little.
  const auto before = all_in(place.folder);
  {
    Writer writer;
    ASSERT_OK(fitting.create(place.device, place.path, writer));
    ASSERT_OK(bccsplat_writer_set_attribute(writer.get(), "made by", "another"));
    EXPECT_EQ(add(writer, fitting, Asked::frames), BCCSPLAT_ERROR_WRONG_STATE);
  }
  EXPECT_TRUE(all_in(place.folder) == before);
  Writer writer;
  ASSERT_OK(fitting.create(place.device, place.path, writer));
  ASSERT_OK(add(writer, fitting, Asked::frames));
  auto report = sized<bccsplat_writer_report>();
  ASSERT_OK(bccsplat_writer_finish(writer.get(), &report));
  EXPECT_GT(report.slabs_reused, 0u);
}

} // namespace
} // namespace host
