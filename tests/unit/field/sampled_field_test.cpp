// SPDX-License-Identifier: Apache-2.0
// The samples of a volume that stores coefficients: the field of its kernel at the sites.
#include "field/coefficients/sampled_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "field/evaluate.h"
#include "fit/coefficients/layer_window.h"
#include "kernel/cc_kernel.h"
#include "tests/support/fields.h"

namespace bccsplat {
namespace {

using test::TestContext;

// A series of noise in [-1, 1], some bricks of it air, as coefficients of a kernel.
LayerWindow noise_coefficients(const Lattice4& lattice, const std::string& kernel) {
  LayerWindow window(lattice, 2.5f, make_kernel(kernel).name);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> value(-1, 1);
  for (int32_t m = 0; m < lattice.layers(); ++m) {
    const int c = lattice.coset(m);
    std::vector<float> dense(static_cast<size_t>(lattice.space.sites(c)));
    for (float& v : dense) v = value(random);
    BrickLayer layer = layer_from_dense(lattice.space, c, dense);
    for (size_t s = 0; s + 1 < layer.brick_slots(); ++s)
      if (random() % 3 == 0) layer.set(s, nullptr);
    window.push(std::move(layer));
  }
  return window;
}

TEST(SampledField, IsTheFieldAtTheSites) {
  TestContext context;
  struct Case {
    LatticeKind kind;
    std::array<uint32_t, 4> dims;
    const char* kernel;
  };
  for (const auto& [kind, dims, kernel] :
       {Case{LatticeKind::d4star, {30, 25, 12, 6}, "default"},
        Case{LatticeKind::d4star, {24, 9, 40, 5}, "fine"}, Case{LatticeKind::d4star, {9, 8, 7, 9}, "fast"},
        Case{LatticeKind::bcc, {30, 25, 24, 1}, "default"}, Case{LatticeKind::cc, {18, 17, 9, 5}, "default"},
        Case{LatticeKind::cc, {18, 17, 9, 1}, "fast"}}) {
    SCOPED_TRACE(std::string(kernel) + " on kind " + std::to_string(static_cast<int>(kind)));
    const Lattice4 lattice = Lattice4::fit(kind, dims);
    const LayerWindow stored = noise_coefficients(lattice, kernel);
    const Kernel own = lattice.space.bcc ? make_kernel(kernel) : make_cc_kernel(kernel).kernel;
    const SampledField sampled(stored, own, 0);
    const Coefficients field(stored, 0, make_kernel(kernel), 0, uint64_t{1} << 30);
    EXPECT_TRUE(sampled.coefficient_kernel().empty());
    EXPECT_EQ(sampled.air(0), 2.5f);
    std::vector<Vec4> points;
    std::vector<float> expected;
    for (int32_t m = 0; m < lattice.layers(); ++m) {
      const int c = lattice.coset(m);
      const BrickLayer layer = sampled.read_layer(0, m, {}, context.get());
      const Int3 n = lattice.space.dims(c);
      for (int z = 0; z < n[2]; ++z)
        for (int y = 0; y < n[1]; ++y)
          for (int x = 0; x < n[0]; ++x) {
            const Vec3 p = lattice.site_position(c, {x, y, z});
            points.push_back({p[0], p[1], p[2], lattice.is_static() ? 0 : lattice.layer_frame(m)});
            expected.push_back(layer.value(x, y, z));
          }
    }
    std::vector<float> values(points.size());
    std::vector<uint8_t> holes(points.size());
    evaluate4_mirrored(field, points, values, {}, holes, context.get());
    for (size_t i = 0; i < points.size(); ++i) ASSERT_NEAR(values[i], expected[i], 4e-6) << "site " << i;
  }
}

// Bricks outside the region are absent, those inside are as without one.
TEST(SampledField, OfARegion) {
  TestContext context;
  const Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, {60, 25, 60, 6});
  const LayerWindow stored = noise_coefficients(lattice, "default");
  const SampledField sampled(stored, make_kernel("default"), 0);
  const BrickBox region{{1, 0, 1}, {2, 1, 3}};
  const BrickLayer all = sampled.read_layer(0, 3, {}, context.get()),
                   some = sampled.read_layer(0, 3, region, context.get());
  for (size_t s = 0; s < all.brick_slots(); ++s) {
    if (!region.contains(all.slot_position(s))) {
      EXPECT_EQ(some.brick(s), nullptr);
      continue;
    }
    ASSERT_EQ(all.brick(s) != nullptr, some.brick(s) != nullptr);
    if (all.brick(s)) {
      EXPECT_EQ(all.brick(s)->value, some.brick(s)->value);
    }
  }
}

// Counts what is asked for.
class Asked final : public SampleSource {
 public:
  explicit Asked(const SampleSource& from) : from_(from) {}
  const Lattice4& lattice() const override { return from_.lattice(); }
  int channels() const override { return from_.channels(); }
  float air(int channel) const override { return from_.air(channel); }
  const std::string& coefficient_kernel() const override { return from_.coefficient_kernel(); }
  BrickLayer read_layer(int channel, int32_t layer, const BrickBox& region,
                        const Context& context) const override {
    ++times[layer];
    box = region;
    // What is outside the region is absent, as it is of a file.
    BrickLayer read = from_.read_layer(channel, layer, {}, context);
    for (size_t s = 0; s < read.brick_slots(); ++s)
      if (!region.contains(read.slot_position(s))) read.set(s, nullptr);
    return read;
  }
  mutable std::map<int32_t, int> times;
  mutable BrickBox box;

