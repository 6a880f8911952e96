// SPDX-License-Identifier: Apache-2.0
// Fits waves, a cloud on a face and boxes cut out of real sets with faces mirrored and predicted, and
// compares values and gradients by distance from them. What planes outside take is measured through the whole
// writer.
#include "tests/bench/fit/fit_faces.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "formats/bcc4/info.h"
#include "store/volume_writer.h"
#include "tests/bench/fit/fit_fields.h"
#include "tests/bench/fit/fit_source.h"
#include "tests/bench/paper/paper.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using test::TestContext;
using Gradient = std::array<float, 4>;

constexpr uint32_t around = 11; // of a real set around a box: another lattice than with planes outside

// How the field goes on beyond the faces: planes of the lattice outside, 0: mirrored.
constexpr int32_t candidates[] = {0, 2};

std::string margin_name(int32_t margin) {
  return margin == 0 ? "mirrored" : concat("predicted, ", margin, " planes outside");
}

struct Values {
  std::vector<float> value;
  std::vector<Gradient> gradient;
};
using Truth = std::function<Values(std::span<const Vec4>)>;

// A field that can be asked at source samples' positions.
struct Fitted {
  MemorySamples samples;

  [[nodiscard]] Values at(std::span<const Vec4> points) const {
    TestContext context;
    const Coefficients c(samples, 0, make_kernel("default"), 0, fit_cache);
    Values v{std::vector<float>(points.size()), std::vector<Gradient>(points.size())};
    (void)evaluate4(c, points, v.value, v.gradient, context.get());
    return v;
  }
};

Fitted fitted(const FitSeries& s, int32_t margin) {
  std::vector<std::vector<BrickLayer>> layers(1);
  FitOptions options;
  options.margins = {margin, margin, margin};
  const FitReport made = fit_source(source_of<float>(s, SourceType::f32, 1, ""), options, 1, layers.data());
  return {{made.lattice, {0}, std::move(layers)}};
}

// Distances from a face, of an edge from both its faces, of a corner from three.
struct FacePlace {
  const char* name;
  int faces;
  double from, span;
};
constexpr FacePlace face_places[] = {{"face: 0", 1, 0, 0},   {"0.5", 1, 0.5, 0},       {"0..1", 1, 0, 1},
                                     {"1..2", 1, 1, 1},      {"2..3", 1, 2, 1},        {"3..4", 1, 3, 1},
                                     {"edge 0..1", 2, 0, 1}, {"corner 0..1", 3, 0, 1}, {"inside", 0, 0, 0}};

struct Domain {
  std::array<uint32_t, 4> dims;
  std::vector<size_t> axes; // with faces that are looked at
  bool moves = true;
};

std::vector<Vec4> points_of(const Domain& d, const FacePlace& place, size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Vec4> points(count);
  for (Vec4& p : points) {
    for (size_t a = 0; a < 4; ++a) { // 10 samples from all ends where there are as many
      const double end = d.dims[a] - 1.0, away = std::min(10.0, 0.45 * end);
      p[a] = away + unit(random) * (end - 2 * away);
    }
    std::vector<size_t> axes = d.axes;
    std::shuffle(axes.begin(), axes.end(), random);
    for (size_t i = 0; i < std::min(static_cast<size_t>(place.faces), axes.size()); ++i) {
      const double from = place.from + place.span * unit(random);
      p[axes[i]] = random() & 1 ? d.dims[axes[i]] - 1.0 - from : from;
    }
  }
  return points;
}

struct FaceSnr {
  double value, gradient, largest;
};

// peak 0: over the mean square of the truth there; else over the square of the peak (values alone).
FaceSnr compare(const Values& got, const Values& truth, double peak, bool moves) {
  double error = 0, power = 0, steep_error = 0, steep = 0, largest = 0;
  for (size_t i = 0; i < got.value.size(); ++i) {
    const double t = truth.value[i], e = got.value[i] - t;
    error += e * e, power += peak > 0 ? peak * peak : t * t, largest = std::max(largest, std::fabs(e));
    for (size_t a = 0; a < (moves ? 4u : 3u); ++a) {
      const double g = truth.gradient[i][a];
      steep += g * g, steep_error += std::pow(got.gradient[i][a] - g, 2);
    }
  }
  return {10 * std::log10(power / error), 10 * std::log10(steep / steep_error), largest};
}

struct Tables {
  std::vector<Row> values, gradients;
};

void add_rows(Tables& tables, const std::string& name, const Domain& domain, double peak, const Truth& truth,
              const std::function<Fitted(int32_t)>& fit, size_t count) {
  std::vector<std::vector<Vec4>> points;
  std::vector<Values> wanted;
  for (const FacePlace& place : face_places) {
    points.push_back(points_of(domain, place, count));
    wanted.push_back(truth(points.back()));
  }
  for (const int32_t margin : candidates) {
    const Fitted field = fit(margin);
    Row value{word("series", name), word("beyond the faces", margin_name(margin))}, gradient = value;
    for (size_t i = 0; i < std::size(face_places); ++i) {
      if (static_cast<size_t>(face_places[i].faces) > domain.axes.size()) {
        value.push_back(word(face_places[i].name, "-")), gradient.push_back(word(face_places[i].name, "-"));
        continue;
      }
      const FaceSnr snr = compare(field.at(points[i]), wanted[i], peak, domain.moves);
      value.push_back(figure(face_places[i].name, snr.value, 1));
      gradient.push_back(figure(face_places[i].name, snr.gradient, 1));
    }
    tables.values.push_back(value), tables.gradients.push_back(gradient);
  }
}

