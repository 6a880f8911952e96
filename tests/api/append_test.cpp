// SPDX-License-Identifier: Apache-2.0
// A series that goes on: only the new frames and some before them are given, and the file is that of all
// frames.
#include <array>
#include <fstream>
#include <iterator>
#include <limits>

#include "support.h"

namespace host {
namespace {

struct Variant {
  const char* name;
  int32_t source = BCCSPLAT_TYPE_F32;
  uint32_t channels = 1;
  bool holes = false, uneven = false;
  void (*change)(bccsplat_writer_options&) = [](bccsplat_writer_options&) {};
  uint32_t from = 30, frames = 44; // frames of the first file and of all
  double wavelet_error = 8;        // 0: none is asked for
};

constexpr uint32_t nx = 21, ny = 19, nz = 17;

void store_wavelets(bccsplat_writer_options& o) {
  o.store = BCCSPLAT_STORE_WAVELETS, o.lattice = BCCSPLAT_LATTICE_CC;
}

double field(uint32_t channel, uint32_t x, uint32_t y, uint32_t z, uint32_t t) {
  const double noise = ((x * 73856093u ^ y * 19349663u ^ z * 83492791u ^ t * 2654435761u) >> 8 & 255) / 255.0;
  // Clamped by integers, with air around.
  const double ball = 240 * std::exp(-(std::pow(x - 6.0 - 0.2 * t, 2) + std::pow(y - 9.0, 2)) / 40);
  return ball < 30 ? 0 : std::floor(ball + (channel + 1) * 60 * noise);
}

class Append : public testing::Test {
 protected:
  [[nodiscard]] static double time_of(const Variant& v, uint64_t t) {
    const auto frame = static_cast<double>(t);
    return v.uneven ? 3 + 0.1 * frame + 0.001 * frame * frame : 3 + 0.1 * frame;
  }

  bccsplat_status add(bccsplat_writer* writer, const Variant& v, uint64_t begin, uint64_t end) {
    std::vector<float> floats(size_t{nx} * ny * nz);
    std::vector<uint8_t> bytes(floats.size());
    for (uint64_t t = begin; t < end; ++t)
      for (uint32_t c = 0; c < v.channels; ++c) {
        size_t i = 0;
        for (uint32_t z = 0; z < nz; ++z)
          for (uint32_t y = 0; y < ny; ++y)
            for (uint32_t x = 0; x < nx; ++x, ++i) {
              const double value = field(c, x, y, z, static_cast<uint32_t>(t));
              floats[i] = v.holes && z < 3 + t % 4 ? std::numeric_limits<float>::quiet_NaN()
                                                   : static_cast<float>(value);
              bytes[i] = static_cast<uint8_t>(std::min(value, 255.0));
            }
        auto box = sized<bccsplat_box>();
        box.type = v.source;
        box.data = v.source == BCCSPLAT_TYPE_U8 ? static_cast<const void*>(bytes.data()) : floats.data();
        box.dims[0] = nx, box.dims[1] = ny, box.dims[2] = nz;
        const bccsplat_status s = bccsplat_writer_add_frame(writer, c, time_of(v, t), &box, 1);
        if (s != BCCSPLAT_OK) return s;
      }
    return BCCSPLAT_OK;
  }

  // options: what remains to be said about dims[3] and the way of writing.
  bccsplat_status write(const Variant& v, const std::string& file, bccsplat_writer_options o,
                        bccsplat_writer_report* report = nullptr, uint64_t* given = nullptr) {
    static const char* const names[] = {"density", "heat"};
    std::vector<bccsplat_channel_options> channels(v.channels, sized<bccsplat_channel_options>());
    for (uint32_t c = 0; c < v.channels; ++c) channels[c].name = names[c], channels[c].source_type = v.source;
    o.dims[0] = nx, o.dims[1] = ny, o.dims[2] = nz;
    o.channel_count = v.channels, o.channels = channels.data();
    if (v.holes) o.nonfinite = BCCSPLAT_NONFINITE_HOLE;
    if (o.ends == BCCSPLAT_ENDS_DEFAULT) o.ends = BCCSPLAT_ENDS_PREDICT;
    v.change(o);
    const double errors[] = {v.wavelet_error, v.wavelet_error};
    if (o.store == BCCSPLAT_STORE_WAVELETS && v.wavelet_error > 0) o.wavelet_errors = errors;
    bccsplat_writer* created = nullptr;
    bccsplat_status status = bccsplat_writer_create(device.get(), file.c_str(), &o, &created);
    const Writer writer(created);
    if (status != BCCSPLAT_OK) return status;
    uint64_t begin = 0, end = 0;
    EXPECT_OK(bccsplat_writer_get_part_frames(writer.get(), &begin, &end));
    if (given) *given = end - begin;
    status = add(writer.get(), v, begin, end);
    return status == BCCSPLAT_OK ? bccsplat_writer_finish(writer.get(), report) : status;
  }

