// SPDX-License-Identifier: Apache-2.0
// Corrections of a series at its source samples (formats/bcc4.md, section 10), on the reading side: they keep
// the error bound that was asked for at import, and belong to the field: whoever looks at it sees them.
//
// They are read brick by brick, as far as they are looked at, and kept in a cache; those of older files frame
// by frame.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "base/byte_range.h"
#include "base/context.h"
#include "base/lru_cache.h"
#include "base/vec.h"
#include "field/fall_off.h"
#include "field/sparse_grid.h"
#include "points/correction_source.h"

namespace bccsplat {

class Corrections {
 public:
  // budget: of the cache; outlives the object.
  Corrections(std::unique_ptr<const CorrectionSource> source, MemoryBudget& budget, uint64_t cache_bytes);

  [[nodiscard]] bool any() const { return source_->any(); } // else there is a bound alone
  [[nodiscard]] CorrectionShape shape() const { return source_->shape(); }
  [[nodiscard]] double step() const { return source_->step(); }
  [[nodiscard]] const std::array<int64_t, 4>& samples() const { return n_; } // along x, y, z, t

  // Samples from `begin` on, before `end`; all of them.
  struct Box {
    Int3 begin{}, end{INT32_MAX, INT32_MAX, INT32_MAX};
  };
  // Appends where the corrections of a frame stand that each() reads; missing: but those that are cached.
  // Reads its table.
  void list_reads(int64_t frame, bool missing, const Box& box, std::vector<ByteRange>& out) const;
  // Returns how many samples of the series have one; where the file does not tell, as far as its tables are
  // whole.
  [[nodiscard]] uint64_t count() const;

  // Adds to values, and gradients per index unit (empty, or one per point), at points (x, y, z, t) of index
  // space. NaN stay, but at source samples that the file has in spite of a hole. Returns how many of these
  // there were.
  uint64_t add_to_points(std::span<const Vec4> points, std::span<float> values,
                         std::span<std::array<float, 4>> gradients, const Context& context) const;
  // Calls body(source sample, value) for the corrections of a frame in a box, and for what is read with them.
  void each(int64_t frame, const std::function<void(const Int3&, float)>& body, const Box& box) const;
  void each(int64_t frame, const std::function<void(const Int3&, float)>& body) const {
    each(frame, body, {});
  }
  // The same for values, air included, of samples that lie in holes of the lattice.
  void each_set(int64_t frame, const std::function<void(const Int3&, float)>& body) const;

 private:
  // A frame without its bricks.
  struct Frame {
    std::vector<CorrectionBrick> table;
    SparseGrid whole; // what is in no brick
    SparseGrid set;   // values
    [[nodiscard]] bool empty() const { return table.empty() && whole.empty() && set.empty(); }
  };
  class Lookup;
  [[nodiscard]] std::shared_ptr<const Frame> frame(int64_t frame) const;
  [[nodiscard]] std::shared_ptr<const SparseGrid> brick(int64_t frame, const CorrectionBrick& entry) const;
  [[nodiscard]] bool meets(const CorrectionBrick& entry, const Box& box) const;
  // Keeps a value in the cache where the budget has room for it.
  template<class Key, class Value>
  void keep(LruCache<Key, Value>& cache, const Key& key, const std::shared_ptr<const Value>& value,
            uint64_t bytes) const;

  std::unique_ptr<const CorrectionSource> source_;
  CorrectionBricks geometry_;
  std::array<int64_t, 4> n_{};
  MemoryBudget& budget_;
  mutable LruCache<int64_t, Frame> frames_;
  mutable LruCache<std::pair<int64_t, uint32_t>, SparseGrid> bricks_;
};

} // namespace bccsplat
