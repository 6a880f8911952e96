// SPDX-License-Identifier: Apache-2.0
// Fits a series without rounding once, rounds its samples or coefficients in chunks as asked, codes them for
// their bytes, and compares values and gradients of the field at random points.
#include "tests/bench/storage/coefficient_trial.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <random>

#include "field/evaluate.h"
#include "fit/coefficients/layer_window.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/encode/coefficient_codes.h"
#include "formats/bcc4/encode/encode_chunk.h"
#include "kernel/kernel.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

constexpr uint64_t cache = 4ull << 30;
constexpr int level = 6;

Quantiser quantiser_of(const TrialSource& s) {
  Quantiser q = quantiser_of_source(s.source.type, 0);
  q.scale = s.step;
  return q;
}

std::vector<BrickLayer> rounded(const std::vector<BrickLayer>& layers, double step) {
  std::vector<BrickLayer> out;
  for (const BrickLayer& layer : layers) {
    BrickLayer& made = out.emplace_back(layer.lattice(), layer.coset());
    for (size_t slot = 0; slot < layer.brick_slots(); ++slot) {
      if (!layer.brick(slot)) continue;
      auto brick = std::make_shared<Brick>();
      for (size_t i = 0; i < brick_sites; ++i)
        brick->value[i] = static_cast<float>(std::floor(layer.brick(slot)->value[i] / step + 0.5) * step);
      if (brick->keep_above(0) > 0) made.set(slot, std::move(brick));
    }
  }
  return out;
}

// Calls body(shape, bricks, first layer, slot) for each chunk with anything in it, in any order and at once.
template<class Body>
void for_chunks(const Lattice4& lattice, const std::vector<BrickLayer>& layers, int32_t slab_layers,
                const Body& body) {
  test::TestContext context;
  const auto count = static_cast<int32_t>(layers.size());
  const size_t slots = layers[0].brick_slots(); // coset 1 has no more
  const int32_t slabs = (count + slab_layers - 1) / slab_layers;
  context.get().tasks.parallel_for(slabs * slots, [&](uint64_t job) {
    const int32_t first = static_cast<int32_t>(job / slots) * slab_layers;
    const Int3 position = layers[0].slot_position(job % slots);
    const ChunkShape shape = chunk_shape(lattice, first, std::min(slab_layers, count - first), position);
    std::vector<const Brick*> bricks;
    for (int m = 0; m < shape.layers; ++m)
      bricks.push_back(shape.empty(m) ? nullptr
                                      : layers[first + m].brick(position[0], position[1], position[2]));
    if (std::any_of(bricks.begin(), bricks.end(), [](const Brick* b) { return b; }))
      body(shape, bricks, first, position);
  });
}

// Calls body(brick's layer, site) for the kept sites in coding order.
template<class Body> void for_kept(const ChunkSites& sites, const Body& body) {
  for (size_t m = 0; m < sites.kept.size(); ++m)
    for (size_t i = 0; i < brick_sites; ++i)
      if (sites.kept[m][i / brick_edge] >> (i % brick_edge) & 1) body(m, i);
}

uint64_t stored_bytes(const ChunkSites& sites, const ChunkCodes& codes) {
  const EncodedChunk chunk = encode_chunk(sites, codes, level);
  return chunk.entry.values_bytes + chunk.entry.runs_bytes;
}

} // namespace

CoefficientTrials::CoefficientTrials(const TrialSource& source, const std::string& kernel, bool quick)
    : source_(source), kernel_(make_kernel(kernel)), quantiser_(quantiser_of(source)),
      lattice_(Lattice4::fit(LatticeKind::d4star, source.source.dims, {1, 1, 1, 1},
                             source.source.dims[3] > 1 ? 4 : 0)),
      exact_(fitted({})) {
  test::TestContext context;
  LayerWindow window(lattice_, 0);
  for (const BrickLayer& layer : exact_) window.push(layer);
  const Coefficients made(window, 0, kernel_, 0, cache);
  for (int32_t m = 0; m < lattice_.layers(); ++m) coefficients_.push_back(*made.layer(m, context.get()));
  shape_ = noise_shape(kernel_, lattice_.is_static());
  choose_points(source.where, quick ? 4000 : 40000);
  truth_ = field(coefficients_, true);
}

std::vector<BrickLayer> CoefficientTrials::fitted(const Quantiser& quantiser) const {
  test::TestContext context;
  FitOptions options;
  options.dims = source_.source.dims;
  options.lead = lattice_.lead;
  options.channels[0].quantiser = quantiser;
  std::vector<BrickLayer> layers;
  Fit fit(
      options,
      [&](int32_t, int, std::span<const BrickLayer> given) {
        layers.insert(layers.end(), given.begin(), given.end());
      },
      context.get());
  for (uint32_t t = 0; t < options.dims[3]; ++t) {
    const FrameBox box = source_.source.box(t);
    fit.add_frame(0, {&box, 1});
  }
  (void)fit.finish();
  return layers;
}

CoefficientTrials::Field CoefficientTrials::field(const std::vector<BrickLayer>& layers,
                                                  bool coefficients) const {
  test::TestContext context;
  LayerWindow window(lattice_, 0, coefficients ? kernel_.name : "");
  for (const BrickLayer& layer : layers) window.push(layer);
  Field f;
  f.values.resize(points_.size()), f.gradients.resize(points_.size());
  (void)evaluate4(Coefficients(window, 0, kernel_, 0, cache), points_, f.values, f.gradients, context.get());
  return f;
}

