// SPDX-License-Identifier: Apache-2.0
// What a motion trail is made of: the moments of an interval and their shares.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "base/context.h"
#include "draw/shot.h"
#include "field/coefficients/coefficients.h"
#include "field/slice.h"
#include "shade/transfer_function.h"
#include "slice/hyperslice.h"
#include "splat/points/points.h"
#include "volume/open_slice.h"

namespace bccsplat {

enum class TrailContent : uint8_t { classified = 1, mean = 2, maximum = 3 };

struct TrailOptions {
  TrailContent content = TrailContent::classified;
  // Relative to the slice, in frames, for other hyperplanes than those of time in index units along the unit
  // normal; it is clipped to the domain.
  std::array<double, 2> interval{0, 0};
  int samples = 0;   // stills per sub-interval; 0: one per lattice layer or index unit, 4 to 64
  int intervals = 1; // sub-intervals, each of a colour of its own when more than one
  // The share of each sub-interval in the extinction, in any unit; empty: all alike.
  std::vector<double> weights{};

  bool operator==(const TrailOptions&) const = default;
};

// How the moments of a trail look, and how they are joined with the slice.
struct TrailLook {
  TrailCombine combine = TrailCombine::physical;
  std::vector<TransferFunction> functions; // one for all sub-intervals, or one for each; none: the slice's
  std::vector<Vec3> colors;                // instead of the functions' own, one for each; none: these
  bool unlit = false;

  // Returns the functions of a trail whose slice has this one: one for all sub-intervals, or one for each.
  [[nodiscard]] std::vector<TransferFunction> functions_with(const TransferFunction& of_slice) const;
};

// A trail as a host asks for it.
struct AskedTrail {
  TrailOptions options;
  TrailLook look;

  [[nodiscard]] bool any() const { return options.interval[0] != 0 || options.interval[1] != 0; }
};

struct TrailSource {
  Slice slice;
  SplatPoints points;
  Reservation memory; // of the slice; the points have their own
};

// A moment of the trail: its field is a weighted sum of sources.
struct TrailMoment {
  std::vector<SheetShare> shares;
  double frame = 0;
  double weight = 1; // of its extinction; a trail's sum to 1
  int interval = 0;  // sub-interval it belongs to
};

class TrailByCpu;
struct Scene; // scene/picture.h

struct Trail {
  std::vector<TrailSource> sources;
  std::vector<TrailMoment> moments;   // none: an interval that clips to nothing
  std::array<double, 2> bounds{0, 0}; // no value of any moment lies outside
  // Where its sources are moments of a series that a GPU merges (field/moment.h), without points: what the
  // CPU draws instead. Null: this.
  std::shared_ptr<const TrailByCpu> by_cpu;
  std::shared_ptr<const Coefficients> coefficients; // that it is made of; null: they outlive the trail
};

// A trail that is made when somebody asks for it. Any thread may ask.
class TrailByCpu {
 public:
  using Make = std::function<Trail(const Context&)>;
  explicit TrailByCpu(Make make) : make_(std::move(make)) {}
  [[nodiscard]] const Trail& get(const Context& context) const {
    const std::scoped_lock lock(mutex_);
    if (!made_) made_ = std::make_unique<const Trail>(make_(context));
    return *made_;
  }

 private:
  Make make_;
  mutable std::mutex mutex_;
  mutable std::unique_ptr<const Trail> made_;
};

// Content `classified` is made of stills at the midpoints of equal parts, each with its share (midpoint rule:
// second order in the parts). Where it is cheaper the sources are the lattice's layers, of which stills are
// mixed sheet by sheet: many stills then cost little more than few. Contents `mean` and `maximum` are one
// slice per sub-interval; over time the mean is exact, along other normals it is a Gauss-Legendre quadrature
// (slice/thickness.h). `slice` was cut with `like`, out of a volume of this spatial affine. Where `like`
// merges later, moments in time are left to a GPU, unless there are corrections or masks; the coefficients
// outlive the trail.
[[nodiscard]] Trail make_trail(const Coefficients& coefficients, const Slice& slice,
                               const TrailOptions& options, const HypersliceOptions& like,
                               const Affine3& index_to_world, const Context& context);

// The same of a slice of an open volume.
[[nodiscard]] Trail make_trail(const OpenVolume& volume, const OpenSlice& slice, const TrailOptions& options,
                               const Context& context);

// Has a picture drawn with a trail that was made for its slice, whose function the scene has.
void show_trail(const Trail& trail, const TrailLook& look, Scene& scene);

// Returns the function with every colour replaced.
[[nodiscard]] TransferFunction tinted(const TransferFunction& function, const Vec3& color);
// Returns the colour of a sub-interval, from blue at the interval's beginning over white to orange at its
// end.
[[nodiscard]] Vec3 ramp_color(int interval, int intervals);

} // namespace bccsplat
