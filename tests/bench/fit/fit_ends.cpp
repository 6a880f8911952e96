// SPDX-License-Identifier: Apache-2.0
// Fits waves, a blob, white noise and real series with ends mirrored and predicted, and compares the field by
// distance from the first and the last frame.
#include "tests/bench/fit/fit_ends.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "tests/bench/fit/fit_source.h"
#include "tests/bench/paper/paper.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using test::TestContext;

constexpr std::array<int32_t, 3> leads{0, 2, 4};

struct Known {
  std::string name;
  std::function<double(const Vec4&)> field;
  double power; // mean square; 0: errors are given against a peak of 1
};

// Times from an end; `random`: anywhere in the frame that follows.
struct EndPlace {
  const char* name;
  double from;
  bool random;
};
constexpr EndPlace end_places[] = {{"t = 0", 0, false}, {"t = .5", 0.5, false}, {"t 0..1", 0, true},
                                   {"t 1..2", 1, true}, {"t 2..3", 2, true},    {"t 3..4", 3, true},
                                   {"inside", 11, true}};

MemorySamples fitted_with_lead(const FitSource& source, int32_t lead, uint64_t* kept = nullptr) {
  FitOptions options;
  options.lead = lead;
  std::vector<std::vector<BrickLayer>> layers(1);
  const FitReport made = fit_source(source, options, 1, layers.data());
  if (kept) *kept = made.channels[0].sites_kept;
  return {made.lattice, {0}, std::move(layers)};
}

// dB at the places of time, from both its ends, in the middle of space.
std::vector<double> errors_at(const Coefficients& c, const Known& k, const std::array<uint32_t, 4>& dims,
                              size_t count, const Context& context) {
  std::vector<double> db;
  for (const EndPlace& place : end_places) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<Vec4> points;
    for (size_t i = 0; i < count; ++i) {
      Vec4 p;
      for (size_t a = 0; a < 4; ++a) p[a] = (dims[a] - 1) / 2.0 + 4 * (unit(random) - 0.5);
      // Of a short series what is furthest from its ends is inside.
      const double first = std::min(place.from, (dims[3] - 1) / 2.0 - 1);
      const double from = first + (place.random ? unit(random) : 0);
      p[3] = i % 2 ? dims[3] - 1.0 - from : from;
      points.push_back(p);
    }
    std::vector<float> values(points.size());
    (void)evaluate4(c, points, values, {}, context);
    double error = 0, power = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      const double truth = k.field(points[i]), e = values[i] - truth;
      error += e * e, power += truth * truth;
    }
    db.push_back(10 * std::log10((k.power > 0 ? power : static_cast<double>(points.size())) / error));
  }
  return db;
}

// Mean square of what white noise of variance 1 becomes.
std::vector<double> noise_at(const Coefficients& c, const std::array<uint32_t, 4>& dims, size_t count,
                             const Context& context) {
  const Known nothing{"", [](const Vec4&) { return 0.0; }, 0};
  std::vector<double> power = errors_at(c, nothing, dims, count, context);
  for (double& v : power) v = std::pow(10, -v / 10);
  return power;
}

FitSource sampled_source(const std::array<uint32_t, 4>& dims, const std::function<double(const Vec4&)>& field,
                         const std::string& name) {
  FitSeries s{dims, {}};
  for (uint32_t t = 0; t < dims[3]; ++t)
    for (uint32_t z = 0; z < dims[2]; ++z)
      for (uint32_t y = 0; y < dims[1]; ++y)
        for (uint32_t x = 0; x < dims[0]; ++x)
          s.values.push_back(static_cast<float>(field({1.0 * x, 1.0 * y, 1.0 * z, 1.0 * t})));
  return source_of<float>(s, SourceType::f32, 1, name);
}

void add_row(std::vector<Row>& rows, const std::string& name, const std::string& beyond,
             const std::vector<double>& v, int digits) {
  Row row{word("series", name), word("beyond the ends", beyond)};
  for (size_t i = 0; i < v.size(); ++i) row.push_back(figure(end_places[i].name, v[i], digits));
  rows.push_back(row);
}

std::string lead_name(int32_t lead) {
  return lead == 0 ? std::string("mirrored") : concat(lead, " layers predicted");
}

} // namespace