// Random points where there is something, and that `where` accepts.
void CoefficientTrials::choose_points(const std::function<bool(const Vec4&)>& where, size_t count) {
  std::vector<Vec4> chosen;
  for (uint32_t seed = 1; seed <= 16 && chosen.size() < count; ++seed) {
    points_ = test::random_points(lattice_, count, seed);
    const Field f = field(coefficients_, true);
    for (size_t i = 0; i < points_.size(); ++i)
      if (std::fabs(f.values[i]) > source_.step / 50 && (!where || where(points_[i])))
        chosen.push_back(points_[i]);
  }
  points_ = std::move(chosen);
}

FieldErrors CoefficientTrials::errors(const std::vector<BrickLayer>& layers, bool coefficients) const {
  const Field f = field(layers, coefficients);
  const auto vec = [](const std::array<float, 4>& g) { return Vec3{g[0], g[1], g[2]}; };
  const auto shade = [&](const Vec3& g) { // by a lamp somewhere
    return 255 * std::fabs(dot(g, {0.48, 0.6, 0.64})) / std::sqrt(std::max(dot(g, g), 1e-30));
  };
  const auto n = static_cast<double>(points_.size());
  double power = 0, shaded = 0;
  for (const auto& g : truth_.gradients) power += dot(vec(g), vec(g)) / n;
  FieldErrors e;
  for (size_t i = 0; i < points_.size(); ++i) {
    const double d = (static_cast<double>(f.values[i]) - truth_.values[i]) / source_.step;
    const Vec3 g = vec(truth_.gradients[i]), h = vec(f.gradients[i]), change = (1 / source_.step) * (h - g);
    e.rms += d * d;
    e.largest = std::max(e.largest, std::fabs(d));
    e.gradient += dot(change, change) / 3;
    if (dot(g, g) < power / 4) continue;
    const double grey = shade(h) - shade(g);
    e.luminance += grey * grey, ++shaded;
  }
  e.rms = std::sqrt(e.rms / n), e.gradient = std::sqrt(e.gradient / n);
  e.luminance = std::sqrt(e.luminance / std::max(shaded, 1.0));
  return e;
}

TrialResult CoefficientTrials::samples() const {
  const std::vector<BrickLayer> layers = fitted(quantiser_);
  const SampleCoder coder(quantiser_);
  TrialResult result;
  std::mutex mutex;
  for_chunks(lattice_, layers, 8,
             [&](const ChunkShape& shape, const std::vector<const Brick*>& bricks, int32_t, const Int3&) {
               ChunkSites sites;
               sites.shape = shape;
               for (const Brick* brick : bricks) sites.kept.push_back(brick ? brick->kept : BrickMask{});
               uint64_t clamped = 0;
               for_kept(sites, [&](size_t m, size_t i) {
                 sites.codes.push_back(coder.encode(bricks[m]->value[i], clamped));
               });
               keep_scattered_air(sites, coder.codes());
               const uint64_t bytes = stored_bytes(sites, coder.codes());
               const std::scoped_lock lock(mutex);
               result.bytes += bytes, result.sites += sites.codes.size();
             });
  result.error = errors(layers, false);
  return result;
}

FieldErrors CoefficientTrials::unclamped() const { return errors(rounded(exact_, source_.step), false); }

TrialResult CoefficientTrials::coefficients(const Trial& trial) const {
  CoefficientCoding coding;
  coding.step = trial.step * source_.step;
  coding.most_shift = trial.most_shift;
  coding.shape_all = trial.shaped;
  if (trial.shaped || trial.most_shift > 0) coding.shape = shape_;
  std::vector<BrickLayer> layers;
  for (const BrickLayer& layer : coefficients_) layers.emplace_back(layer.lattice(), layer.coset());
  TrialResult result;
  std::mutex mutex;
  for_chunks(lattice_, coefficients_, trial.slab_layers,
             [&](const ChunkShape& shape, const std::vector<const Brick*>& bricks, int32_t first,
                 const Int3& position) {
               const CoefficientChunk chunk = round_coefficients(shape, bricks, coding);
               if (chunk.sites.codes.empty()) return;
               std::vector<std::shared_ptr<Brick>> made(bricks.size());
               const uint32_t* code = chunk.sites.codes.data();
               for_kept(chunk.sites, [&](size_t m, size_t i) {
                 if (!made[m]) made[m] = std::make_shared<Brick>();
                 made[m]->value[i] = static_cast<float>(coefficient_of(*code++, coding));
               });
               for (size_t m = 0; m < made.size(); ++m) {
                 if (!made[m] || made[m]->keep_above(0) == 0) continue;
                 BrickLayer& layer = layers[first + m];
                 layer.set(layer.slot(position[0], position[1], position[2]), std::move(made[m]));
               }
               const uint64_t bytes = stored_bytes(chunk.sites, i32_codes);
               const std::scoped_lock lock(mutex);
               result.bytes += bytes, result.sites += chunk.sites.codes.size();
             });
  result.error = errors(layers, true);
  return result;
}

} // namespace bccsplat::bench
