// SPDX-License-Identifier: Apache-2.0
// A box of bricks through all stages of a prefilter, plane by plane along z. Outside a rectangle of each
// plane all is 0, and nothing is done there.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "field/coefficients/filled_box.h"
#include "field/coefficients/stage_plan.h"
#include "points/brick.h"
#include "points/sample_source.h"

namespace bccsplat {

// Tells which bricks may hold coefficients: those beside which, or where, some layer of samples holds a
// brick, across the ends of periodic axes as well. Mirror images lie no further away, and no prefilter
// reaches 16 sites.
class NearBricks {
 public:
  NearBricks(const std::map<int32_t, const SampleLayer*>& samples, const BrickBox& region);
  // Makes a box in the region as small as those in it allow; returns whether there are any.
  bool trim(BrickBox& box) const;

 private:
  [[nodiscard]] size_t index(int x, int y, int z) const {
    return ((z - region_.begin[2]) * height_ + (y - region_.begin[1])) * width_ + (x - region_.begin[0]);
  }
  BrickBox region_;
  size_t width_, height_;
  std::vector<uint8_t> near_;
};

// What the planes of a tile take in memory.
struct TileSize {
  int margin = 0;
  std::ptrdiff_t stride = 0, plane = 0; // floats
  size_t planes = 0;

  TileSize(const StagePlan& plan, const Int3& bricks);
  // Sites behind the last row are read and written.
  [[nodiscard]] size_t floats() const { return plane * planes + slack; }
  [[nodiscard]] uint64_t bytes() const { return floats() * sizeof(float); }
  static constexpr size_t slack = 32;
};

// A layer that is made, and its samples, whose holes it takes over.
struct TileLayer {
  SampleLayer* made;
  const SampleLayer* samples;
};

class TilePlanes {
 public:
  // memory: size.floats() finite numbers.
  TilePlanes(const StagePlan& plan, const TileSize& size, const Lattice3& space, const BrickBox& tile,
             float* memory);
  // Makes the bricks of the tile. outputs: in the order of the layers of the plan.
  void make(const std::map<int32_t, const SampleLayer*>& samples, std::span<const TileLayer> outputs,
            const CoefficientForm& form, const Progress& progress);

 private:
  using Ring = StagePlan::Ring;
  using Node = StagePlan::Node;

  // The first site of the tile in plane z of a ring.
  [[nodiscard]] float* at(const Ring& ring, int z) const;
  [[nodiscard]] float* at(size_t ring, int z) const { return at(plan_.ring(ring), z); }
  // Returns what is filled of plane z of a ring.
  [[nodiscard]] FilledBox& filled(const Ring& ring, int z) { return filled_[plane_number(ring, z)]; }
  [[nodiscard]] FilledBox& filled(size_t ring, int z) { return filled(plan_.ring(ring), z); }
  [[nodiscard]] static size_t plane_number(const Ring& ring, int z) {
    return ring.first + ((z % ring.depth) + ring.depth) % ring.depth;
  }
  // The sites of the tile and `margin` around.
  [[nodiscard]] FilledBox around(int margin) const;
  // Returns the way from the first site of the tile to that of a box.
  [[nodiscard]] std::ptrdiff_t first(const FilledBox& box) const {
    return box.first_y * size_.stride + box.first_x;
  }
  [[nodiscard]] PlaneBox plane_box(const FilledBox& box) const {
    return {box.end_x - box.first_x, box.end_y - box.first_y, size_.stride};
  }
  // Makes the plane that z takes the place of 0 outside a box, and notes the box.
  void fill_only(const FilledBox& box, const Ring& ring, int z);

  // Sites that follow each other in a brick.
  struct Run {
    int brick, site; // the first one
    int to;          // its place in the tile
    int count;
  };
  [[nodiscard]] std::vector<Run> runs_of(size_t axis, int coset) const;
  void load(const SampleLayer& layer, size_t ring, int z);
  void load_run(const SampleBrick& brick, const PlanePart& part, float* to) const;
  void step(const Node& node, int z);
  void sum_neighbours(const Node& node, int z);
  void sum_cross(const Node& node, int z);
  struct Making {
    std::shared_ptr<Brick> brick; // stays for the next one where it was handed over rounded
    int planes = 0;               // that have been written; those behind them are 0
    bool any = false;

    void fill_to(int end);
  };
  static void hand_over(Making& making, const TileLayer& layer, size_t slot, float coarsest);
  void keep(const Node& node, size_t output, const TileLayer& layer, int z, const CoefficientForm& form);

  const StagePlan& plan_;
  const TileSize& size_;
  const Lattice3& space_;
  BrickBox tile_;
  Int3 begin_{}, end_{};                                // sites
  std::array<std::array<std::vector<Run>, 2>, 2> runs_; // per coset, along x and y
  float* memory_;
  std::vector<FilledBox> filled_; // per plane
  std::vector<Making> bricks_;    // of one plane of bricks, per output
};

} // namespace bccsplat