void report_ends(const Report& report) {
  TestContext context; // outlives the coefficients, which hold its memory
  const std::array<uint32_t, 4> dims{24, 24, 24, 25};
  const size_t count = report.quick ? 600 : 3000;
  std::vector<Known> known;
  for (const double rho : {0.3, 0.5, 0.7, 0.9}) {
    const test::PlaneWaves waves(60, rho, 17);
    known.push_back({concat("waves, rho ", rho), [waves](const Vec4& p) { return waves(p); }, 1});
  }
  known.push_back({"blob, .4 T a frame",
                   [](const Vec4& p) {
                     const double t = p[3] - 12, x = p[0] - 11.5 - 0.35 * t, y = p[1] - 11.5 - 0.2 * t,
                                  z = p[2] - 11.5;
                     return std::exp(-(x * x + y * y + z * z) / (2 * 2.2 * 2.2));
                   },
                   0});
  std::vector<Row> rows, noise;
  for (const Known& k : known) {
    const FitSource source = sampled_source(dims, k.field, k.name);
    for (const int32_t lead : leads) {
      const MemorySamples samples = fitted_with_lead(source, lead);
      const Coefficients c(samples, 0, make_kernel("default"), 0, fit_cache);
      add_row(rows, k.name, lead_name(lead), errors_at(c, k, dims, count, context.get()), 1);
    }
  }
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  FitSeries white{dims, {}};
  for (size_t i = 0; i < size_t{24} * 24 * 24 * 25; ++i)
    white.values.push_back(static_cast<float>(normal(random)));
  const FitSource source = source_of<float>(white, SourceType::f32, 1, "white noise");
  for (const int32_t lead : leads) {
    const MemorySamples samples = fitted_with_lead(source, lead);
    const Coefficients c(samples, 0, make_kernel("default"), 0, fit_cache);
    add_row(noise, source.name, lead_name(lead), noise_at(c, dims, count, context.get()), 2);
  }
  report.table("the ends of time: SNR dB (blob: PSNR), default kernel, through the import, both ends", rows);
  std::vector<Row> few;
  for (const uint32_t frames : {4u, 6u, 9u})
    for (const double rho : {0.3, 0.5, 0.7}) {
      const test::PlaneWaves waves(60, rho, 17);
      const Known k{concat(frames, " frames, waves, rho ", rho), waves, 1};
      const std::array<uint32_t, 4> short_dims{dims[0], dims[1], dims[2], frames};
      const FitSource series = sampled_source(short_dims, k.field, k.name);
      for (const int32_t lead : leads) {
        const MemorySamples samples = fitted_with_lead(series, lead);
        const Coefficients c(samples, 0, make_kernel("default"), 0, fit_cache);
        add_row(few, k.name, lead_name(lead), errors_at(c, k, short_dims, count, context.get()), 1);
      }
    }
  report.table("the ends of time: SNR dB of short series", few);
  report.table("the ends of time: mean square of white noise", noise);
}

void report_ends(const FitSource& source, const Report& report) {
  TestContext context;
  std::vector<Row> rows;
  const double n = source.dims[3];
  for (const int32_t lead : leads) {
    uint64_t kept = 0;
    const MemorySamples samples = fitted_with_lead(source, lead, &kept);
    const Coefficients c(samples, 0, make_kernel("default"), 0, fit_cache);
    Row row{word("series", source.name), word("beyond the ends", lead_name(lead)),
            figure("sites kept", static_cast<double>(kept), 0)};
    for (const double at : {0.0, 1.0, 2.0, 3.0, std::floor(n / 2), n - 4, n - 3, n - 2, n - 1}) {
      const std::vector<float> truth = source.frame(static_cast<uint32_t>(at));
      std::vector<Vec4> points;
      for (uint32_t z = 0; z < source.dims[2]; ++z)
        for (uint32_t y = 0; y < source.dims[1]; ++y)
          for (uint32_t x = 0; x < source.dims[0]; ++x) points.push_back({1.0 * x, 1.0 * y, 1.0 * z, at});
      std::vector<float> values(points.size());
      (void)evaluate4(c, points, values, {}, context.get());
      double error = 0;
      for (size_t i = 0; i < values.size(); ++i) {
        const double e = values[i] - truth[i];
        error += e * e;
      }
      row.push_back(
          figure("RMSE, frame " + number(at, 0), std::sqrt(error / static_cast<double>(values.size())), 3));
    }
    rows.push_back(row);
  }
  report.table("the ends of time: error at the source samples by frame", rows);
}

void report_ends(const std::string& folder, const Report& report) {
  constexpr PaperSet sets[] = {{"heart", "cardiac_cine_256x256x19x20_i16.nii.gz", "", "", true},
                               {"hurricane", "isabel_windspeed_125x125x25x12_u16.nrrd", "", "", true},
                               {"pcasl", "pcasl_52x68x20x10_f32.nii.gz", "", "", true},
                               {"forecast", "ncep_forecast_36x33x10x7_f32.nc", "", "T", true}};
  for (const PaperSet& set : sets)
    if (const auto source = load_paper_set(set, folder)) report_ends(*source, report);
}

} // namespace bccsplat::bench
