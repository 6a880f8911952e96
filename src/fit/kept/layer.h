// SPDX-License-Identifier: Apache-2.0
// One lattice layer out of the frames within reach: the temporal filter, rounding and relevance, brick by
// brick.
#pragma once

#include <span>
#include <vector>

#include "base/context.h"
#include "base/pool.h"
#include "fit/kept/histogram.h"
#include "fit/kept/relevance.h"
#include "fit/kept/site_block.h"
#include "formats/bcc4/coding/codes.h"
#include "points/sample_layer.h"
#include "points/sample_source.h"

namespace bccsplat {

// Counts of the sites of a channel; each thread has its own.
struct SiteCounts {
  KeptCounts sites;
  SampleHistogram samples;
};

// Distances of stored values from those the filter made: by rounding, clamping, and dropping as air.
struct CodingError {
  double largest = 0, squares = 0; // over all sites of the bricks that are not air throughout
};

struct LayerTap {
  const FrameSites* frame = nullptr;
  float weight = 0;
};

// The bricks of a layer that are made, and those of them that enter counts and coding errors.
struct LayerBricks {
  BrickBox made{}, counted{};
};

struct MadeLayer {
  SampleLayer layer;
  Reservation memory; // of its bricks
};

class LayerMaker {
 public:
  // ringing: as SiteEvidence::ringing, but a fraction of the largest departure from air in reach.
  LayerMaker(const Quantiser& quantiser, float threshold, float ringing)
      : LayerMaker(quantiser, Relevance(quantiser, threshold), ringing) {}

  // One that makes the same layers and has counted nothing.
  [[nodiscard]] LayerMaker again() const { return {quantiser_, relevance_, ringing_}; }

  // Values are those of taps[nearest] plus the weighted differences of the others from it, so that what does
  // not change stays as it is; holes are those of taps[nearest]. Weights sum to 1. beyond: a layer that no
  // reader shows, before the first frame or after the last one; its clamped sites and coding errors are not
  // counted. Bricks of integers are codes.
  [[nodiscard]] MadeLayer make(const Lattice3& lattice, int coset, std::span<const LayerTap> taps,
                               size_t nearest, bool beyond, const Context& context,
                               const LayerBricks& bricks = {});
  [[nodiscard]] SiteCounts counts() const;
  [[nodiscard]] uint64_t clamped() const; // of counts().sites, without summing the rest
  // Summed layer by layer, the same for any number of threads.
  [[nodiscard]] const CodingError& coding_error() const { return coding_; }

 private:
  LayerMaker(const Quantiser& quantiser, const Relevance& relevance, float ringing)
      : quantiser_(quantiser), coder_(quantiser), relevance_(relevance), ringing_(ringing) {}

  struct Frames; // those of a layer
  struct Room;   // of a task, for one brick after the other
  // Makes one brick, of `size` sites inside the domain; empty: all of it is air.
  [[nodiscard]] SampleBrick make_brick(const Frames& frames, size_t slot, const Int3& size, bool beyond,
                                       Room& room, CodingError& coding) const;
  // Returns which sites of a brick are holes, near the source's samples, or within reach of ringing.
  [[nodiscard]] SiteEvidence evidence_of(const Frames& frames, size_t slot, BrickMask& near) const;

  Quantiser quantiser_;
  SampleCoder coder_;
  Relevance relevance_;
  float ringing_;
  CodingError coding_;
  Pool<SiteCounts> counts_;
};

} // namespace bccsplat
