// SPDX-License-Identifier: Apache-2.0
// Which planes of which layers each stage of a prefilter adds up, and where they lie in memory.
#pragma once

#include <map>
#include <vector>

#include "field/coefficients/prefilter.h"
#include "field/coefficients/stage_plane.h"

namespace bccsplat {

class StagePlan {
 public:
  // Some planes of a layer, those around the one that is being made: plane z takes the place of z - depth.
  struct Ring {
    int depth = 0;
    size_t first = 0; // of its planes, in planes
  };
  // One layer of one stage.
  struct Node {
    struct Input {
      size_t ring;
      float centre, neighbours; // weights
    };
    int margin = 0; // sites around those that are wanted
    int32_t layer = 0;
    std::vector<Input> inputs; // those whose neighbours count come first
    size_t neighbour_inputs = 0;
    std::vector<size_t> cross; // rings
    // Sites i + shift and i + shift + span per axis surround site i. BCC and D4*: those of the other coset,
    // shift -1 or 0, span 1. CC: the corners (+-1, +-1, +-1) of the samples themselves, shift -1, span 2.
    int shift = 0, span = 1;
    float cross_weight = 0;
    Ring neighbours, corners; // sums for the planes of this node
    size_t ring = 0;          // what it makes
  };
  struct Samples {
    int32_t layer;
    size_t ring;
  };

  StagePlan(const Prefilter& filter, std::span<const int32_t> layers);

  [[nodiscard]] int margin() const { return margin_; } // of samples
  [[nodiscard]] const std::vector<Samples>& samples() const { return samples_; }
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; } // stage by stage
  [[nodiscard]] size_t wanted() const { return wanted_; } // the last so many nodes make `layers`, in order
  [[nodiscard]] const Ring& ring(size_t i) const { return rings_[i]; }
  [[nodiscard]] size_t planes() const { return planes_; } // of all rings

 private:
  using Key = std::pair<int, int32_t>; // stage, layer

  void place(const Prefilter& filter);
  Ring add_ring(int depth);
  Node node_of(const Prefilter& filter, int stage, int32_t layer) const;

  std::vector<int> margins_, depths_; // per stage, samples first
  int margin_ = 0;
  std::vector<Samples> samples_;
  std::vector<Node> nodes_;
  size_t wanted_ = 0;
  std::vector<Ring> rings_;
  std::map<Key, size_t> ring_of_;
  size_t planes_ = 0;
};

} // namespace bccsplat
