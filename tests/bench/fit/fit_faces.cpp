#include "tests/bench/fit/fit_faces.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "fit/ends.h"
#include "tests/bench/fit/lattice_faces.h"
#include "tests/bench/paper/paper.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using test::TestContext;
using Gradient = std::array<float, 4>;

constexpr uint64_t cache = 4ull << 30;
constexpr uint32_t halo = 8;    // samples of a continued series around the source
constexpr uint32_t around = 11; // of a real set around a box: another lattice than with the halo

// How the field goes on beyond the faces.
enum class Beyond : uint8_t { mirrored, odd, along_rows, unmirrored, odd_on_lattice, from_lattice };
constexpr Beyond candidates[] = {Beyond::mirrored,       Beyond::odd,
                                 Beyond::along_rows,     Beyond::unmirrored,
                                 Beyond::odd_on_lattice, Beyond::from_lattice};

const char* name_of(Beyond beyond) {
  switch (beyond) {
  case Beyond::mirrored:
    return "mirrored";
  case Beyond::odd:
    return "planes of 2 f(face) - f";
  case Beyond::along_rows:
    return "planes predicted from frames";
  case Beyond::unmirrored:
    return "mirrored, but predicted in rows";
  case Beyond::odd_on_lattice:
    return "2 f(face) - f, in rows and on the lattice";
  case Beyond::from_lattice:
    break;
  }
  return "predicted, in rows and on the lattice";
}

struct Values {
  std::vector<float> value;
  std::vector<Gradient> gradient;
};
using Truth = std::function<Values(std::span<const Vec4>)>;

// A field that can be asked at source samples' positions.
struct Fitted {
  MemorySamples samples;
  Vec3 origin; // of source sample 0

  [[nodiscard]] Values at(std::span<const Vec4> points) const {
    TestContext context;
    const Coefficients c(samples, 0, make_kernel("default"), 0, cache);
    std::vector<Vec4> moved(points.begin(), points.end());
    for (Vec4& p : moved)
      for (size_t a = 0; a < 3; ++a) p[a] += origin[a];
    Values v{std::vector<float>(points.size()), std::vector<Gradient>(points.size())};
    (void)evaluate4(c, moved, v.value, v.gradient, context.get());
    return v;
  }
};

// The series with `halo` samples more at every face, axis after axis.
FitSeries continued(const FitSeries& s, Beyond beyond) {
  FitSeries now = s;
  EndFrames ends(1);
  for (size_t axis = 0; axis < 3; ++axis) {
    const FitSeries from = std::move(now);
    now = {from.dims, {}};
    now.dims[axis] += 2 * halo;
    const auto n = static_cast<int64_t>(from.dims[axis]);
    size_t stride = 1;
    for (size_t a = 0; a < axis; ++a) stride *= from.dims[a];
    const size_t rows = from.values.size() / stride / static_cast<size_t>(n);
    now.values.reserve(rows * stride * now.dims[axis]);
    for (size_t r = 0; r < rows; ++r)
      for (int64_t i = -int64_t{halo}; i < n + halo; ++i)
        for (size_t k = 0; k < stride; ++k) {
          const auto sample = [&](int64_t at) {
            return from.values[(r * static_cast<size_t>(n) + static_cast<size_t>(at)) * stride + k];
          };
          const int64_t out = std::max(-i, i - (n - 1));
          const auto inside = [&](int64_t at) { return sample(i < 0 ? at : n - 1 - at); };
          if (out <= 0) {
            now.values.push_back(sample(i));
          } else if (beyond == Beyond::odd) {
            now.values.push_back(2 * inside(0) - inside(std::min(out, n - 1)));
          } else {
            double sum = 0;
            const std::vector<double>& w = ends.weights(out, n);
            for (size_t j = 0; j < w.size(); ++j)
              sum += w[j] * static_cast<double>(inside(static_cast<int64_t>(j)));
            now.values.push_back(static_cast<float>(sum));
          }
        }
  }
  return now;
}

Fitted fitted(const FitSeries& s, Beyond beyond) {
  if (beyond == Beyond::unmirrored) return {resample_without_mirrors(s, RowEnds::predicted), {}};
  if (beyond == Beyond::odd_on_lattice || beyond == Beyond::from_lattice) {
    const bool odd = beyond == Beyond::odd_on_lattice;
    WithMargin wide = predict_faces(resample_without_mirrors(s, odd ? RowEnds::odd : RowEnds::predicted),
                                    odd ? odd_stencil : predicted_stencil, {});
    return {std::move(wide.samples), wide.origin};
  }
  const bool more = beyond != Beyond::mirrored;
  std::vector<std::vector<BrickLayer>> layers(1);
  const FitReport made = fit_source(source_of<float>(more ? continued(s, beyond) : s, SourceType::f32, 1, ""),
                                    {}, 1, layers.data());
  return {{made.lattice, {0}, std::move(layers)}, more ? Vec3{halo, halo, halo} : Vec3{}};
}

// Distances from a face, of an edge from both its faces, of a corner from three.
struct Place {
  const char* name;
  int faces;
  double from, span;
};
constexpr Place places[] = {{"face: 0", 1, 0, 0},   {"0.5", 1, 0.5, 0},       {"0..1", 1, 0, 1},
                            {"1..2", 1, 1, 1},      {"2..3", 1, 2, 1},        {"3..4", 1, 3, 1},
                            {"edge 0..1", 2, 0, 1}, {"corner 0..1", 3, 0, 1}, {"inside", 0, 0, 0}};

struct Domain {
  std::array<uint32_t, 4> dims;
  std::vector<size_t> axes; // with faces that are looked at
  bool moves = true;
};

