// A candidate for the ends of space: samples beyond the faces, predicted from those inside of both cosets.
//
// Nothing is stored for it. The value at a site `m` planes beyond a face is a weighted sum of the sites near
// it in the planes inside: the best one, in the mean square, for waves whose frequencies fill balls with some
// noise, among those that leave a constant as it is. Layers go into a lattice that has a margin of planes, at
// whose own ends the field is mirrored, out of the kernel's reach.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "points/sample_source.h"
#include "tests/bench/fit/fit_fields.h"

namespace bccsplat::bench {

// Sites that a prediction looks at, those with the same weight together.
struct FaceStencil {
  struct Group {
    int plane;                              // 0: the face
    std::vector<std::array<int, 3>> offset; // along the face and in time, in planes and layers
    double weight;
  };
  std::vector<Group> groups;

  [[nodiscard]] size_t taps() const;
  [[nodiscard]] double noise_gain() const; // sum of the squares of the weights
};

// Which sites: planes 0 .. `depth`, offsets up to the roots of `own` and `other` (squares), for planes of the
// coset of the site that is predicted and for those of the other one. noise: over the power of the field.
struct FaceRule {
  int depth = 8;
  double own = 16, other = 19;
  double noise = 1e-3;
};

// dimensions 3: BCC, offsets have no part in time. distance: of the site beyond the face, in planes, >= 1.
[[nodiscard]] FaceStencil predicted_stencil(int dimensions, int distance, const FaceRule& rule);
// 2 f(face) - f of the site as far inside. The face is a plane of one coset; its value at sites of the other
// one is the best sum of those around.
[[nodiscard]] FaceStencil odd_stencil(int dimensions, int distance, const FaceRule& rule);
using StencilOf = FaceStencil (*)(int dimensions, int distance, const FaceRule& rule);

// What filters take beyond the ends of a row in place of mirror images: samples predicted from those of the
// row (fit/ends.h), or 2 f(end) - f.
enum class RowEnds : uint8_t { predicted, odd };
// The samples of a series through such filters: what an importer would store.
[[nodiscard]] MemorySamples resample_without_mirrors(const FitSeries& series, RowEnds ends);

// A volume of which every face has a margin, and where its source sample (0, 0, 0) now lies.
struct WithMargin {
  MemorySamples samples;
  std::array<double, 3> origin; // in index units of `samples`
};
[[nodiscard]] WithMargin predict_faces(const MemorySamples& samples, StencilOf stencil_of,
                                       const FaceRule& rule);

} // namespace bccsplat::bench
