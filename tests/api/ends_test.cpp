// SPDX-License-Identifier: Apache-2.0
// What a writer does at the ends of a series, and what stands in the file about it.
#include "support.h"

namespace host {
namespace {

// Returns the sites of the lattice, of layers beyond the ends as well.
uint64_t write_file(const Device& device, const std::string& path, const Series& s, int32_t ends,
                    int32_t partial = 0, bool length_known = true,
                    int32_t lattice = BCCSPLAT_LATTICE_D4STAR) {
  bccsplat_writer_options o = options_of(s);
  o.ends = ends, o.partial = partial, o.lattice = lattice;
  if (!length_known) o.dims[3] = 0;
  const Writer w = make_writer(device, path, o);
  EXPECT_OK(add_frames(w.get(), s));
  EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
  auto info = sized<bccsplat_volume_info>();
  EXPECT_OK(bccsplat_volume_get_info(open(device, path).get(), &info));
  return info.sites_total;
}

// Largest error near the blob in the first and the last frame.
double worst_at_ends(const Device& device, const std::string& path, const Series& s) {
  const Volume volume = open(device, path);
  std::vector<double> points;
  for (uint32_t t : {0u, s.nt - 1})
    for (int i = 0; i < 1000; ++i)
      for (const double v : {4 + 0.81 * (i % 10), 6 + 0.77 * (i / 10 % 10), 5 + 0.71 * (i / 100), 1.0 * t})
        points.push_back(v);
  std::vector<float> values(points.size() / 4);
  EXPECT_OK(bccsplat_volume_evaluate(volume.get(), values.size(), points.data(), values.data(), nullptr));
  double worst = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    const double* p = &points[4 * i];
    worst = larger(worst, std::fabs(values[i] - s.field(p[0], p[1], p[2], p[3])));
  }
  return worst;
}

TEST(WriterEnds, PredictionIsTheDefault) {
  const Device device = make_device();
  const Folder folder;
  const Series s{.nt = 24};
  const std::string by_default = folder.file("d.bcc4"), mirrored = folder.file("m.bcc4");
  EXPECT_GT(write_file(device, by_default, s, BCCSPLAT_ENDS_DEFAULT),
            write_file(device, mirrored, s, BCCSPLAT_ENDS_MIRROR));
  EXPECT_LT(4 * worst_at_ends(device, by_default, s), worst_at_ends(device, mirrored, s));
  // Unasked only where it costs a fifth at most; a still has no time.
  const auto predicts = [&](uint32_t frames, int32_t ends, bool length_known,
                            int32_t lattice = BCCSPLAT_LATTICE_D4STAR) {
    const auto sites = [&](int32_t of) {
      const std::string path = folder.file("few.bcc4");
      const uint64_t count = write_file(device, path, Series{.nt = frames}, of, 0, length_known, lattice);
      std::filesystem::remove(path);
      return count;
    };
    return sites(ends) > sites(BCCSPLAT_ENDS_MIRROR);
  };
  EXPECT_FALSE(predicts(13, BCCSPLAT_ENDS_DEFAULT, true));
  EXPECT_TRUE(predicts(14, BCCSPLAT_ENDS_DEFAULT, true));
  EXPECT_FALSE(predicts(14, BCCSPLAT_ENDS_DEFAULT, false));
  EXPECT_FALSE(predicts(24, BCCSPLAT_ENDS_DEFAULT, true, BCCSPLAT_LATTICE_CC));
  EXPECT_TRUE(predicts(4, BCCSPLAT_ENDS_PREDICT, true, BCCSPLAT_LATTICE_CC));
  EXPECT_TRUE(predicts(3, BCCSPLAT_ENDS_PREDICT, false));
  EXPECT_TRUE(predicts(4, BCCSPLAT_ENDS_PREDICT, true));
  EXPECT_FALSE(predicts(1, BCCSPLAT_ENDS_PREDICT, true));
  auto bad = options_of(s);
  bad.ends = 4;
  bccsplat_writer* none = nullptr;
  EXPECT_EQ(bccsplat_writer_create(device.get(), folder.file("bad.bcc4").c_str(), &bad, &none),
            BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

TEST(WriterEnds, ASeriesThatIsAppendedToKeepsItsEnds) {
  const Device device = make_device();
  const Folder folder;
  const Series all{.nt = 24}, first{.nt = 16};
  for (const int32_t ends : {BCCSPLAT_ENDS_PREDICT, BCCSPLAT_ENDS_MIRROR}) {
    const std::string path = folder.file("a.bcc4"), whole = folder.file("w.bcc4");
    write_file(device, path, first, ends);
    EXPECT_EQ(write_file(device, path, all, BCCSPLAT_ENDS_DEFAULT, BCCSPLAT_PARTIAL_APPEND),
              write_file(device, whole, all, ends, 0, false));
    const Volume a = open(device, path), b = open(device, whole);
    std::vector<double> points;
    for (int i = 0; i < 2000; ++i)
      for (const double v : {0.9 * (i % 20), 0.8 * (i / 20 % 20), 3.3 * (i / 400), 23.0 * (i % 7) / 6})
        points.push_back(v);
    std::vector<float> x(2000), y(2000);
    EXPECT_OK(bccsplat_volume_evaluate(a.get(), 2000, points.data(), x.data(), nullptr));
    EXPECT_OK(bccsplat_volume_evaluate(b.get(), 2000, points.data(), y.data(), nullptr));
    EXPECT_EQ(x, y);
    std::filesystem::remove(path), std::filesystem::remove(whole);
  }
}

TEST(WriterEnds, APeriodicSeriesGoesOnToItsFirstFrame) {
  const Device device = make_device();
  const Folder folder;
  const auto round = [](double x, double y, double z, double t) {
    return 50 + 20 * std::cos(0.3 * x - 0.2 * y + 0.25 * z - 3.14159265358979 * t / 5);
  };
  const Series s{.nt = 10, .first = 3, .step = 0.5, .field = round};
  const std::string path = folder.file("p.bcc4");
  write_file(device, path, s, BCCSPLAT_ENDS_PERIODIC);
  const Volume volume = open(device, path);
  auto info = sized<bccsplat_volume_info>();
  ASSERT_OK(bccsplat_volume_get_info(volume.get(), &info));
  EXPECT_EQ(info.time_periodic, 1u);
  EXPECT_EQ(info.time_last, 7.5);
  EXPECT_EQ(info.time_end, 8);
  double index = 0;
  EXPECT_OK(bccsplat_volume_time_to_index(volume.get(), 7.75, &index));
  EXPECT_EQ(index, 9.5);
  EXPECT_EQ(bccsplat_volume_time_to_index(volume.get(), 8.01, &index), BCCSPLAT_ERROR_OUT_OF_DOMAIN);
  const std::vector<double> points{9, 9, 9, 9.5, 9, 9, 9, 10, 9, 9, 9, 0, 9, 9, 9, 10.01};
  std::vector<float> values(4), gradients(16);
  EXPECT_EQ(bccsplat_volume_evaluate(volume.get(), 4, points.data(), values.data(), gradients.data()),
            BCCSPLAT_ERROR_OUT_OF_DOMAIN);
  EXPECT_NEAR(values[0], round(9, 9, 9, 9.5), 0.2);
  EXPECT_NEAR(values[1], values[2], 1e-4);
  EXPECT_NEAR(gradients[7], gradients[11], 1e-3);
  EXPECT_TRUE(std::isnan(values[3]));
  const Slice late = cut_time(volume, 9.5);
  ASSERT_TRUE(late);
  // As long after the last frame as frames are apart in the mean.
  const auto uneven = folder.file("u.bcc4");
  {
    auto o = options_of(s);
    o.ends = BCCSPLAT_ENDS_PERIODIC;
    const Writer w = make_writer(device, uneven, o);
    const std::vector<float> frame(size_t{s.nx} * s.ny * s.nz, 1.0f);
    auto box = sized<bccsplat_box>();
    box.type = BCCSPLAT_TYPE_F32, box.data = frame.data();
    box.dims[0] = s.nx, box.dims[1] = s.ny, box.dims[2] = s.nz;
    for (uint32_t t = 0; t < s.nt; ++t)
      ASSERT_OK(bccsplat_writer_add_frame(w.get(), 0, t + (t > 4 ? 0.9 : 0), &box, 1));
    ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
  }
  ASSERT_OK(bccsplat_volume_get_info(open(device, uneven).get(), &info));
  EXPECT_EQ(info.time_uniform, 0u);
  EXPECT_NEAR(info.time_end, 9.9 + 1.1, 1e-9);
  // What cannot be is refused by name.
  auto bad = options_of(s);
  bad.ends = BCCSPLAT_ENDS_PERIODIC, bad.dims[3] = 0;
  bccsplat_writer* none = nullptr;
  EXPECT_EQ(bccsplat_writer_create(device.get(), folder.file("x.bcc4").c_str(), &bad, &none),
            BCCSPLAT_ERROR_INVALID_ARGUMENT);
  bad = options_of(s);
  bad.partial = BCCSPLAT_PARTIAL_APPEND;
  EXPECT_EQ(bccsplat_writer_create(device.get(), path.c_str(), &bad, &none), BCCSPLAT_ERROR_UNSUPPORTED);
  bad = options_of(s);
  bad.ends = BCCSPLAT_ENDS_PERIODIC, bad.live = 1;
  EXPECT_EQ(bccsplat_writer_create(device.get(), folder.file("x.bcc4").c_str(), &bad, &none),
            BCCSPLAT_ERROR_UNSUPPORTED);
  // One that ends early stays as it was, and its frames may still come.
  bad.live = 0;
  const Writer early = make_writer(device, folder.file("early.bcc4"), bad);
  const std::vector<float> frame(size_t{s.nx} * s.ny * s.nz, 1.0f);
  auto box = sized<bccsplat_box>();
  box.type = BCCSPLAT_TYPE_F32, box.data = frame.data();
  box.dims[0] = s.nx, box.dims[1] = s.ny, box.dims[2] = s.nz;
  for (uint32_t t = 0; t < s.nt; ++t) {
    EXPECT_EQ(bccsplat_writer_finish_short(early.get(), nullptr),
              t == 0 ? BCCSPLAT_ERROR_WRONG_STATE : BCCSPLAT_ERROR_UNSUPPORTED);
    ASSERT_OK(bccsplat_writer_add_frame(early.get(), 0, t, &box, 1));
  }
  ASSERT_OK(bccsplat_writer_finish_short(early.get(), nullptr));
}

// A picture of a moment of a ball that goes round, with what the volume held before it.
std::vector<float> picture_of_trail(const Device& device, const Volume& volume, double frame, double back,
                                    int32_t content, double spacing = 0) {
  constexpr uint32_t size = 48;
  bccsplat_renderer* r = nullptr;
  EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
  const Renderer renderer(r);
  auto cut = sized<bccsplat_slice_options>();
  cut.spacing = spacing;
  auto h = sized<bccsplat_hyperplane>();
  h.d = 1, h.e = -frame;
  bccsplat_slice* cut_slice = nullptr;
  EXPECT_OK(bccsplat_slice_create(volume.get(), &h, &cut, &cut_slice));
  const Slice slice(cut_slice);
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -back, trail.content = content, trail.samples = 8;
  const double colors[] = {0, 1, 1, 1, 100, 1, 0, 0}, opacities[] = {10, 0, 60, 0.5};
  auto f = sized<bccsplat_transfer_function>();
  f.color_count = f.opacity_count = 2, f.colors = colors, f.opacities = opacities;
  EXPECT_OK(bccsplat_renderer_set_slice(r, slice.get()));
  EXPECT_OK(bccsplat_renderer_set_transfer_function(r, &f));
  EXPECT_OK(bccsplat_renderer_set_trail(r, back > 0 ? &trail : nullptr));
  bccsplat_frame* made = nullptr;
  EXPECT_OK(bccsplat_frame_create(device.get(), size, size, BCCSPLAT_FRAME_RGBA, &made));
  const Frame image(made);
  EXPECT_OK(bccsplat_renderer_render(r, made));
  auto plane = sized<bccsplat_plane>();
  EXPECT_OK(bccsplat_frame_get_channel(made, BCCSPLAT_FRAME_RGBA, &plane));
  return {plane.pixels, plane.pixels + size_t{4} * size * size};
}

double difference(const std::vector<float>& a, const std::vector<float>& b) {
  double most = 0;
  for (size_t i = 0; i < a.size(); ++i) most = larger(most, static_cast<double>(std::fabs(a[i] - b[i])));
  return most;
}

TEST(WriterEnds, TheTrailOfAPeriodicSeriesReachesBackAcrossItsBeginning) {
  const Device device = make_device();
  const Folder folder;
  Series s{.nt = 10, .first = 0, .step = 1};
  s.field = [](double x, double y, double z, double t) {
    const double turn = 2 * 3.14159265358979 * t / 10;
    const double dx = x - 9 - 4 * std::cos(turn), dy = y - 9 - 4 * std::sin(turn), dz = z - 8;
    return 100 * std::exp(-(dx * dx + dy * dy + dz * dz) / 12);
  };
  const std::string path = folder.file("ball.bcc4");
  write_file(device, path, s, BCCSPLAT_ENDS_PERIODIC);
  const Volume volume = open(device, path);
  for (const int32_t content : {BCCSPLAT_TRAIL_CLASSIFIED, BCCSPLAT_TRAIL_MEAN, BCCSPLAT_TRAIL_MAXIMUM}) {
    const auto first = picture_of_trail(device, volume, 0, 3, content);
    EXPECT_LT(difference(first, picture_of_trail(device, volume, 10, 3, content)), 2e-3) << content;
    EXPECT_GT(difference(first, picture_of_trail(device, volume, 0, 0, content)), 0.1) << content;
    EXPECT_GT(difference(first, picture_of_trail(device, volume, 5, 3, content)), 0.1) << content;
  }
  // So does one on a lattice of its own.
  const auto first = picture_of_trail(device, volume, 0, 3, BCCSPLAT_TRAIL_CLASSIFIED, 1.01);
  EXPECT_LT(difference(first, picture_of_trail(device, volume, 10, 3, BCCSPLAT_TRAIL_CLASSIFIED, 1.01)),
            2e-3);
  EXPECT_LT(difference(first, picture_of_trail(device, volume, 0, 3, BCCSPLAT_TRAIL_CLASSIFIED)), 0.05);
}

// A field that knows what lies beyond its ends, and keeps the moments it was asked for.
struct AskedField {
  Series series;
  double first = 0, last = 0;
};

int32_t answer(void* user, uint64_t n, const double* xyzt, float* values) {
  auto& asked = *static_cast<AskedField*>(user);
  for (uint64_t i = 0; i < n; ++i) {
    const double* p = xyzt + 4 * i;
    asked.first = std::min(asked.first, p[3]), asked.last = std::max(asked.last, p[3]);
    values[i] = static_cast<float>(asked.series.field(p[0], p[1], p[2], p[3]));
  }
  return 0;
}

TEST(WriterEnds, AFieldIsAskedBeyondItsEndsWherePredictionIsAskedFor) {
  const Device device = make_device();
  const Folder folder;
  double worst[2] = {};
  for (const bool predict : {false, true}) {
    AskedField asked{.series = {.nt = 24}};
    auto o = options_of(asked.series);
    o.ends = predict ? BCCSPLAT_ENDS_PREDICT : BCCSPLAT_ENDS_MIRROR, o.lattice = BCCSPLAT_LATTICE_D4STAR;
    const std::string path = folder.file(predict ? "p.bcc4" : "m.bcc4");
    const Writer w = make_writer(device, path, o);
    auto g = sized<bccsplat_layer_geometry>();
    ASSERT_OK(bccsplat_writer_get_layer_geometry(w.get(), 0, &g));
    ASSERT_OK(bccsplat_writer_add_field(w.get(), 0, answer, &asked));
    ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
    EXPECT_NEAR(asked.first, predict ? -2.83 : 0, 0.01); // four layers
    EXPECT_EQ(g.frame, asked.first);
    EXPECT_GT(asked.last, predict ? 25.5 : 22.9);
    EXPECT_LT(asked.last, predict ? 27 : 24);
    worst[predict] = worst_at_ends(device, path, asked.series);
  }
  EXPECT_LT(4 * worst[true], worst[false]);
}

TEST(WriterEnds, LayersBeyondTheEndsAreGiven) {
  const Device device = make_device();
  const Folder folder;
  for (const bool short_of_it : {false, true}) {
    const Series s{.nt = 24};
    auto o = options_of(s);
    o.ends = BCCSPLAT_ENDS_PREDICT, o.lattice = BCCSPLAT_LATTICE_D4STAR;
    const std::string path = folder.file("l.bcc4");
    o.overwrite = 1;
    const Writer w = make_writer(device, path, o);
    auto g = sized<bccsplat_layer_geometry>();
    for (int64_t layer = 0; layer == 0 || layer < g.layer_count; ++layer) {
      ASSERT_OK(bccsplat_writer_get_layer_geometry(w.get(), layer, &g));
      if (short_of_it && g.frame > 19.5) break;
      std::vector<float> samples;
      for (int64_t k = 0; k < g.dims[2]; ++k)
        for (int64_t j = 0; j < g.dims[1]; ++j)
          for (int64_t i = 0; i < g.dims[0]; ++i)
            samples.push_back(
                static_cast<float>(s.field(g.origin[0] + g.step[0] * static_cast<double>(i),
                                           g.origin[1] + g.step[1] * static_cast<double>(j),
                                           g.origin[2] + g.step[2] * static_cast<double>(k), g.frame)));
      ASSERT_OK(bccsplat_writer_add_layer(w.get(), 0, layer, samples.data(), samples.size()));
    }
    if (short_of_it)
      ASSERT_OK(bccsplat_writer_finish_short(w.get(), nullptr));
    else
      ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
    const Volume v = open(device, path);
    auto info = sized<bccsplat_volume_info>();
    ASSERT_OK(bccsplat_volume_get_info(v.get(), &info));
    EXPECT_EQ(info.dims[3], short_of_it ? 17u : 24u); // four of the layers given stand behind the last frame
    if (short_of_it) continue;
    const std::string mirrored = folder.file("m2.bcc4");
    write_file(device, mirrored, s, BCCSPLAT_ENDS_MIRROR);
    EXPECT_LT(4 * worst_at_ends(device, path, s), worst_at_ends(device, mirrored, s));
  }
}

TEST(WriterEnds, ABoundHoldsAtTheEnds) {
  const Device device = make_device();
  const Folder folder;
  const Series s{.nt = 9};
  bccsplat_writer_options o = options_of(s);
  o.abs_error = 0.05;
  o.ends = BCCSPLAT_ENDS_PREDICT;
  const std::string path = folder.file("b.bcc4");
  {
    const Writer w = make_writer(device, path, o);
    ASSERT_OK(add_frames(w.get(), s));
    ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
  }
  const Volume volume = open(device, path);
  std::vector<double> points;
  std::vector<double> truth;
  for (uint32_t t = 0; t < s.nt; ++t)
    for (uint32_t z = 0; z < s.nz; ++z)
      for (uint32_t y = 0; y < s.ny; ++y)
        for (uint32_t x = 0; x < s.nx; ++x) {
          for (const uint32_t v : {x, y, z, t}) points.push_back(v);
          truth.push_back(static_cast<float>(s.field(x, y, z, t)));
        }
  std::vector<float> values(truth.size());
  EXPECT_OK(bccsplat_volume_evaluate(volume.get(), values.size(), points.data(), values.data(), nullptr));
  for (size_t i = 0; i < truth.size(); ++i)
    ASSERT_LE(std::fabs(values[i] - truth[i]), 0.05 * (1 + 1e-6)) << i;
}

TEST(WriterEnds, APeriodicAxisGoesOnToItsFirstSample) {
  const Device device = make_device();
  const Folder folder;
  Series s;
  const double turn = 2 * 3.14159265358979 / s.ny;
  s.field = [=](double x, double y, double z, double t) {
    return 50 + 20 * std::cos(0.25 * x - turn * y + 0.2 * z - 0.1 * t);
  };
  const std::string path = folder.file("p.bcc4");
  auto o = options_of(s);
  o.periodic_axes = BCCSPLAT_PERIODIC_Y;
  {
    const Writer w = make_writer(device, path, o);
    ASSERT_OK(add_frames(w.get(), s));
    ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
  }
  const Volume volume = open(device, path);
  auto info = sized<bccsplat_volume_info>();
  ASSERT_OK(bccsplat_volume_get_info(volume.get(), &info));
  EXPECT_EQ(info.periodic_axes, static_cast<uint32_t>(BCCSPLAT_PERIODIC_Y));
  EXPECT_EQ(info.planes_before[1] + info.planes_behind[1], 0u);
  const double end = s.ny, t = 1;
  const std::vector<double> points{9, end - 0.5, 9, t, 9, end, 9, t, 9, 0, 9, t, 9, end + 0.01, 9, t};
  std::vector<float> values(4), gradients(16);
  EXPECT_EQ(bccsplat_volume_evaluate(volume.get(), 4, points.data(), values.data(), gradients.data()),
            BCCSPLAT_ERROR_OUT_OF_DOMAIN);
  EXPECT_NEAR(values[0], s.field(9, end - 0.5, 9, t), 0.3);
  EXPECT_NEAR(values[1], values[2], 1e-4);
  EXPECT_NEAR(gradients[5], gradients[9], 1e-3);
  EXPECT_TRUE(std::isnan(values[3]));
  // What cannot be is refused by name.
  bccsplat_writer* none = nullptr;
  const auto refused = [&](const bccsplat_writer_options& bad) {
    return bccsplat_writer_create(device.get(), folder.file("x.bcc4").c_str(), &bad, &none);
  };
  auto bad = o;
  bad.periodic_axes = 8;
  EXPECT_EQ(refused(bad), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  bad = o, bad.faces = BCCSPLAT_FACES_PREDICT_Y;
  EXPECT_EQ(refused(bad), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  bad = o, bad.dims[1] = 1;
  EXPECT_EQ(refused(bad), BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

} // namespace
} // namespace host