std::vector<Vec4> points_of(const Domain& d, const Place& place, size_t count) {
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

struct Snr {
  double value, gradient, largest;
};

// peak 0: over the mean square of the truth there; else over the square of the peak (values alone).
Snr compare(const Values& got, const Values& truth, double peak, bool moves) {
  double error = 0, power = 0, steep_error = 0, steep = 0, largest = 0;
  for (size_t i = 0; i < got.value.size(); ++i) {
    const double t = static_cast<double>(truth.value[i]), e = static_cast<double>(got.value[i]) - t;
    error += e * e, power += peak > 0 ? peak * peak : t * t, largest = std::max(largest, std::fabs(e));
    for (size_t a = 0; a < (moves ? 4u : 3u); ++a) {
      const double g = static_cast<double>(truth.gradient[i][a]);
      steep += g * g, steep_error += std::pow(static_cast<double>(got.gradient[i][a]) - g, 2);
    }
  }
  return {10 * std::log10(power / error), 10 * std::log10(steep / steep_error), largest};
}

struct Tables {
  std::vector<Row> values, gradients;
};

void add_rows(Tables& tables, const std::string& name, const Domain& domain, double peak, const Truth& truth,
              const std::function<Fitted(Beyond)>& fit, size_t count) {
  std::vector<std::vector<Vec4>> points;
  std::vector<Values> wanted;
  for (const Place& place : places) {
    points.push_back(points_of(domain, place, count));
    wanted.push_back(truth(points.back()));
  }
  for (const Beyond beyond : candidates) {
    const Fitted field = fit(beyond);
    Row value{word("series", name), word("beyond the faces", name_of(beyond))}, gradient = value;
    for (size_t i = 0; i < std::size(places); ++i) {
      if (static_cast<size_t>(places[i].faces) > domain.axes.size()) {
        value.push_back(word(places[i].name, "-")), gradient.push_back(word(places[i].name, "-"));
        continue;
      }
      const Snr snr = compare(field.at(points[i]), wanted[i], peak, domain.moves);
      value.push_back(figure(places[i].name, snr.value, 1));
      gradient.push_back(figure(places[i].name, snr.gradient, 1));
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

// A cloud on the face x = 0, cut off where it is thin: how much of it comes to stand in the air beside it.
void report_cloud(const Report& report) {
  const auto cloud = [](const Vec4& p) {
    const double v = std::exp(-(p[0] * p[0] + std::pow(p[1] - 16, 2) + std::pow(p[2] - 16, 2)) / 18);
    return v < 1e-3 ? 0.0 : v;
  };
  const std::array<uint32_t, 4> dims{32, 32, 32, 1};
  const FitSeries s = sampled(dims, cloud);
  std::vector<Row> rows;
  for (const Beyond beyond : candidates) {
    const Fitted field = fitted(s, beyond);
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
    rows.push_back({word("beyond the faces", name_of(beyond)),
                    figure("air, 0..2 from the rim", largest[0], 5), figure("2..4", largest[1], 5),
                    figure("further", largest[2], 5)});
  }
  report.table("a cloud that touches a face (peak 1, rim .001): largest value in the air near the face",
               rows);
}

// Sites that a site beyond a face depends on, and the mean square of what becomes of white noise.
void report_stencils(const Report& report) {
  std::vector<Row> rows;
  for (const int dimensions : {3, 4})
    for (const bool odd : {false, true}) {
      Row row{word("lattice", dimensions == 3 ? "BCC" : "D4*"),
              word("rule", odd ? "2 f(face) - f" : "predicted")};
      for (int distance = 1; distance <= 4; ++distance) {
        const FaceStencil s = (odd ? odd_stencil : predicted_stencil)(dimensions, distance, {});
        row.push_back(word(concat("plane ", -distance, ": taps, noise"),
                           concat(s.taps(), ", ", number(s.noise_gain(), 1))));
      }
      rows.push_back(row);
    }
  report.table("what lies beyond a face, of what is inside", rows);
}

struct RealSet {
  PaperSet set;
  std::array<uint32_t, 4> first, dims; // a box of it and what is around
};
constexpr RealSet real_sets[] = {
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
        box.values.insert(box.values.end(), frame.begin() + static_cast<std::ptrdiff_t>(row),
                          frame.begin() + static_cast<std::ptrdiff_t>(row + dims[0]));
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
        [&](Beyond beyond) { return fitted(s, beyond); }, report.quick ? 600 : 3000);
  }
  report.table("the ends of space: SNR dB of values by distance from a face, default kernel", tables.values);
  report.table("the ends of space: SNR dB of gradients in space and time", tables.gradients);
  report_cloud(report);
  report_stencils(report);
}

void report_faces(const std::string& folder, const Report& report) {
  Tables tables;
  for (const RealSet& real : real_sets) {
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
    const Fitted whole = fitted(box_of(*source, real.first, real.dims), Beyond::mirrored);
    const FitSeries box = box_of(*source, first, domain.dims);
    const auto [low, high] = std::minmax_element(box.values.begin(), box.values.end());
    add_rows(
        tables, real.set.name, domain, static_cast<double>(*high - *low),
        [&](std::span<const Vec4> points) {
          std::vector<Vec4> moved(points.begin(), points.end());
          for (Vec4& p : moved)
            for (size_t a = 0; a < 3; ++a) p[a] += shift[a];
          return whole.at(moved);
        },
        [&](Beyond beyond) { return fitted(box, beyond); }, report.quick ? 600 : 6000);
  }
  report.table("the ends of space: PSNR dB of a box against the same field with more around it",
               tables.values);
  report.table("the same: SNR dB of gradients", tables.gradients);
}

} // namespace bccsplat::bench
