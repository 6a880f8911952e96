// SPDX-License-Identifier: Apache-2.0
// A sea with a coast and moving ice: what is missing is missing at the resolution of the source, in every way
// of looking at a file, whatever the distance of its lattice.
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <thread>

#include "fit_writer.h"

namespace bccsplat::test {
namespace {

constexpr std::array<uint32_t, 4> dims{48, 32, 8, 6};

bool missing(double x, double y, double z, double t) {
  const bool land = x < 15 + 5 * std::sin(y / 4) + 3 * std::sin(1.3 * y) || std::hypot(x - 36, y - 20) < 3.4;
  return land || (z == 7 && y < 5 + 3 * std::sin(M_PI * t / 3 + x / 8));
}

double sea(double x, double y, double z, double t) {
  if (missing(x, y, z, t)) return NAN;
  return 12 + 6 * std::sin(x / 9 + 0.2 * t) * std::cos(y / 11) + 1.2 * z + 0.5 * std::sin(0.8 * x + y);
}

// The source sample that decides about a point: the nearest, half way the later one.
bool missing_at(const std::array<double, 4>& p) {
  std::array<double, 4> s;
  for (size_t a = 0; a < 4; ++a) s[a] = std::clamp(std::floor(p[a] + 0.5 + 1e-9), 0.0, dims[a] - 1.0);
  return missing(s[0], s[1], s[2], s[3]);
}

struct CoastFiles {
  TestDevice device;
  Source source = source_of(dims, BCCSPLAT_TYPE_F32, sea);
  std::map<std::string, Bytes> file;

