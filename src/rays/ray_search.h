// SPDX-License-Identifier: Apache-2.0
// Where the rays of a square of pixels meet an opaque isosurface first.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/progress.h"
#include "rays/ray_roots.h"
#include "rays/ray_way.h"
#include "shade/surface.h"
#include "view/view.h"

namespace bccsplat {

// What the rays of a picture search, all of which must outlive them.
struct RayField {
  const SurfaceField* field = nullptr;
  const SheetView* view = nullptr;
  double target = 0;      // relative to the base
  size_t most_sheets = 0; // of any ray in a slab
};

struct RayHit {
  int i = 0, j = 0; // pixel
  SurfacePoint point;
};

struct RayCounts {
  uint64_t samples = 0, grazes = 0, hits = 0;
  RayCounts& operator+=(const RayCounts& part) {
    samples += part.samples, grazes += part.grazes, hits += part.hits;
    return *this;
  }
};

// One thread's memory.
class RaySearch {
 public:
  static constexpr int square = 32; // pixels a side of those that go on together

  explicit RaySearch(const RayField& of);
  // Bytes that it takes beside its own size; what the few crossings of a slab need is not counted.
  [[nodiscard]] static uint64_t buffers(size_t most_sheets);

  // Returns the first hits of the rays through width x height pixels from (x, y) on, at most a square, that
  // go this way, in any order; they are good until the next call. Throws cancelled.
  [[nodiscard]] std::span<const RayHit> find(const RayWay& way, int x, int y, int width, int height,
                                             Progress& progress);
  [[nodiscard]] const RayCounts& counts() const { return counts_; } // of all calls

 private:
  // The last sample of a ray.
  struct Station {
    int k = -(1 << 30);         // none
    float value = 0, slope = 0; // per sheet
  };
  // The samples of one ray in a slab; of all, those from `next` on are to be looked at with the one behind
  // them, and first of all that before them with the first one.
  struct Part {
    uint32_t ray, begin, end, next;
    bool joins;
  };

  // Rays are counted piece by piece.
  static constexpr int pieces = square / piece_edge; // a side
  static constexpr size_t pixels = square * square;
  static_assert(pixels <= RayRoots::room);
  [[nodiscard]] int column(uint32_t r) const {
    return x_ + static_cast<int>(r / piece_rays % pieces * piece_edge + r % piece_edge);
  }
  [[nodiscard]] int row(uint32_t r) const {
    return y_ + static_cast<int>(r / piece_rays / pieces * piece_edge + r % piece_rays / piece_edge);
  }

  struct Piece {
    uint64_t open = 0; // rays
    std::span<const uint64_t> slabs;
    PieceWay way;
  };
  void begin(int width, int height);
  void cut(Piece& piece, int x, int y) const;
  void draw_slab(size_t word, int bit);
  void ask(uint32_t r, int slab, uint64_t layers);
  void search();
  void scan(uint32_t p);
  void settle();
  void find_turns();
  bool note(const Station& before, const Station& here, uint32_t p);
  bool hit(uint32_t p, double k);
  void light();
  [[nodiscard]] Station station(uint32_t n) const { return {samples_[n], values_[n], slopes_[n]}; }

  const RayField& f_;
  const SheetView& view_;
  const RayWay* way_ = nullptr;
  float side_; // the least float that is not below the target
  RayCounts counts_;
  int x_ = 0, y_ = 0;
  std::array<Piece, size_t{pieces} * pieces> piece_;
  std::array<Station, pixels> last_;
  uint32_t count_ = 0;       // of the samples of a slab
  std::vector<int> samples_; // sheets
  std::vector<Vec4> places_;
  std::vector<std::array<float, 4>> steps_; // lattice units of a sheet along the ray
  std::vector<float> values_, slopes_;
  std::vector<std::array<float, 4>> gradients_;
  std::vector<uint64_t> found_; // samples between which and the next there is something to look for
  std::vector<Part> parts_;
  std::vector<uint32_t> scanned_; // parts that are to be scanned
  RayRoots roots_;
  std::vector<Crossing> grazes_;
  std::vector<uint8_t> passed_; // by part
  Affine3 to_lattice_;
  std::vector<RayHit> hits_;
  // Hits whose gradients are yet to come from samples near them.
  struct Unlit {
    std::vector<RayHit> hits;
    std::vector<Vec3> positions, gradients;
    std::vector<double> values;
    void clear() { hits.clear(), positions.clear(), gradients.clear(), values.clear(); }
  } unlit_;
};

} // namespace bccsplat
