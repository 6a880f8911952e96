// SPDX-License-Identifier: Apache-2.0
// Decides which sites are worth storing, in the precision in which they are stored.
//
// A site is kept when its stored value differs from air by more than the threshold; with threshold 0 when its
// stored code is not that of air. An absent site is then wrong by no more than the threshold and half a step
// of the stored type (values beyond the range of the type are clamped first).
//
// Ringing is no substance: an interpolating filter leaves small values up to its reach away from an edge, all
// of which differ from air in a fine type. A site whose nearest source sample (in space and time) is air is
// air too, unless its value exceeds `ringing` times the largest departure from air in the filter's reach; and
// it is air whatever its value where all source samples around it are air in every frame of that reach. On
// floats from a smoke simulation this keeps 58 % instead of 148 % of the relevant Cartesian samples and
// changes the reconstruction error at the source samples by less than 0.1 % of itself
// (tests/bench/notes/fit.md).
#pragma once

#include <cstdint>

#include "fit/kept/quantise.h"
#include "points/brick.h"

namespace bccsplat {

struct KeptCounts {
  uint64_t kept = 0, holes = 0, clamped = 0;
};

// Facts about the sites of a brick besides their values.
struct SiteEvidence {
  const BrickMask* holes = nullptr;  // missing data; null: none
  const BrickMask* source = nullptr; // sites whose nearest source sample is not air; null: all
  float ringing = 0;                 // the others count only beyond this
  const BrickMask* near = nullptr;   // and none of them where this says no; null: all may
};

class Relevance {
 public:
  Relevance(const Quantiser& quantiser, float threshold);

  // Rounds `values` (a brick's sites relative to air, of which the first `size` along each axis are inside
  // the coset) and keeps the relevant ones in `brick`, whatever it held; holes are kept with their fill.
  // clamped: sites the stored type cannot hold.
  KeptCounts select(const float* values, const Int3& size, const SiteEvidence& evidence, Brick& brick) const;

  // The way from values to codes.
  struct Rounding {
    enum class Kind : uint8_t {
      none,          // f32
      half_relative, // f16 of the value minus air
      half,          // f16 of the value
      integer,       // code = relative value + shift, exact in float
      scaled         // code = (relative value + shift) / scale, in double
    };
    Kind kind = Kind::none;
    double scale = 1, shift = 0; // shift = air - offset
    float air = 0;
    float largest = 0;   // code
    float air_code = 0;  // what air itself is stored as
    float threshold = 0; // 0: codes are compared instead
  };

 private:
  Rounding rounding_;
};

} // namespace bccsplat
