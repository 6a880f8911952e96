// SPDX-License-Identifier: Apache-2.0
// Coarse to fine: in the coarsest level everywhere near, then where the level above and its neighbours say,
// and from there downhill.
#include "motion/match.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "motion/block.h"

namespace bccsplat::motion {
namespace {

constexpr int32_t first_reach = 3;                  // samples of the coarsest level
constexpr int32_t first_block = 2, later_block = 3; // reach of blocks, in the coarsest level and in others
constexpr int32_t descents = 3;                     // steps to a better neighbour in a level
constexpr float price = .004f;         // of a squared sample from what was expected, in contents of a block
constexpr float least_content = 1e-5f; // of the largest: less is nothing to see
constexpr float least_agreement = .3f; // of a block's content that has to be found again

// The search for one block in one level.
class Search {
 public:
  Search(const Block& block, const Box& to, const Float3& expected)
      : block_(block), to_(to), expected_(expected) {}

  void look(const Int3& moved) {
    float off = 0;
    for (size_t a = 0; a < 3; ++a) {
      const float d = static_cast<float>(moved[a]) - expected_[a];
      off += d * d;
    }
    const float penalty = price * block_.content() * off;
    const float cost = penalty + block_.difference(to_, moved, best_ - penalty);
    if (cost < best_) best_ = cost, at_ = moved;
  }
  // Everywhere within `reach` of where it is.
  void look_around(int32_t reach) {
    const Int3 middle = at_;
    for (int32_t z = -reach; z <= reach; ++z)
      for (int32_t y = -reach; y <= reach; ++y)
        for (int32_t x = -reach; x <= reach; ++x)
          if (x * x + y * y + z * z <= reach * reach + 1) look({middle[0] + x, middle[1] + y, middle[2] + z});
  }
  void descend() {
    for (int32_t i = 0; i < descents; ++i) {
      const Int3 before = at_;
      look_around(1);
      if (at_ == before) return;
    }
  }
  [[nodiscard]] const Int3& at() const { return at_; }
  // The share of the block's content that is found again.
  [[nodiscard]] float agreement() const {
    return 1 - block_.difference(to_, at_, std::numeric_limits<float>::max()) / block_.content();
  }

 private:
  const Block& block_;
  const Box& to_;
  Float3 expected_;
  Int3 at_{};
  float best_ = std::numeric_limits<float>::max();
};

Int3 in_samples(const Float3& moved, const Int3& factor) {
  Int3 n;
  for (size_t a = 0; a < 3; ++a)
    n[a] = static_cast<int32_t>(std::lround(moved[a] / static_cast<float>(factor[a])));
  return n;
}

Int3 samples_of(const Level& level) {
  Int3 n;
  for (size_t a = 0; a < 3; ++a) n[a] = (level.box.dims[a] - 1) * level.factor[a] + 1;
  return n;
}

// The blocks around the nodes of a level.
std::vector<Block> blocks_of(const Level& level, const Nodes& nodes, int32_t reach) {
  std::vector<Block> blocks;
  for (size_t i = 0; i < nodes.count(); ++i) {
    Int3 at = nodes.node(i);
    for (size_t a = 0; a < 3; ++a) at[a] = at[a] * nodes.spacing / level.factor[a];
    blocks.emplace_back(level.box, at, reach);
  }
  return blocks;
}

// What the level above says of a place: straight between its nodes, and each of these.
struct Hints {
  Float3 expected{}; // samples of the frame
  std::vector<Float3> others;

  Hints(const Matches* above, const Nodes& nodes, size_t i) {
    if (!above) return;
    Float3 place;
    for (size_t a = 0; a < 3; ++a) place[a] = static_cast<float>(nodes.node(i)[a] * nodes.spacing);
    const Corners around = corners(above->nodes, place);
    for (size_t k = 0; k < 8; ++k) {
      others.push_back(above->moved[around.node[k]]);
      for (size_t a = 0; a < 3; ++a) expected[a] += around.share[k] * others.back()[a];
    }
  }
};

Search searched(const Block& block, const Level& to, const Hints& hints) {
  Float3 expected = hints.expected;
  for (size_t a = 0; a < 3; ++a) expected[a] /= static_cast<float>(to.factor[a]);
  Search search(block, to.box, expected);
  search.look({0, 0, 0});
  if (hints.others.empty()) search.look_around(first_reach);
  search.look(in_samples(hints.expected, to.factor));
  for (const Float3& moved : hints.others) search.look(in_samples(moved, to.factor));
  search.descend();
  return search;
}

// All blocks of a level, the one above it known or null.
Matches match_level(const Level& from, const Level& to, int32_t spacing, const Matches* above) {
  Matches m{nodes_over(samples_of(from), spacing), {}, {}};
  m.weight.resize(m.nodes.count());
  const std::vector<Block> blocks = blocks_of(from, m.nodes, above ? later_block : first_block);
  float largest = 0;
  for (const Block& b : blocks) largest = std::max(largest, b.content());
  for (size_t i = 0; i < m.nodes.count(); ++i) {
    const Hints hints(above, m.nodes, i);
    m.moved.push_back(hints.expected);
    if (blocks[i].content() <= least_content * largest) continue;
    const Search search = searched(blocks[i], to, hints);
    for (size_t a = 0; a < 3; ++a) m.moved[i][a] = static_cast<float>(search.at()[a] * from.factor[a]);
    const float found = std::max(search.agreement() - least_agreement, 0.f);
    m.weight[i] = blocks[i].content() * found * found;
  }
  return m;
}

} // namespace

Matches match(std::span<const Level> from, std::span<const Level> to, int32_t spacing) {
  Matches found;
  for (size_t l = from.size(); l-- > 0;) {
    const Int3& f = from[l].factor;
    const int32_t apart = std::max(spacing, 2 * std::max({f[0], f[1], f[2]}));
    found = match_level(from[l], to[l], l == 0 ? spacing : apart, l + 1 < from.size() ? &found : nullptr);
  }
  return found;
}

} // namespace bccsplat::motion