  CoastFiles() {
    add("default", [](bccsplat_writer_options&) {});
    add("scale 1.3", [](bccsplat_writer_options& o) { o.scale = 1.3; });
    add("time scale", [](bccsplat_writer_options& o) { o.scale = 1.3, o.time_scale = 1.7; });
    add("corrected", [](bccsplat_writer_options& o) { o.scale = 1.3, o.abs_error = 0.05; });
    add("cc", [](bccsplat_writer_options& o) { o.scale = 1.3, o.lattice = BCCSPLAT_LATTICE_CC; });
  }
  void add(const std::string& name, const std::function<void(bccsplat_writer_options&)>& change) {
    auto options = sized<bccsplat_writer_options>();
    options.nonfinite = BCCSPLAT_NONFINITE_HOLE;
    change(options);
    const Written w = write_frames(device, source, options);
    EXPECT_EQ(w.status, BCCSPLAT_OK) << name << ": " << w.text;
    EXPECT_EQ(w.report.holes, 0u);
    EXPECT_GT(w.report.nonfinite, 10000u);
    file[name] = w.bytes;
  }
};

const CoastFiles& coast_files() {
  static const CoastFiles all;
  return all;
}

TEST(Coast, EverySourceSampleIsWhatItWas) {
  const CoastFiles& f = coast_files();
  for (const auto& [name, bytes] : f.file) {
    const OpenVolume volume(f.device, bytes);
    std::vector<std::array<double, 4>> points;
    for (size_t i = 0; i < f.source.values.size(); ++i)
      points.push_back(
          {double(i % 48), double(i / 48 % 32), double(i / (48 * 32) % 8), double(i / (48 * 32 * 8))});
    const std::vector<float> got = volume.at(points);
    size_t lost = 0, invented = 0;
    for (size_t i = 0; i < got.size(); ++i) {
      lost += std::isnan(got[i]) && !std::isnan(f.source.values[i]);
      invented += !std::isnan(got[i]) && std::isnan(f.source.values[i]);
    }
    EXPECT_EQ(lost, 0u) << name;
    EXPECT_EQ(invented, 0u) << name;
    for (uint32_t t = 0; t < dims[3]; ++t) {
      const std::vector<float> frame = volume.frame(t);
      for (size_t i = 0; i < frame.size(); ++i)
        ASSERT_EQ(std::isnan(frame[i]), std::isnan(f.source.values[t * frame.size() + i]))
            << name << " " << i;
    }
    auto info = sized<bccsplat_volume_info>();
    EXPECT_EQ(bccsplat_volume_get_info(volume.volume, &info), BCCSPLAT_OK);
    EXPECT_EQ(info.has_holes, 1);
    auto channel = sized<bccsplat_channel_info>();
    EXPECT_EQ(bccsplat_volume_get_channel_info(volume.volume, 0, &channel), BCCSPLAT_OK);
    EXPECT_EQ(channel.missing, uint64_t(std::count_if(f.source.values.begin(), f.source.values.end(),
                                                      [](double v) { return std::isnan(v); })));
    EXPECT_EQ(channel.holes, 0u);
  }
}

TEST(Coast, PointsInBetweenBelongToTheNearestSample) {
  const CoastFiles& f = coast_files();
  std::mt19937 random(9);
  std::vector<std::array<double, 4>> points(4000);
  for (auto& p : points)
    for (size_t a = 0; a < 4; ++a) p[a] = std::uniform_real_distribution<double>(0, dims[a] - 1.0)(random);
  for (const auto& [name, bytes] : f.file) {
    const OpenVolume volume(f.device, bytes);
    std::vector<float> values(points.size()), slopes(4 * points.size());
    EXPECT_EQ(bccsplat_volume_evaluate(volume.volume, points.size(), points[0].data(), values.data(),
                                       slopes.data()),
              BCCSPLAT_ERROR_HOLE);
    for (size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(std::isnan(values[i]), missing_at(points[i])) << name << " " << i;
      ASSERT_EQ(std::isnan(slopes[4 * i + 3]), missing_at(points[i])) << name << " " << i;
    }
  }
}

// Random points of a slice: they miss what the volume misses there. thick: of the hyperplane in the middle.
void expect_masked(const Cut& cut, const std::string& what) {
  std::mt19937 random(10);
  std::vector<double> uvw;
  for (int i = 0; i < 3000; ++i)
    for (size_t a = 0; a < 3; ++a)
      uvw.push_back(
          std::uniform_real_distribution<double>(cut.info.extent[a][0], cut.info.extent[a][1])(random));
  const size_t count = uvw.size() / 3;
  std::vector<float> values(count);
  bccsplat_slice_evaluate(cut.slice, count, uvw.data(), values.data(), nullptr);
  size_t some = 0, inside = 0;
  for (size_t i = 0; i < count; ++i) {
    std::array<double, 4> p;
    bool in = true;
    for (size_t a = 0; a < 4; ++a) {
      p[a] = cut.info.origin[a];
      for (size_t k = 0; k < 3; ++k) p[a] += cut.info.basis[k][a] * uvw[3 * i + k];
      in = in && p[a] > -1e-9 && p[a] < dims[a] - 1 + 1e-9;
    }
    if (!in) continue;
    ++inside;
    some += missing_at(p);
    ASSERT_EQ(std::isnan(values[i]), missing_at(p))
        << what << " " << p[0] << " " << p[1] << " " << p[2] << " " << p[3];
  }
  EXPECT_GT(inside, 500u) << what;
  EXPECT_GT(some, 50u) << what;
}

TEST(Coast, SlicesOfEveryKindMissWhatTheVolumeMisses) {
  const CoastFiles& f = coast_files();
  for (const auto& [name, bytes] : f.file) {
    const OpenVolume volume(f.device, bytes);
    for (const std::array<double, 5>& h : {std::array<double, 5>{0, 0, 0, 1, -3.4},
                                           {1, 0, 0, 0, -16},
                                           {0, 1, 0, 0, -5},
                                           {0, 0, 1, 0, -7},
                                           {0.3, 1, 0.2, 2.5, -20},
                                           {1, 0.1, 0, 6, -30}})
      expect_masked(Cut(volume, h), name + " slice " + std::to_string(h[0]) + " " + std::to_string(h[3]));
    auto thick = sized<bccsplat_slice_options>();
    thick.thickness = 1.2;
    expect_masked(Cut(volume, {0, 0, 0, 1, -2}, thick), name + " thick");
    expect_masked(Cut(volume, {1, 0, 0, 0, -16}, thick), name + " thick in x");
    auto dense = sized<bccsplat_slice_options>();
    dense.method = BCCSPLAT_METHOD_RESAMPLED;
    expect_masked(Cut(volume, {0, 0, 0, 1, -3.4}, dense), name + " resampled");
  }
  auto extracted = sized<bccsplat_slice_options>();
  extracted.method = BCCSPLAT_METHOD_EXTRACTED;
  const OpenVolume volume(f.device, f.file.at("default"));
  expect_masked(Cut(volume, {0, 0, 0, 1, -3}, extracted), "extracted");
}

// The largest value over some time: where it is land all that time, and nothing of what fills it beside the
// coast.
TEST(Coast, TheMaximumOverTimeIsOneOfData) {
  const CoastFiles& f = coast_files();
  const OpenVolume volume(f.device, f.file.at("default"));
  auto options = sized<bccsplat_slice_options>();
  options.thickness = 2, options.slab = BCCSPLAT_SLAB_MAXIMUM;
  const Cut cut(volume, {0, 0, 0, 1, -3}, options);
  std::vector<float> values(cut.info.dims[0] * cut.info.dims[1] * cut.info.dims[2]);
  ASSERT_EQ(bccsplat_slice_sample_grid(cut.slice, nullptr, values.data()), BCCSPLAT_OK);
  for (size_t i = 0; i < values.size(); ++i) {
    const double x = double(i % 48), y = double(i / 48 % 32), z = double(i / (48 * 32));
    const bool always = missing(x, y, z, 2) && missing(x, y, z, 3) && missing(x, y, z, 4);
    const bool never = !missing(x, y, z, 2) && !missing(x, y, z, 3) && !missing(x, y, z, 4);
    if (always) {
      EXPECT_TRUE(std::isnan(values[i])) << i;
    }
    if (!never) continue;
    const double most = std::max({sea(x, y, z, 2), sea(x, y, z, 3), sea(x, y, z, 4)});
    EXPECT_NEAR(double(values[i]), most, 1.2) << x << " " << y << " " << z;
  }
}

// ---- Files that go on ----

// What the golden files v5_site_holes and v5_site_holes_longer were made of, by a version that knew no masks.
std::vector<float> older_frame(uint32_t t) {
  std::vector<float> values;
  for (int z = 0; z < 7; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 9; ++x)
        values.push_back(x < 3 && z > 1
                             ? NAN
                             : static_cast<float>((x * 7 + y * 3 + z * 5 + static_cast<int>(t) * 2) % 13));
  return values;
}

Bytes read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// A series that has holes of the lattice keeps them when it goes on.
TEST(Coast, OlderFilesGoOnAsTheyBegan) {
  constexpr uint32_t before = 30, frames = 44;
  const TestDevice device;
  const std::string golden = BCCSPLAT_GOLDEN_DIR, path = testing::TempDir() + "bccsplat-older.bcc4";
  for (const bool all : {false, true}) {
    std::filesystem::copy_file(golden + "/v5_site_holes.bcc4", path,
                               std::filesystem::copy_options::overwrite_existing);
    std::vector<double> times;
    for (uint32_t t = 0; t < frames; ++t) times.push_back(t);
    auto part = sized<bccsplat_series_part>();
    part.first = before, part.end = frames, part.times = times.data();
    auto o = sized<bccsplat_writer_options>();
    o.dims[0] = 9, o.dims[1] = 8, o.dims[2] = 7, o.dims[3] = frames;
    o.nonfinite = BCCSPLAT_NONFINITE_HOLE, o.ends = BCCSPLAT_ENDS_PREDICT,
    o.partial = BCCSPLAT_PARTIAL_APPEND;
    if (!all) o.part = &part;
    bccsplat_writer* writer = nullptr;
    ASSERT_EQ(bccsplat_writer_create(device.device, path.c_str(), &o, &writer), BCCSPLAT_OK)
        << bccsplat_last_error();
    uint64_t first = 0, end = 0;
    EXPECT_EQ(bccsplat_writer_get_part_frames(writer, &first, &end), BCCSPLAT_OK);
    EXPECT_EQ(first > 0, !all);
    for (auto t = static_cast<uint32_t>(first); t < end; ++t) {
      const std::vector<float> values = older_frame(t);
      auto box = sized<bccsplat_box>();
      box.type = BCCSPLAT_TYPE_F32, box.data = values.data(), box.dims[0] = 9, box.dims[1] = 8,
      box.dims[2] = 7;
      ASSERT_EQ(bccsplat_writer_add_frame(writer, 0, t, &box, 1), BCCSPLAT_OK) << bccsplat_last_error();
    }
    EXPECT_EQ(bccsplat_writer_finish(writer, nullptr), BCCSPLAT_OK) << bccsplat_last_error();
    bccsplat_writer_release(writer);
    // Samples may be rounded otherwise than where the golden files were made; what is a hole is the same.
    const Bytes went_on = read_file(path), expected = read_file(golden + "/v5_site_holes_longer.bcc4");
    const OpenVolume a(device, went_on), b(device, expected);
    auto got = sized<bccsplat_channel_info>(), want = got;
    EXPECT_EQ(bccsplat_volume_get_channel_info(a.volume, 0, &got), BCCSPLAT_OK);
    EXPECT_EQ(bccsplat_volume_get_channel_info(b.volume, 0, &want), BCCSPLAT_OK);
    EXPECT_EQ(got.holes, want.holes);
    EXPECT_EQ(got.missing, 0u);
    for (uint32_t t = 0; t < frames; t += 3) {
      const std::vector<float> x = a.frame(t), y = b.frame(t);
      for (size_t i = 0; i < x.size(); ++i) {
        ASSERT_EQ(std::isnan(x[i]), std::isnan(y[i])) << t << " " << i;
        ASSERT_TRUE(std::isnan(x[i]) || std::fabs(x[i] - y[i]) < 1e-4f) << t << " " << i;
      }
    }
  }
  std::filesystem::remove(path);
}

// What a writer left takes its place in the file of another, masks between the slabs.
TEST(Coast, AResumedFileIsTheSame) {
  const TestDevice device;
  const Source s = source_of({30, 20, 8, 60}, BCCSPLAT_TYPE_F32, [](double x, double y, double z, double t) {
    return x < 5 + std::fmod(t, 4) ? double(NAN) : std::fmod(17 * x + 29 * y + 5 * z + 11 * t, 23);
  });
  const std::string path = testing::TempDir() + "bccsplat-resumed.bcc4";
  const auto write = [&](int32_t partial, uint32_t pause, uint32_t end, bccsplat_writer_report* report) {
    auto o = sized<bccsplat_writer_options>();
    std::copy(s.dims.begin(), s.dims.end(), o.dims);
    o.nonfinite = BCCSPLAT_NONFINITE_HOLE, o.partial = partial, o.overwrite = 1;
    bccsplat_writer* writer = nullptr;
    EXPECT_EQ(bccsplat_writer_create(device.device, path.c_str(), &o, &writer), BCCSPLAT_OK)
        << bccsplat_last_error();
    for (uint32_t t = 0; t < end; ++t) {
      const Bytes data = frame_bytes(s, t);
      auto box = sized<bccsplat_box>();
      box.type = s.type, box.data = data.data();
      for (size_t a = 0; a < 3; ++a) box.dims[a] = s.dims[a];
      // What is written is recorded once a second.
      if (t == pause) std::this_thread::sleep_for(std::chrono::milliseconds(1100));
      EXPECT_EQ(bccsplat_writer_add_frame(writer, 0, t, &box, 1), BCCSPLAT_OK) << bccsplat_last_error();
    }
    if (end == s.dims[3]) {
      EXPECT_EQ(bccsplat_writer_finish(writer, report), BCCSPLAT_OK) << bccsplat_last_error();
    }
    bccsplat_writer_release(writer);
  };
  auto report = sized<bccsplat_writer_report>();
  write(BCCSPLAT_PARTIAL_DEFAULT, UINT32_MAX, s.dims[3], &report);
  const Bytes whole = read_file(path);
  std::filesystem::remove(path);
  write(BCCSPLAT_PARTIAL_KEEP, 36, 50, &report);
  EXPECT_FALSE(std::filesystem::exists(path));
  write(BCCSPLAT_PARTIAL_RESUME, UINT32_MAX, s.dims[3], &report);
  EXPECT_GT(report.slabs_reused, 1u);
  EXPECT_TRUE(read_file(path) == whole);
  std::filesystem::remove(path);
}

// ---- Pictures ----

struct Picture {
  uint32_t width = 192, height = 128; // four pixels to a source sample
  std::vector<float> rgba;
  // Where the centre of a pixel lies in the plane of x and y.
  [[nodiscard]] std::array<double, 2> place(uint32_t x, uint32_t y) const {
    return {23.5 + (x + 0.5 - width / 2.0) / 4, 15.5 - (y + 0.5 - height / 2.0) / 4};
  }
};

// Seen along z: what is opaque is the field, whatever its value.
Picture draw(const Cut& cut, const TestDevice& device, int32_t mode, int32_t quality,
             const bccsplat_trail* trail, bool reference = false, double iso = 0) {
  Picture p;
  bccsplat_renderer* renderer = nullptr;
  EXPECT_EQ(bccsplat_renderer_create(device.device, &renderer), BCCSPLAT_OK);
  EXPECT_EQ(bccsplat_renderer_set_slice(renderer, cut.slice), BCCSPLAT_OK);
  const double colors[] = {-100, 1, 1, 1, 100, 1, 1, 1}, opacities[] = {-100, 0.5, 100, 0.5};
  auto function = sized<bccsplat_transfer_function>();
  function.colors = colors, function.color_count = 2, function.opacities = opacities,
  function.opacity_count = 2;
  EXPECT_EQ(bccsplat_renderer_set_transfer_function(renderer, &function), BCCSPLAT_OK);
  auto camera = sized<bccsplat_camera>();
  camera.projection = BCCSPLAT_PROJECTION_ORTHOGRAPHIC;
  camera.position[0] = camera.target[0] = 23.5, camera.position[1] = camera.target[1] = 15.5;
  camera.position[2] = 60, camera.target[2] = 3.5, camera.up[1] = 1, camera.ortho_height = 32;
  EXPECT_EQ(bccsplat_renderer_set_camera(renderer, &camera), BCCSPLAT_OK) << bccsplat_last_error();
  auto options = sized<bccsplat_render_options>();
  options.mode = mode, options.quality = quality, options.reference = reference, options.iso_value = iso;
  if (mode == BCCSPLAT_MODE_ISOSURFACE) options.set_mask = BCCSPLAT_RENDER_SET_ISO;
  EXPECT_EQ(bccsplat_renderer_set_options(renderer, &options), BCCSPLAT_OK) << bccsplat_last_error();
  EXPECT_EQ(bccsplat_renderer_set_trail(renderer, trail), BCCSPLAT_OK) << bccsplat_last_error();
  bccsplat_frame* frame = nullptr;
  EXPECT_EQ(bccsplat_frame_create(device.device, p.width, p.height, BCCSPLAT_FRAME_RGBA, &frame),
            BCCSPLAT_OK);
  EXPECT_EQ(bccsplat_renderer_render(renderer, frame), BCCSPLAT_OK) << bccsplat_last_error();
  auto plane = sized<bccsplat_plane>();
  EXPECT_EQ(bccsplat_frame_get_channel(frame, BCCSPLAT_FRAME_RGBA, &plane), BCCSPLAT_OK);
  for (uint32_t y = 0; y < p.height; ++y) {
    const float* row = plane.pixels + y * (plane.row_bytes / sizeof(float));
    p.rgba.insert(p.rgba.end(), row, row + 4 * size_t{p.width});
  }
  bccsplat_frame_release(frame);
  bccsplat_renderer_release(renderer);
  return p;
}

// Land is clear in every pixel, the sea is drawn in every pixel.
TEST(Coast, PicturesAreClearWhereItIsLandAndNowhereElse) {
  const CoastFiles& f = coast_files();
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -1, trail.interval[1] = 0;
  for (const auto& [name, bytes] : f.file) {
    const OpenVolume volume(f.device, bytes);
    const Cut cut(volume, {0, 0, 0, 1, -3});
    for (const auto& [mode, quality, with_trail, reference] :
         {std::tuple{BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_QUALITY_NORMAL, false, false},
          std::tuple{BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_QUALITY_DRAFT, false, false},
          std::tuple{BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_QUALITY_NORMAL, false, true},
          std::tuple{BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_QUALITY_NORMAL, true, false},
          std::tuple{BCCSPLAT_MODE_MAXIMUM, BCCSPLAT_QUALITY_NORMAL, false, false},
          std::tuple{BCCSPLAT_MODE_MAXIMUM, BCCSPLAT_QUALITY_DRAFT, false, false},
          std::tuple{BCCSPLAT_MODE_MAXIMUM, BCCSPLAT_QUALITY_NORMAL, false, true}}) {
      if (reference && name != "scale 1.3") continue; // slow
      SCOPED_TRACE(name + " mode " + std::to_string(mode) + " quality " + std::to_string(quality) +
                   (with_trail ? " trail" : "") + (reference ? " reference" : ""));
      const Picture p = draw(cut, f.device, mode, quality, with_trail ? &trail : nullptr, reference);
      size_t lost = 0, invented = 0, pixels = 0;
      for (uint32_t y = 0; y < p.height; ++y)
        for (uint32_t x = 0; x < p.width; ++x) {
          const auto [at_x, at_y] = p.place(x, y);
          if (!(at_x > 0 && at_x < 47 && at_y > 0 && at_y < 31)) continue;
          const float alpha = p.rgba[4 * (size_t{y} * p.width + x) + 3];
          const bool land = missing_at({at_x, at_y, 3, 3}); // at z = 3 no ice
          ++pixels;
          lost += !land && !(alpha > 0.3f);
          invented += land && alpha > 0;
        }
      EXPECT_GT(pixels, 20000u);
      EXPECT_EQ(lost, 0u);
      EXPECT_EQ(invented, 0u);
    }
  }
}

// The sum of what lies along z between the faces, by the source samples; of seven depths, none of land.
double depth_integral(double x, double y, double t) {
  double sum = 0;
  for (int z = 0; z < 8; ++z) {
    const double v = sea(std::floor(x + 0.5), std::floor(y + 0.5), z, t);
    if (std::isfinite(v)) sum += v * (z == 0 || z == 7 ? 0.5 : 1);
  }
  return sum;
}

TEST(Coast, XraysAddUpTheSeaAlone) {
  const CoastFiles& f = coast_files();
  for (const char* name : {"default", "scale 1.3", "corrected", "cc"}) {
    const OpenVolume volume(f.device, f.file.at(name));
    const Cut cut(volume, {0, 0, 0, 1, -3});
    for (const int32_t quality : {BCCSPLAT_QUALITY_NORMAL, BCCSPLAT_QUALITY_DRAFT}) {
      SCOPED_TRACE(std::string(name) + " " + std::to_string(quality));
      const Picture p = draw(cut, f.device, BCCSPLAT_MODE_XRAY, quality, nullptr);
      double largest_on_land = 0, off = 0, all = 0;
      for (uint32_t y = 0; y < p.height; ++y)
        for (uint32_t x = 0; x < p.width; ++x) {
          const auto [at_x, at_y] = p.place(x, y);
          if (!(at_x > 0 && at_x < 47 && at_y > 0 && at_y < 31)) continue;
          const double got = double(p.rgba[4 * (size_t{y} * p.width + x)]);
          if (missing_at({at_x, at_y, 3, 3})) {
            largest_on_land = larger(largest_on_land, std::fabs(got));
          } else {
            off += std::fabs(got - depth_integral(at_x, at_y, 3)), all += depth_integral(at_x, at_y, 3);
          }
        }
      EXPECT_EQ(largest_on_land, 0);
      EXPECT_LT(off, 0.05 * all);
    }
  }
}

// Seen from the side of the land: an isosurface is where the sea has the value, not where it ends.
TEST(Coast, IsosurfacesDoNotFollowTheCoast) {
  const CoastFiles& f = coast_files();
  for (const char* name : {"default", "scale 1.3", "corrected", "cc"}) {
    const OpenVolume volume(f.device, f.file.at(name));
    const Cut cut(volume, {0, 0, 0, 1, -3});
    const Picture p =
        draw(cut, f.device, BCCSPLAT_MODE_ISOSURFACE, BCCSPLAT_QUALITY_NORMAL, nullptr, false, 14);
    size_t invented = 0, lost = 0, drawn = 0;
    for (uint32_t y = 0; y < p.height; ++y)
      for (uint32_t x = 0; x < p.width; ++x) {
        const auto [at_x, at_y] = p.place(x, y);
        if (!(at_x > 1 && at_x < 46 && at_y > 1 && at_y < 30)) continue;
        const float alpha = p.rgba[4 * (size_t{y} * p.width + x) + 3];
        if (missing_at({at_x, at_y, 3, 3})) {
          invented += alpha > 0;
          continue;
        }
        // Values rise with z by more than they change within a sample: met, if it is between those at the
        // ends.
        const bool ice = missing_at({at_x, at_y, 7, 3});
        const double low = sea(std::floor(at_x + .5), std::floor(at_y + .5), 0, 3),
                     high = sea(std::floor(at_x + .5), std::floor(at_y + .5), ice ? 6 : 7, 3);
        if (low < 13 && high > 15) ++drawn, lost += !(alpha > 0.9f);
        if (low > 15.5 || high < 12.5) invented += alpha > 0.1f;
      }
    EXPECT_EQ(invented, 0u) << name;
    EXPECT_GT(drawn, 1000u) << name;
    EXPECT_EQ(lost, 0u) << name;
  }
}

// Ice lies on the uppermost samples: it takes the half of a sample off the sea beneath.
TEST(Coast, IceIsAsThinAsTheSource) {
  const CoastFiles& f = coast_files();
  for (const char* name : {"default", "scale 1.3"}) {
    const OpenVolume volume(f.device, f.file.at(name));
    const Cut cut(volume, {0, 0, 0, 1, -3});
    const Picture p = draw(cut, f.device, BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_QUALITY_NORMAL, nullptr);
    double iced = 0, open = 0;
    size_t iced_count = 0, open_count = 0;
    for (uint32_t y = 0; y < p.height; ++y)
      for (uint32_t x = 0; x < p.width; ++x) {
        const auto [at_x, at_y] = p.place(x, y);
        if (!(at_x > 0 && at_x < 47 && at_y > 0 && at_y < 31) || missing_at({at_x, at_y, 3, 3})) continue;
        const double through = 1 - double(p.rgba[4 * (size_t{y} * p.width + x) + 3]);
        if (missing_at({at_x, at_y, 7, 3}))
          iced += through, ++iced_count;
        else
          open += through, ++open_count;
      }
    ASSERT_GT(iced_count, 500u);
    // Seven samples of depth, half of one less under ice; each lets half of the light through.
    const double lost = std::log(iced / double(iced_count) / (open / double(open_count))) / std::log(2.0);
    EXPECT_NEAR(lost, 0.5, 0.3) << name;
  }
}

// The fill of a file in blocks looks no further than some distances: what is there is as close to its source.
TEST(Coast, ABoundedFillKeepsTheSea) {
  constexpr std::array<uint32_t, 4> n{84, 60, 48, 3};
  const auto land = [](double x, double y, double z) {
    return x < 30 + 5 * std::sin(y / 6) + 3 * std::sin(z / 3) ||
           std::hypot(x - 60, y - 30, 1.3 * (z - 20)) < 12;
  };
  const Source source = source_of(n, BCCSPLAT_TYPE_F32, [&](double x, double y, double z, double t) {
    if (land(x, y, z)) return double(NAN);
    return 290 + 6 * std::sin(x / 3 + .2 * t) * std::cos(y / 4) + .3 * z + 2 * std::sin(z / 2.5 + x / 5);
  });
  const TestDevice device;
  std::array<std::array<double, 3>, 2> decibels{}; // by rule and level
  for (int fixed = 0; fixed < 2; ++fixed) {
    auto options = sized<bccsplat_writer_options>();
    options.nonfinite = BCCSPLAT_NONFINITE_HOLE, options.levels = 2, options.fixed_predictions = fixed;
    const Written w = write_frames(device, source, options);
    ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
    const OpenVolume volume(device, w.bytes);
    for (uint32_t level = 0; level < 3; ++level) {
      auto slice = sized<bccsplat_slice_options>();
      slice.level = level;
      const Cut cut(volume, {0, 0, 0, 1, -1}, slice);
      const std::vector<float> got = cut.samples();
      double squares = 0;
      size_t count = 0;
      for (size_t i = 0; i < got.size(); ++i) {
        const auto p = cut.place(i);
        const double want =
            source.values[((n[2] + size_t(p[2])) * n[1] + size_t(p[1])) * n[0] + size_t(p[0])];
        if (std::isnan(want)) continue;
        ASSERT_FALSE(std::isnan(got[i]));
        squares += (got[i] - want) * (got[i] - want), ++count;
      }
      ASSERT_GT(count, level == 0 ? 100000u : 500u);
      decibels[fixed][level] = -10 * std::log10(squares / double(count));
    }
  }
  for (size_t level = 0; level < 3; ++level)
    EXPECT_GT(decibels[1][level], decibels[0][level] - 0.1) << "level " << level;
}

// Frames that are missing altogether: what lies beside them is as if they had been between their neighbours.
TEST(Coast, MomentsBesideMissingFramesAreThoseOfTheField) {
  constexpr std::array<uint32_t, 4> n{20, 18, 12, 24};
  const auto gone = [](double t) { return t == 7 || t == 14 || t == 15; };
  const auto there = [](double x, double y, double z, double t) {
    return 100 + 24 * std::sin(M_PI * t / 12) + 3 * std::sin(x / 4 + y / 5) + z;
  };
  const Source source = source_of(n, BCCSPLAT_TYPE_F32, [&](double x, double y, double z, double t) {
    return gone(t) ? NAN : there(x, y, z, t);
  });
  const TestDevice device;
  const auto worst = [&](const std::function<void(bccsplat_writer_options&)>& change) {
    auto channel = sized<bccsplat_channel_options>();
    channel.air = 100, channel.set_mask = BCCSPLAT_CHANNEL_SET_AIR;
    auto options = sized<bccsplat_writer_options>();
    options.nonfinite = BCCSPLAT_NONFINITE_HOLE;
    options.channel_count = 1, options.channels = &channel;
    change(options);
    const Written w = write_frames(device, source, options);
    EXPECT_EQ(w.status, BCCSPLAT_OK) << w.text;
    const OpenVolume volume(device, w.bytes);
    std::vector<std::array<double, 4>> points;
    for (const double t : {6.0, 6.4, 7.6, 8.0, 13.0, 13.4, 15.6, 16.0})
      for (const double x : {6.0, 9.5, 13.0}) points.push_back({x, 8, 5.5, t});
    const std::vector<float> got = volume.at(points);
    double largest = 0;
    for (size_t i = 0; i < got.size(); ++i) {
      const auto& [x, y, z, t] = points[i];
      EXPECT_FALSE(std::isnan(got[i])) << t;
      largest = larger(largest, std::fabs(got[i] - there(x, y, z, t)));
    }
    return largest;
  };
  EXPECT_LT(worst([](bccsplat_writer_options&) {}), 0.9);
  EXPECT_LT(worst([](bccsplat_writer_options& o) { o.ends = BCCSPLAT_ENDS_PERIODIC; }), 0.9);
  EXPECT_LT(worst([](bccsplat_writer_options& o) { o.lattice = BCCSPLAT_LATTICE_CC, o.time_scale = 1.3; }),
            0.9);
}

} // namespace
} // namespace bccsplat::test