  bccsplat_status continue_file(const Variant& v, const std::string& file, uint32_t from, uint32_t end,
                                bccsplat_writer_report* report = nullptr, uint64_t* given = nullptr) {
    std::vector<double> times;
    for (uint32_t t = 0; t < end; ++t) times.push_back(time_of(v, t));
    auto part = sized<bccsplat_series_part>();
    part.first = from, part.end = end, part.times = times.data();
    auto o = sized<bccsplat_writer_options>();
    o.dims[3] = end, o.partial = BCCSPLAT_PARTIAL_APPEND, o.part = &part;
    return write(v, file, o, report, given);
  }

  static std::vector<char> bytes_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  bccsplat_writer_options first_of(uint32_t frames) const {
    auto o = sized<bccsplat_writer_options>();
    o.dims[3] = frames, o.overwrite = 1;
    return o;
  }

  Device device = make_device();
  Folder folder;
  std::string path = folder.file("x.bcc4"), whole = folder.file("whole.bcc4");
};

// New frames of wavelets keep the error of the file, which nobody has to tell again.
TEST_F(Append, WaveletsKeepTheirError) {
  Variant v{"wavelets", BCCSPLAT_TYPE_U8, 1, false, false, store_wavelets};
  v.from = 40, v.frames = 55;
  ASSERT_OK(write(v, whole, first_of(v.frames)));
  ASSERT_OK(write(v, path, first_of(v.from)));
  const auto as_it_was = bytes_of(path);
  v.wavelet_error = 5;
  EXPECT_EQ(continue_file(v, path, v.from, v.frames), BCCSPLAT_ERROR_WRONG_STATE);
  EXPECT_NE(std::string(bccsplat_last_error()).find("error of wavelets is 8"), std::string::npos);
  EXPECT_EQ(bytes_of(path), as_it_was);
  for (const double no_less : {0.0, 20.0}) {
    v.wavelet_error = 8;
    ASSERT_OK(write(v, path, first_of(v.from)));
    v.wavelet_error = no_less;
    ASSERT_OK(continue_file(v, path, v.from, v.frames));
    EXPECT_EQ(bytes_of(path), bytes_of(whole));
  }
}

// The error that is chosen for a bound, which codes must be able to keep, is chosen once more.
TEST_F(Append, WaveletsGoOnUnderTheBoundThatTheyWereMadeWith) {
  Variant v{"a bound", BCCSPLAT_TYPE_U8,
            1,         false,
            false,     [](bccsplat_writer_options& o) {
              store_wavelets(o), o.abs_error = .4; }};
  v.wavelet_error = 0, v.from = 4, v.frames = 9;
  ASSERT_OK(write(v, whole, first_of(v.frames)));
  ASSERT_OK(write(v, path, first_of(v.from)));
  auto all = sized<bccsplat_writer_options>();
  all.dims[3] = v.frames, all.partial = BCCSPLAT_PARTIAL_APPEND;
  ASSERT_OK(write(v, path, all));
  EXPECT_EQ(bytes_of(path), bytes_of(whole));
}

TEST_F(Append, MakesTheFileOfAllFrames) {
  const Variant variants[] = {
      {"bytes", BCCSPLAT_TYPE_U8},
      {"floats"},
      {"two channels with holes", BCCSPLAT_TYPE_F32, 2, true},
      {"two channels of bytes", BCCSPLAT_TYPE_U8, 2},
      {"uneven times", BCCSPLAT_TYPE_U8, 1, false, true},
      {"mirrored", BCCSPLAT_TYPE_U8, 1, false, false,
       [](bccsplat_writer_options& o) { o.ends = BCCSPLAT_ENDS_MIRROR; }},
      {"dense in time", BCCSPLAT_TYPE_U8, 2, false, false,
       [](bccsplat_writer_options& o) { o.time_scale = 0.3; }},
      {"coarse in time", BCCSPLAT_TYPE_U8, 1, false, false,
       [](bccsplat_writer_options& o) { o.time_scale = 1.5; }},
      {"a distance per axis", BCCSPLAT_TYPE_U8, 1, false, false,
       [](bccsplat_writer_options& o) {
         const double scales[]{0.7, 0.9, 1.2, 1.6};
         std::copy(std::begin(scales), std::end(scales), o.scales);
       }},
      {"Cartesian", BCCSPLAT_TYPE_U8, 1, false, false,
       [](bccsplat_writer_options& o) { o.lattice = BCCSPLAT_LATTICE_CC; }},
      {"one more frame", BCCSPLAT_TYPE_U8, 1, false, false, [](bccsplat_writer_options&) {}, 43},
      {"few frames", BCCSPLAT_TYPE_U8, 1, false, false, [](bccsplat_writer_options&) {}, 4, 9},
      {"wavelets", BCCSPLAT_TYPE_U8, 1, false, false, store_wavelets, 40, 55},
      {"wavelets of two channels", BCCSPLAT_TYPE_U8, 2, false, true, store_wavelets, 31, 64},
      {"wavelets of few frames", BCCSPLAT_TYPE_U8, 1, false, false, store_wavelets, 4, 9},
      {"wavelets on D4*", BCCSPLAT_TYPE_U8, 1, false, false,
       [](bccsplat_writer_options& o) { o.store = BCCSPLAT_STORE_WAVELETS; }, 40, 55},
  };
  for (const Variant& v : variants) {
    SCOPED_TRACE(v.name);
    auto report = sized<bccsplat_writer_report>(), report_whole = report;
    uint64_t given = 0;
    ASSERT_OK(write(v, path, first_of(v.from)));
    ASSERT_OK(continue_file(v, path, v.from, v.frames, &report, &given));
    ASSERT_OK(write(v, whole, first_of(v.frames), &report_whole));
    EXPECT_EQ(bytes_of(path), bytes_of(whole));
    if (v.from >= 30) {
      EXPECT_LT(given, v.frames - v.from + 26);
      EXPECT_GT(report.slabs_reused, 0u);
    }
    EXPECT_EQ(report.frames, v.frames);
    EXPECT_EQ(report.sites_total, report_whole.sites_total);
    EXPECT_EQ(report.sites_kept, report_whole.sites_kept);
    EXPECT_EQ(report.holes, report_whole.holes);
    EXPECT_EQ(report.clamped, report_whole.clamped);
    EXPECT_EQ(report.cc_relevant, report_whole.cc_relevant);
    EXPECT_EQ(report.bytes_source, report_whole.bytes_source);
  }
}

// The frames that continue a file know too little of the earlier ones to be measured at coarser levels: what
// was measured before stays, near what all frames would have given.
TEST_F(Append, KeepsWhatWasMeasuredOfLevels) {
  const Variant v{.name = "levels", .change = [](bccsplat_writer_options& o) {
                    o.levels = 1, o.measure = BCCSPLAT_MEASURE_SOME;
                  }};
  const auto errors = [&](const std::string& file) {
    const Volume volume = open(device, file);
    std::array<double, 2> rmse{};
    for (uint32_t level = 0; level < 2; ++level) {
      auto info = sized<bccsplat_level_info>();
      EXPECT_OK(bccsplat_volume_get_level_info(volume.get(), level, &info));
      rmse[level] = info.relative_rmse;
    }
    return rmse;
  };
  ASSERT_OK(write(v, path, first_of(v.from)));
  ASSERT_OK(write(v, whole, first_of(v.frames)));
  const auto before = errors(path), at_once = errors(whole);
  ASSERT_OK(continue_file(v, path, v.from, v.frames));
  const auto after = errors(path);
  EXPECT_EQ(after, before);
  for (size_t level = 0; level < 2; ++level) {
    EXPECT_GT(after[level], 0);
    EXPECT_NEAR(after[level] / at_once[level], 1, 0.2) << level;
    RecordProperty("ratio" + std::to_string(level), std::to_string(after[level] / at_once[level]));
  }
}

TEST_F(Append, OfPartsOfPartsIsTheSame) {
  for (const Variant& v : {Variant{"bytes", BCCSPLAT_TYPE_U8},
                           Variant{"wavelets", BCCSPLAT_TYPE_U8, 1, false, false, store_wavelets}}) {
    SCOPED_TRACE(v.name);
    ASSERT_OK(write(v, path, first_of(30)));
    for (const uint32_t n : {31u, 33u, 43u, 44u}) {
      const uint32_t from = n == 31 ? 30 : n == 33 ? 31 : n == 43 ? 33 : 43;
      ASSERT_OK(continue_file(v, path, from, n));
    }
    ASSERT_OK(write(v, whole, first_of(44)));
    EXPECT_EQ(bytes_of(path), bytes_of(whole));
  }
}

TEST_F(Append, RefusesWhatItCannotContinue) {
  const Variant v{"bytes", BCCSPLAT_TYPE_U8};
  ASSERT_OK(write(v, path, first_of(30)));
  const auto old = bytes_of(path);
  const auto refused = [&](const Variant& changed, uint32_t from, bccsplat_status status, const char* text) {
    EXPECT_EQ(continue_file(changed, path, from, 44), status);
    EXPECT_NE(std::string(bccsplat_last_error()).find(text), std::string::npos) << bccsplat_last_error();
    EXPECT_EQ(bytes_of(path), old);
  };
  refused(v, 29, BCCSPLAT_ERROR_INVALID_ARGUMENT, "it has 30 frames");
  // A series shorter than the file: there are no times for the file's last frames.
  for (const uint32_t end : {1u, 12u})
    EXPECT_EQ(continue_file(v, path, 30, end), BCCSPLAT_ERROR_INVALID_ARGUMENT) << end;
  Variant other = v;
  other.uneven = true;
  refused(other, 30, BCCSPLAT_ERROR_WRONG_STATE, "is at time");
  other = v, other.source = BCCSPLAT_TYPE_F32;
  refused(other, 30, BCCSPLAT_ERROR_WRONG_STATE, "channel 0 (density): its type");
  other = v, other.change = [](bccsplat_writer_options& o) { o.abs_error = 1; };
  refused(other, 30, BCCSPLAT_ERROR_WRONG_STATE, "give all frames");
  other.change = [](bccsplat_writer_options& o) { o.store = BCCSPLAT_STORE_WAVELETS; };
  refused(other, 30, BCCSPLAT_ERROR_WRONG_STATE, "the lattices of its series");
  other.change = [](bccsplat_writer_options& o) { o.scale = 1.5; };
  refused(other, 30, BCCSPLAT_ERROR_WRONG_STATE, "planes along x");
  other.change = [](bccsplat_writer_options& o) { o.scales[1] = 1.5; };
  refused(other, 30, BCCSPLAT_ERROR_WRONG_STATE, "planes along y");
}

// The frames that are there stay as they are: they would be in other units, or elsewhere.
void twice_as_large(bccsplat_writer_options& o) {
  for (size_t a = 0; a < 3; ++a) o.affine[5 * a] = 2;
  o.affine[15] = 1;
}

TEST_F(Append, RefusesOtherUnitsAndPlaces) {
  Variant v{"bytes", BCCSPLAT_TYPE_U8};
  v.change = [](bccsplat_writer_options& o) { twice_as_large(o), o.spatial_unit = "m", o.time_unit = "s"; };
  ASSERT_OK(write(v, path, first_of(30)));
  const auto old = bytes_of(path);
  const auto refused = [&](void (*change)(bccsplat_writer_options&), const char* text) {
    Variant other = v;
    other.change = change;
    EXPECT_EQ(continue_file(other, path, 30, 44), BCCSPLAT_ERROR_WRONG_STATE) << text;
    EXPECT_NE(std::string(bccsplat_last_error()).find(text), std::string::npos) << bccsplat_last_error();
    EXPECT_EQ(bytes_of(path), old);
  };
  refused([](bccsplat_writer_options&) {}, "its samples lie elsewhere");
  refused([](bccsplat_writer_options& o) { twice_as_large(o), o.spatial_unit = "km"; },
          "its places are in m");
  refused([](bccsplat_writer_options& o) { twice_as_large(o), o.time_unit = "h"; }, "its times are in s");
  ASSERT_OK(continue_file(v, path, 30, 44));
}

} // namespace
} // namespace host