Values of_waves(const test::PlaneWaves& waves, std::span<const Vec4> points) {
  Values v;
  for (const Vec4& p : points) {
    const Vec4 g = waves.gradient(p);
    v.value.push_back(static_cast<float>(waves(p)));
    v.gradient.push_back({static_cast<float>(g[0]), static_cast<float>(g[1]), static_cast<float>(g[2]),
                          static_cast<float>(g[3])});
  }
  return v;
}

FitSeries sampled(const std::array<uint32_t, 4>& dims, const std::function<double(const Vec4&)>& field) {
  FitSeries s{dims, {}};
  for (uint32_t t = 0; t < dims[3]; ++t)
    for (uint32_t z = 0; z < dims[2]; ++z)
      for (uint32_t y = 0; y < dims[1]; ++y)
        for (uint32_t x = 0; x < dims[0]; ++x)
          s.values.push_back(static_cast<float>(field({1.0 * x, 1.0 * y, 1.0 * z, 1.0 * t})));
  return s;
}

// A frame of plane waves whose frequencies fill the ball of radius 0.3.
std::vector<uint8_t> moving_waves(uint32_t edge, uint32_t t) {
  static const test::PlaneWaves waves(4, 0.3, 5);
  std::vector<uint8_t> values;
  values.reserve(size_t{edge} * edge * edge);
  for (uint32_t z = 0; z < edge; ++z)
    for (uint32_t y = 0; y < edge; ++y)
      for (uint32_t x = 0; x < edge; ++x)
        values.push_back(static_cast<uint8_t>(
            std::clamp(128.5 + 20 * waves({1.0 * x, 1.0 * y, 1.0 * z, 1.0 * t}), 0.0, 255.0)));
  return values;
}

// A cloud on the face x = 0, cut off where it is thin: how much of it comes to stand in the air beside it.
void report_cloud(const Report& report) {
  const auto cloud = [](const Vec4& p) {
    const double v = std::exp(-(p[0] * p[0] + std::pow(p[1] - 16, 2) + std::pow(p[2] - 16, 2)) / 18);
    return v < 1e-3 ? 0.0 : v;
  };
  const std::array<uint32_t, 4> dims{32, 32, 32, 1};
  const FitSeries s = sampled(dims, cloud);
  std::vector<Row> rows;
  for (const int32_t margin : candidates) {
    const Fitted field = fitted(s, margin);
    // Samples of air by their distance, along the face, from the cloud's rim.
    std::array<double, 3> largest{};
    std::vector<Vec4> points;
    for (double z = 0; z <= 31; z += 0.5)
      for (double y = 0; y <= 31; y += 0.5)
        for (double x = 0; x <= 3; x += 0.5) points.push_back({x, y, z, 0});
    const Values v = field.at(points);
    const double rim = std::sqrt(18 * std::log(1e3));
    for (size_t i = 0; i < points.size(); ++i) {
      const double out = std::hypot(points[i][0], points[i][1] - 16, points[i][2] - 16) - rim;
      if (out < 0) continue;
      double& most = largest[out < 2 ? 0 : out < 4 ? 1 : 2];
      most = std::max(most, std::fabs(static_cast<double>(v.value[i])));
    }
    rows.push_back({word("beyond the faces", margin_name(margin)),
                    figure("air, 0..2 from the rim", largest[0], 5), figure("2..4", largest[1], 5),
                    figure("further", largest[2], 5)});
  }
  report.table("a cloud that touches a face (peak 1, rim .001): largest value in the air near the face",
               rows);
}

