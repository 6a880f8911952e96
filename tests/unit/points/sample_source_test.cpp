// SPDX-License-Identifier: Apache-2.0
#include "points/sample_source.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/would_block.h"
#include "tests/support/fields.h"

namespace bccsplat {
namespace {

// Layers of which the odd ones are not there yet.
class Late final : public SampleSource {
 public:
  const Lattice4& lattice() const override { return lattice_; }
  int channels() const override { return 1; }
  float air(int) const override { return 0; }
  BrickLayer read_layer(int, int32_t layer, const BrickBox&, const Context&) const override {
    const auto at = static_cast<uint64_t>(layer);
    if (layer % 2 == 1) throw WouldBlock("late", {{100 * at, 10}});
    return {lattice_.space, lattice_.coset(layer)};
  }
  const std::string& coefficient_kernel() const override { return none_; }

 private:
  Lattice4 lattice_ = Lattice4::fit(LatticeKind::d4star, {4, 4, 4, 6});
  std::string none_;
};

TEST(SampleSource, LayersThatAreLateAreToldTogetherAfterTheOthers) {
  const Late source;
  test::TestContext context;
  const std::vector<int32_t> layers{0, 1, 2, 3, 4};
  std::vector<int32_t> taken;
  std::vector<ByteRange> lacking;
  try {
    source.read_layers(0, layers, {}, context.get(), [&](int32_t m, BrickLayer&&) { taken.push_back(m); });
  } catch (const WouldBlock& e) {
    lacking = e.lacking();
  }
  EXPECT_EQ(taken, (std::vector<int32_t>{0, 2, 4}));
  EXPECT_EQ(lacking, (std::vector<ByteRange>{{100, 10}, {300, 10}}));
}

} // namespace
} // namespace bccsplat
