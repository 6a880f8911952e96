// SPDX-License-Identifier: Apache-2.0
// Takes smooth fields and real series through the trials (coefficient_trial.h), finds by bisection the bytes
// at the error that samples have, and says which of the conditions hold.
#include "tests/bench/storage/storage_coefficients.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

#include "base/error.h"
#include "tests/bench/paper/paper.h"
#include "tests/bench/storage/coefficient_trial.h"
#include "tests/bench/storage/storage_series.h"

namespace bccsplat::bench {
namespace {

using Dims = std::array<uint32_t, 4>;

TrialSource sampled(const std::string& name, const Dims& dims, const std::function<double(const Vec4&)>& f) {
  FitSeries s{dims, {}};
  for (uint32_t t = 0; t < dims[3]; ++t)
    for (uint32_t z = 0; z < dims[2]; ++z)
      for (uint32_t y = 0; y < dims[1]; ++y)
        for (uint32_t x = 0; x < dims[0]; ++x)
          s.values.push_back(static_cast<float>(f({double(x), double(y), double(z), double(t)})));
  return {source_of<uint8_t>(s, SourceType::u8, 1, name)};
}

// A direction that no axis is near, which moves.
double along(const Vec4& p, double speed) { return .8 * p[0] + .5 * p[1] + .33 * p[2] + speed * p[3]; }

std::vector<TrialSource> smooth_sources(bool quick) {
  const Dims dims = quick ? Dims{24, 24, 24, 10} : Dims{48, 48, 48, 16};
  const double middle = dims[0] / 2.0;
  std::vector<TrialSource> all;
  for (const double slope : {.01, .05, .2, 1.0})
    all.push_back(sampled("ramp of " + number(slope, 2) + " a T", dims,
                          [=](const Vec4& p) { return 100 + slope * along(p, .3); }));
  for (const double speed : {0.0, .3})
    for (const double length : {8.0, 16.0, 32.0, 100.0})
      all.push_back(sampled((speed > 0 ? "moving wave of " : "still wave of ") + number(length, 0) + " T",
                            dims, [=](const Vec4& p) {
                              return 128 + 100 * std::sin(2 * std::numbers::pi / length * along(p, speed));
                            }));
  const auto from_middle = [=](const Vec4& p, double speed) {
    return std::hypot(p[0] - middle - speed * (p[3] - 8), p[1] - middle, p[2] - middle);
  };
  all.push_back(
      sampled("ball", dims, [=](const Vec4& p) { return from_middle(p, .5) < .3 * dims[0] ? 200 : 0; }));
  all.push_back(sampled("labels", dims, [](const Vec4& p) {
    return std::floor(3.5 + 2.4 * std::sin(.2 * p[0] + .05 * p[3]) * std::cos(.17 * p[1]) +
                      std::sin(.15 * p[2]));
  }));
  // What lies around something busy, in chunks that hold both.
  all.push_back(sampled("ramp of .20 a T beside a busy ball", dims, [=](const Vec4& p) {
    const bool busy = from_middle(p, 0) < .25 * dims[0];
    return 100 + .2 * along(p, .3) +
           (busy ? 60 * std::sin(2.3 * p[0] + 1.1 * p[1] + .3 * p[3]) * std::cos(1.9 * p[2]) : 0);
  }));
  all.back().where = [=](const Vec4& p) { return from_middle(p, 0) > .25 * dims[0] + 5; };
  return all;
}

// Every code there is, each in a volume of its own: the worst of all.
FieldErrors constant_errors(const Trial& trial, bool quick) {
  FieldErrors worst;
  for (int code = 1; code < 256; code += quick ? 50 : 1) {
    const TrialSource source = sampled("", {12, 12, 12, 4}, [=](const Vec4&) { return code; });
    const FieldErrors e = CoefficientTrials(source, "default", true).coefficients(trial).error;
    worst.rms = std::max(worst.rms, e.rms), worst.largest = std::max(worst.largest, e.largest);
    worst.gradient = std::max(worst.gradient, e.gradient);
  }
  return worst;
}

struct NamedTrial {
  std::string name;
  Trial trial;
};
const NamedTrial up_to_2{"step 1 or 2", {.step = 1, .most_shift = 1}};
const NamedTrial up_to_4{"step 1, 2 or 4", {.step = 1, .most_shift = 2}};

struct Condition {
  std::string name;
  bool holds = true;
};

// Errors this small are those of float arithmetic.
constexpr double nothing = 1e-4;

bool smooth_enough(const FieldErrors& e, double gradient_today) {
  return e.rms <= .3 && e.largest <= .6 && e.gradient <= gradient_today + nothing;
}

void smooth_table(const Report& report, std::vector<Condition>& conditions) {
  std::vector<Row> rows;
  const auto add = [&](const std::string& field, const std::string& stored, const FieldErrors& e,
                       double today, const std::string& bytes, const std::string& holds) {
    rows.push_back({word("field, u8", field), word("stored", stored), word("bytes, of samples", bytes),
                    figure("field RMS", e.rms, 3), figure("largest", e.largest, 2),
                    figure("gradient RMS", e.gradient, 4),
                    figure("of samples", e.gradient / std::max(today, nothing), 2),
                    figure("luminance RMS", e.luminance, 1), word(".3, .6 and gradient", holds)});
  };
  const std::vector<TrialSource> sources = smooth_sources(report.quick);
  for (const NamedTrial& t : {up_to_2, up_to_4}) {
    Condition& c = conditions.emplace_back(
        "smooth u8 fields, " + t.name + ": RMS <= .3, largest <= .6, gradient no worse than that of samples");
    const FieldErrors e = constant_errors(t.trial, report.quick);
    c.holds = smooth_enough(e, 0);
    add("constants 1 .. 255, the worst", t.name, e, 0, "", c.holds ? "yes" : "no");
  }
  for (const TrialSource& source : sources) {
    const CoefficientTrials trials(source, "default", report.quick);
    const TrialResult samples = trials.samples();
    // Clamping, which coefficients are spared, is no excuse for their gradient.
    const FieldErrors today = trials.unclamped();
    add(source.source.name, "samples", samples.error, samples.error.gradient, "1", "");
    size_t at = conditions.size() - 2;
    for (const NamedTrial& t : {up_to_2, up_to_4}) {
      const TrialResult r = trials.coefficients(t.trial);
      const bool holds = smooth_enough(r.error, today.gradient);
      conditions[at].holds = conditions[at].holds && holds, ++at;
      add(source.source.name, t.name, r.error, today.gradient,
          number(static_cast<double>(r.bytes) / static_cast<double>(samples.bytes), 2), holds ? "yes" : "no");
    }
  }
  report.table("coefficient codes: smooth fields", rows);
}

FitSource cropped(const FitSource& s, const Dims& from, const Dims& dims) {
  FitSource r{s.name, dims, s.type, {}};
  const size_t bytes = source_bytes(s.type);
  for (uint32_t t = 0; t < dims[3]; ++t)
    for (uint32_t z = 0; z < dims[2]; ++z)
      for (uint32_t y = 0; y < dims[1]; ++y) {
        const size_t row =
            ((size_t{t + from[3]} * s.dims[2] + z + from[2]) * s.dims[1] + y + from[1]) * s.dims[0];
        const auto first = s.bytes.begin() + ((row + from[0]) * bytes);
        r.bytes.insert(r.bytes.end(), first, first + (dims[0] * bytes));
      }
  return r;
}

struct RealSource {
  TrialSource source;
  std::string kernel = "default";
  bool judged = true; // by the conditions
};

std::vector<RealSource> real_sources(const std::string& data, bool quick) {
  struct Part {
    PaperSet set;
    Dims from, dims;
    double step;
    const char* kernel;
    bool judged;
  };
  const PaperSet fingers{"viscous fingers u16", "viscous_fingers_run01_64x64x64x99_u16.nrrd", "", "", true};
  const Part parts[] = {{fingers, {0, 0, 0, 40}, {64, 64, 64, 24}, 1, "default", true},
                        {fingers, {0, 0, 0, 40}, {64, 64, 64, 24}, 16, "default", false},
                        {fingers, {0, 0, 0, 40}, {64, 64, 64, 24}, 1, "fine", false},
                        {{"heart u16", "cardiac_cine_256x256x19x20_i16.nii.gz", "", "", true},
                         {64, 64, 0, 0},
                         {128, 128, 19, 20},
                         1,
                         "default",
                         true},
                        {{"hurricane u16", "isabel_windspeed_125x125x25x12_u16.nrrd", "", "", true},
                         {0, 0, 0, 0},
                         {125, 125, 25, 12},
                         1,
                         "default",
                         true},
                        {{"engine u8 (BCC)", "engine_256x256x128_u8.raw.gz", "256,256,128", "", false},
                         {64, 64, 0, 0},
                         {128, 128, 128, 1},
                         1,
                         "default",
                         true}};
  std::vector<RealSource> all;
  FitSeries smoke = smoke_like(quick ? Dims{48, 48, 48, 8} : Dims{128, 128, 128, 16});
  const double largest = *std::max_element(smoke.values.begin(), smoke.values.end());
  const FitSource smoke_u8 = source_of<uint8_t>(smoke, SourceType::u8, 255 / largest, "sparse smoke u8");
  all.push_back({{smoke_u8}});
  all.push_back({{smoke_u8}, "fine", false});
  for (const Part& p : parts) {
    const auto found = load_paper_set(p.set, data);
    if (!found) {
      std::fprintf(stderr, "storage --coefficients: %s/%s is not there: %s is LEFT OUT\n", data.c_str(),
                   p.set.file, p.set.name);
      continue;
    }
    Dims dims = p.dims;
    if (quick)
      for (size_t a = 0; a < 3; ++a) dims[a] = std::min(dims[a], 32u);
    all.push_back({{cropped(*found, p.from, dims), p.step}, p.kernel, p.judged});
  }
  return all;
}

std::vector<NamedTrial> candidates() {
  std::vector<NamedTrial> all;
  for (const double step : {1.0, 1.8, 2.0, 2.6, 3.65})
    all.push_back({"one step of " + number(step, 2), {.step = step}});
  for (const double step : {2.0, 3.0, 4.0})
    all.push_back({"one step of " + number(step, 2) + ", errors fed back", {.step = step, .shaped = true}});
  all.push_back(up_to_2), all.push_back(up_to_4);
  for (const int32_t layers : {6, 5, 4, 2}) {
    NamedTrial t = up_to_4;
    t.name += concat(", slabs of ", layers), t.trial.slab_layers = layers;
    all.push_back(t);
  }
  return all;
}

// The bytes with the step at which an error is that of `today`, by bisection: errors grow with the step, more
// or less.
double bytes_at_equal(const CoefficientTrials& trials, Trial trial, double FieldErrors::*error,
                      const FieldErrors& today) {
  TrialResult fine, coarse;
  double low = trial.step * .4, high = trial.step * 1.6;
  for (int i = 0; i < 6; ++i) {
    trial.step = std::sqrt(low * high);
    const TrialResult r = trials.coefficients(trial);
    const bool fits = r.error.*error <= today.*error;
    (fits ? fine : coarse) = r;
    (fits ? low : high) = trial.step;
  }
  if (fine.bytes == 0) fail(Code::internal, "coefficients: no step is fine enough");
  if (coarse.bytes == 0) return static_cast<double>(fine.bytes); // of the coarsest, which errs less
  const double part =
      std::log(today.*error / (fine.error.*error)) / std::log(coarse.error.*error / (fine.error.*error));
  const auto a = static_cast<double>(fine.bytes), b = static_cast<double>(coarse.bytes);
  return a * std::pow(b / a, part);
}

// Returns the bytes at equal field RMS, of those of samples.
double add_equal_row(std::vector<Row>& rows, const std::string& name, const CoefficientTrials& trials,
                     uint64_t samples, const FieldErrors& today, const std::string& scheme,
                     const Trial& trial) {
  const auto of_samples = [&](double FieldErrors::*error) {
    return bytes_at_equal(trials, trial, error, today) / static_cast<double>(samples);
  };
  const double ratio = of_samples(&FieldErrors::rms);
  rows.push_back({word("series", name), word("stored", scheme), figure("slab", trial.slab_layers, 0),
                  figure("field RMS of samples", today.rms, 3), figure("bytes at that, of samples", ratio, 3),
                  figure("gradient RMS of samples", today.gradient, 3),
                  figure("bytes at that, of samples (gradient)", of_samples(&FieldErrors::gradient), 3)});
  return ratio;
}

void real_tables(const std::string& data, const Report& report, std::vector<Condition>& conditions) {
  std::vector<Row> rows, equal;
  for (const RealSource& real : real_sources(data, report.quick)) {
    const CoefficientTrials trials(real.source, real.kernel, report.quick);
    std::string name = real.source.source.name;
    if (real.source.step != 1) name += " of step " + number(real.source.step, 0);
    if (real.kernel != "default") name += ", " + real.kernel;
    const TrialResult samples = trials.samples();
    const FieldErrors today = trials.unclamped();
    const auto add = [&](const std::string& stored, const TrialResult& r) {
      rows.push_back(
          {word("series", name), word("stored", stored), figure("KB", static_cast<double>(r.bytes) / 1000, 1),
           figure("of samples", static_cast<double>(r.bytes) / static_cast<double>(samples.bytes), 3),
           figure("bits / site", 8 * static_cast<double>(r.bytes) / static_cast<double>(r.sites), 2),
           figure("field RMS", r.error.rms, 3), figure("largest", r.error.largest, 2),
           figure("gradient RMS", r.error.gradient, 3), figure("luminance RMS", r.error.luminance, 2)});
    };
    add("samples", samples);
    add("samples, errors without clamping", {samples.bytes, samples.sites, today});
    for (const NamedTrial& c : candidates()) add(c.name, trials.coefficients(c.trial));
    const auto equal_row = [&](const std::string& scheme, const Trial& trial) {
      return add_equal_row(equal, name, trials, samples.bytes, today, scheme, trial);
    };
    equal_row("one step", {.step = 3.65});
    equal_row("one step, errors fed back", {.step = 4, .shaped = true});
    for (const int32_t layers : {8, 4}) {
      const double ratio = equal_row("1, 2 or 4 units", {.step = 1, .most_shift = 2, .slab_layers = layers});
      if (real.judged)
        conditions.push_back(
            {concat(name, ", slabs of ", layers, ": bytes at equal field RMS <= 1.03 of samples"),
             ratio <= 1.03});
    }
  }
  report.table("coefficient codes: real series", rows);
  report.table("coefficient codes: bytes at equal error", equal);
}

} // namespace

void coefficient_tables(const std::string& data, const Report& report) {
  std::vector<Condition> conditions;
  smooth_table(report, conditions);
  real_tables(data, report, conditions);
  std::vector<Row> rows;
  for (const Condition& c : conditions)
    rows.push_back({word("condition", c.name), word("holds", c.holds ? "yes" : "NO")});
  report.table("coefficient codes: conditions", rows);
}

} // namespace bccsplat::bench
