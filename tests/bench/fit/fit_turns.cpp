// SPDX-License-Identifier: Apache-2.0
// Writes plane waves that go round along an axis into memory, and compares the field of the file with them.
#include "tests/bench/fit/fit_turns.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "formats/bcc4/read/reader.h"
#include "formats/bcc4/read/samples.h"
#include "store/volume_writer.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using test::TestContext;

// Wave vectors uniform in the ball of radius rho pi, but for the axis along which they go round a whole
// number of times; mean square 1.
class TurningWaves {
 public:
  TurningWaves(double rho, size_t axis, uint32_t samples) {
    std::mt19937 random(17);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const double once = 2 * std::numbers::pi / samples;
    while (waves_.size() < 60) {
      Wave w{};
      double length2 = 0;
      for (double& v : w.vector) v = rho * std::numbers::pi * uniform(random);
      w.vector[axis] = once * std::round(w.vector[axis] / once);
      for (const double v : w.vector) length2 += v * v;
      w.phase = std::numbers::pi * uniform(random);
      if (length2 <= std::pow(rho * std::numbers::pi, 2)) waves_.push_back(w);
    }
  }
  // The value, and the gradient where it is asked for.
  [[nodiscard]] double at(const Vec4& p, Vec4* gradient = nullptr) const {
    const double amplitude = std::sqrt(2.0 / static_cast<double>(waves_.size()));
    double sum = 0;
    if (gradient) *gradient = {};
    for (const Wave& w : waves_) {
      double angle = w.phase;
      for (size_t a = 0; a < 4; ++a) angle += w.vector[a] * p[a];
      sum += amplitude * std::cos(angle);
      for (size_t a = 0; gradient && a < 4; ++a) (*gradient)[a] -= amplitude * std::sin(angle) * w.vector[a];
    }
    return sum;
  }

 private:
  struct Wave {
    Vec4 vector;
    double phase;
  };
  std::vector<Wave> waves_;
};

enum class Way { mirrored, predicted, periodic };
constexpr Way ways[] = {Way::mirrored, Way::predicted, Way::periodic};
const char* way_name(Way way) {
  return way == Way::mirrored ? "mirrored" : way == Way::predicted ? "predicted" : "periodic";
}

struct TurnPlace {
  const char* name;
  double from, span; // from either end; below 0: between the last sample and the first, or the last two
};
constexpr TurnPlace turn_places[] = {{"at 0", 0, 0},   {"at 0.5", 0.5, 0}, {"0..1", 0, 1},
                                     {"1..2", 1, 1},   {"2..3", 2, 1},     {"last to first", -1, 1},
                                     {"inside", 10, 1}};

struct Turn {
  std::array<uint32_t, 4> dims;
  size_t axis;
};

std::vector<std::byte> stored(const TurningWaves& waves, const Turn& turn, Way way) {
  TestContext context;
  WriterSettings settings;
  settings.dims = turn.dims;
  settings.ends = Ends::predict;
  if (turn.axis == 3)
    settings.ends = way == Way::mirrored    ? Ends::mirror
                    : way == Way::predicted ? Ends::predict
                                            : Ends::periodic;
  else
    settings.faces = way == Way::mirrored ? Faces::mirror : Faces::predict,
    settings.turning[turn.axis] = way == Way::periodic;
  std::vector<std::byte> file;
  VolumeWriter writer(settings, create_memory_sink(file), context.get());
  std::vector<float> values(size_t{turn.dims[0]} * turn.dims[1] * turn.dims[2]);
  FrameBox box;
  box.type = SourceType::f32, box.data = values.data();
  box.dims = {turn.dims[0], turn.dims[1], turn.dims[2]};
  for (uint32_t t = 0; t < turn.dims[3]; ++t) {
    size_t i = 0;
    for (uint32_t z = 0; z < turn.dims[2]; ++z)
      for (uint32_t y = 0; y < turn.dims[1]; ++y)
        for (uint32_t x = 0; x < turn.dims[0]; ++x)
          values[i++] = static_cast<float>(waves.at({1.0 * x, 1.0 * y, 1.0 * z, 1.0 * t}));
    writer.add_frame(0, t, {&box, 1});
  }
  (void)writer.finish();
  return file;
}

// In the middle of the other axes.
std::vector<Vec4> points_of_turn(const Turn& turn, const TurnPlace& place, bool periodic, size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Vec4> points(count);
  const double last = turn.dims[turn.axis] - 1.0;
  for (size_t i = 0; i < count; ++i) {
    for (size_t a = 0; a < 4; ++a) { // 10 samples from all ends where there are as many
      const double end = turn.dims[a] - 1.0, away = std::min(10.0, 0.45 * end);
      points[i][a] = away + unit(random) * (end - 2 * away);
    }
    const double from = place.from + place.span * unit(random);
    double& at = points[i][turn.axis];
    if (place.from < 0)
      at = periodic ? last - from : last + from; // from is below 0
    else
      at = i % 2 ? last - from : from;
  }
  return points;
}

struct Snr {
  double value, gradient;
};

Snr compare_turns(const Coefficients& field, const TurningWaves& waves, const std::vector<Vec4>& points,
                  const Context& context) {
  std::vector<float> values(points.size());
  std::vector<std::array<float, 4>> gradients(points.size());
  (void)evaluate4(field, points, values, gradients, context);
  double error = 0, power = 0, steep = 0, steep_error = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    Vec4 g;
    const double truth = waves.at(points[i], &g);
    error += std::pow(values[i] - truth, 2), power += truth * truth;
    for (size_t a = 0; a < 4; ++a) {
      steep += g[a] * g[a];
      steep_error += std::pow(gradients[i][a] - g[a], 2);
    }
  }
  return {10 * std::log10(power / error), 10 * std::log10(steep / steep_error)};
}

} // namespace

void report_turns(size_t axis, const Report& report) {
  Turn turn{{40, 40, 40, 8}, axis};
  if (axis == 3)
    turn.dims = {24, 24, 24, 24};
  else
    turn.dims[axis] = report.quick ? 48 : 128;
  std::vector<Row> values, gradients;
  for (const double rho : {0.3, 0.5, 0.7}) {
    const TurningWaves waves(rho, axis, turn.dims[axis]);
    for (const Way way : ways) {
      TestContext context;
      const std::vector<std::byte> file = stored(waves, turn, way);
      const std::shared_ptr<Bcc4Reader> reader = Bcc4Reader::open(open_memory_source(file));
      const Bcc4Samples samples(reader, context.memory, 256 << 20, RelativeTo::base);
      const Coefficients field(samples, 0, make_kernel("default"), 0, 4ull << 30);
      Row value{word("waves", concat("rho ", rho)), word("ends", way_name(way)),
                figure("KiB", static_cast<double>(file.size()) / 1024, 0)};
      Row gradient{value[0], value[1]};
      for (const TurnPlace& place : turn_places) {
        const Snr snr = compare_turns(
            field, waves, points_of_turn(turn, place, way == Way::periodic, report.quick ? 600 : 3000),
            context.get());
        value.push_back(figure(place.name, snr.value, 1));
        gradient.push_back(figure(place.name, snr.gradient, 1));
      }
      values.push_back(value), gradients.push_back(gradient);
    }
  }
  const std::string along = concat("along ", "xyzt"[axis], ", ", turn.dims[axis], " samples");
  report.table("waves that go round " + along + ": SNR dB of values by distance from the ends", values);
  report.table("the same: SNR dB of gradients in space and time", gradients);
}

} // namespace bccsplat::bench