 private:
  const SampleSource& from_;
};

// Layers that are asked for together are what they are one by one, and every stored layer is read once.
TEST(SampledField, LayersTogether) {
  TestContext context;
  for (const bool periodic : {false, true}) {
    const Lattice4 lattice =
        Lattice4::fit(LatticeKind::d4star, {20, 17, 19, 8}, {1, 1, 1, 1}, 0, {0, 0, 0}, periodic);
    const LayerWindow stored = noise_coefficients(lattice, "default");
    const Asked asked(stored);
    const SampledField sampled(asked, make_kernel("default"), 0);
    const std::vector<int32_t> layers{0, 1, 2, 5, 9, 6};
    std::vector<std::pair<int32_t, BrickLayer>> together;
    sampled.read_layers(0, layers, {}, context.get(),
                        [&](int32_t m, BrickLayer&& layer) { together.emplace_back(m, std::move(layer)); });
    ASSERT_EQ(together.size(), layers.size());
    for (const auto& [m, count] : asked.times) EXPECT_EQ(count, 1) << "layer " << m;
    for (size_t i = 0; i < layers.size(); ++i) {
      EXPECT_EQ(together[i].first, layers[i]);
      const BrickLayer alone = sampled.read_layer(0, layers[i], {}, context.get());
      for (size_t s = 0; s < alone.brick_slots(); ++s) {
        ASSERT_EQ(alone.brick(s) != nullptr, together[i].second.brick(s) != nullptr);
        if (alone.brick(s)) {
          EXPECT_EQ(alone.brick(s)->value, together[i].second.brick(s)->value);
        }
      }
    }
  }
}

// Sites on the planes asked for have the values they have in all of the layer; of what is stored only the
// bricks are read that these depend on.
TEST(SampledField, OnPlanes) {
  TestContext context;
  struct Case {
    PlaneRange planes;
    int32_t begin, end; // bricks read along the axis, of D4*
  };
  for (const auto kind : {LatticeKind::d4star, LatticeKind::cc})
    for (const bool turning : {false, true}) {
      const AxisFlags axes{turning, turning, turning};
      const Lattice4 lattice = Lattice4::fit(kind, {70, 40, 50, 5}, {1, 1, 1, 1}, 0, {0, 0, 0}, false, axes);
      const LayerWindow stored = noise_coefficients(lattice, "default");
      const Asked asked(stored);
      const Kernel own = lattice.space.bcc ? make_kernel("default") : make_cc_kernel("default").kernel;
      const SampledField sampled(asked, own, 0);
      for (const auto& [planes, begin, end] :
           {Case{{0, 40, 55}, 1, 2}, Case{{0, 30, 50}, 0, 2}, Case{{0, 0, 5}, 0, 1}, Case{{1, 36, 39}, 1, 2},
            Case{{2, 10, 29}, 0, 1}, Case{{2, 10, 31}, 0, 2}, Case{{0, 33, 33}, 0, 2}}) {
        const std::vector<int32_t> layers{2, 3};
        sampled.read_planes(0, layers, planes, context.get(), [&](int32_t m, BrickLayer&& some) {
          const BrickLayer all = SampledField(stored, own, 0).read_layer(0, m, {}, context.get());
          const Int3 n = all.dims();
          const size_t a = planes.axis;
          for (int z = 0; z < n[2]; ++z)
            for (int y = 0; y < n[1]; ++y)
              for (int x = 0; x < n[0]; ++x) {
                const int32_t plane = lattice.space.plane(all.coset(), Int3{x, y, z}[a]);
                if (plane >= planes.first && plane <= planes.last) {
                  ASSERT_EQ(some.value(x, y, z), all.value(x, y, z));
                }
              }
        });
        if (kind == LatticeKind::d4star && !turning) {
          EXPECT_EQ(asked.box.begin[planes.axis], begin);
          EXPECT_EQ(asked.box.end[planes.axis], end);
        }
      }
    }
}

} // namespace
} // namespace bccsplat