// Waves of rho 0.3 in 8 bits at sizes people have: what planes outside take.
void report_cost(const Report& report) {
  std::vector<Row> rows;
  std::vector<uint32_t> edges{64, 128};
  if (!report.quick) edges.insert(edges.end(), {256, 512});
  for (const uint32_t edge : edges) {
    const uint32_t frames = edge > 256 ? 4 : 8;
    std::vector<std::vector<uint8_t>> series;
    for (uint32_t t = 0; t < frames; ++t) series.push_back(moving_waves(edge, t));
    std::array<double, 2> bytes{}, sites{}, seconds{}, mebibytes{};
    for (const bool outside : {false, true}) {
      TestContext context(1);
      WriterSettings settings;
      settings.dims = {edge, edge, edge, frames};
      settings.faces = outside ? Faces::predict : Faces::mirror;
      std::vector<std::byte> file;
      seconds[outside] = cpu_seconds([&] {
        VolumeWriter writer(settings, create_memory_sink(file), context.get());
        FrameBox box;
        box.type = SourceType::u8;
        box.dims = {edge, edge, edge};
        for (uint32_t t = 0; t < frames; ++t) {
          box.data = series[t].data();
          writer.add_frame(0, t, {&box, 1});
        }
        sites[outside] = static_cast<double>(writer.finish().sites_kept);
      });
      bytes[outside] = static_cast<double>(file.size());
      mebibytes[outside] = static_cast<double>(context.memory.peak()) / (1 << 20);
    }
    const auto ratio = [&](const char* name, const std::array<double, 2>& of) {
      return figure(name, of[1] / of[0], 3);
    };
    rows.push_back({word("series", concat(edge, "^3 x ", frames)),
                    figure("MiB, mirrored", bytes[0] / (1 << 20), 2),
                    figure("with planes outside", bytes[1] / (1 << 20), 2), ratio("bytes", bytes),
                    ratio("sites", sites), ratio("CPU of the import", seconds), ratio("memory", mebibytes)});
  }
  report.table("planes outside: what they take (ratios to mirrored)", rows);
}

struct BoxedSet {
  PaperSet set;
  std::array<uint32_t, 4> first, dims; // a box of it and what is around
};
constexpr BoxedSet real_sets[] = {
    {{"fingers", "viscous_fingers_run01_64x64x64x99_u16.nrrd", "", "", true},
     {0, 0, 0, 40},
     {64, 64, 64, 14}},
    {{"heart", "cardiac_cine_256x256x19x20_i16.nii.gz", "", "", true}, {80, 80, 0, 0}, {96, 96, 19, 20}},
    {{"hurricane", "isabel_windspeed_125x125x25x12_u16.nrrd", "", "", true},
     {20, 20, 0, 0},
     {80, 80, 25, 12}},
    {{"CT of a tooth", "tooth_103x94x161_u8.nrrd", "", "", false}, {12, 8, 20, 0}, {80, 80, 80, 1}},
    {{"CT of a head", "cranium.nhdr", "", "", false}, {80, 60, 10, 0}, {96, 96, 96, 1}}};

FitSeries box_of(const FitSource& s, const std::array<uint32_t, 4>& first,
                 const std::array<uint32_t, 4>& dims) {
  FitSeries box{dims, {}};
  for (uint32_t t = 0; t < dims[3]; ++t) {
    const std::vector<float> frame = s.frame(first[3] + t);
    for (uint32_t z = 0; z < dims[2]; ++z)
      for (uint32_t y = 0; y < dims[1]; ++y) {
        const size_t row = (size_t{first[2] + z} * s.dims[1] + first[1] + y) * s.dims[0] + first[0];
        box.values.insert(box.values.end(), frame.begin() + row, frame.begin() + (row + dims[0]));
      }
  }
  return box;
}

} // namespace

void report_faces(const Report& report) {
  const Domain domain{{32, 32, 32, 25}, {0, 1, 2}};
  Tables tables;
  for (const double rho : {0.3, 0.5, 0.7}) {
    const test::PlaneWaves waves(60, rho, 17);
    const FitSeries s = sampled(domain.dims, waves);
    add_rows(
        tables, concat("waves, rho ", rho), domain, 0,
        [&](std::span<const Vec4> points) { return of_waves(waves, points); },
        [&](int32_t margin) { return fitted(s, margin); }, report.quick ? 600 : 3000);
  }
  report.table("the ends of space: SNR dB of values by distance from a face, default kernel", tables.values);
  report.table("the ends of space: SNR dB of gradients in space and time", tables.gradients);
  report_cloud(report);
  report_cost(report);
}

void report_faces(const std::string& folder, const Report& report) {
  Tables tables;
  for (const BoxedSet& real : real_sets) {
    const auto source = load_paper_set(real.set, folder);
    if (!source) continue;
    Domain domain{real.dims, {}, real.dims[3] > 1};
    std::array<uint32_t, 4> first = real.first;
    Vec3 shift{};
    for (size_t a = 0; a < 3; ++a) {
      if (domain.dims[a] < 4 * around) continue;
      domain.axes.push_back(a);
      domain.dims[a] -= 2 * around, first[a] += around, shift[a] = around;
    }
    const Fitted whole = fitted(box_of(*source, real.first, real.dims), 0);
    const FitSeries box = box_of(*source, first, domain.dims);
    const auto [low, high] = std::minmax_element(box.values.begin(), box.values.end());
    add_rows(
        tables, real.set.name, domain, *high - *low,
        [&](std::span<const Vec4> points) {
          std::vector<Vec4> moved(points.begin(), points.end());
          for (Vec4& p : moved)
            for (size_t a = 0; a < 3; ++a) p[a] += shift[a];
          return whole.at(moved);
        },
        [&](int32_t margin) { return fitted(box, margin); }, report.quick ? 600 : 6000);
  }
  report.table("the ends of space: PSNR dB of a box against the same field with more around it",
               tables.values);
  report.table("the same: SNR dB of gradients", tables.gradients);
}

} // namespace bccsplat::bench
