// SPDX-License-Identifier: Apache-2.0
// The lattices: BCC and CC in space, D4* and CC in space-time.
//
// A lattice is described by its mirror planes. Along each axis planes h = 0 .. last lie at equal distances;
// planes 0 and `last` are the two ends of the domain, and the field continues beyond them as its mirror
// image.
//   BCC, D4*: sites are the points whose plane numbers h all have the same parity (even in coset 0, odd in
//             coset 1); planes are 1/sqrt2 apart in lattice units, so a coset is a CC grid of pitch sqrt2.
//   CC:       every plane holds sites; planes are 1 apart in lattice units.
// Lattice units are the T of the kernels. In space a lattice is stretched by less than one part in `last` so
// that a plane falls on the first source sample and another exactly on the last one: both ends are alike.
// Distances may differ from axis to axis; in lattice units they never do. In time the distance is exact (a
// series can grow), and plane `last` lies at or beyond the last frame.
//
// So that the mirrors are out of sight, planes may lie `before` the first source sample of an axis and
// `behind` the last one, and `lead` layers before the first frame and about as many after the last one: a
// field is not its own mirror image.
//
// An axis of space may be periodic, as longitude is: planes run round, a whole number of them (even on BCC
// and D4*) in as many source samples as there are, behind plane `last` comes plane 0, and none is beyond a
// face. A series whose last frame leads to the first is periodic in time: layers run round, a whole number of
// them (even but for CC) in as many frames as there are, and none is beyond an end.
//
// Sources: Conway & Sloane, Sphere Packings, ch. 4; Neophytou & Mueller 2002, section 3.
#pragma once

#include <array>
#include <cstdint>
#include <numbers>

#include "base/vec.h"

namespace bccsplat {

// One flag for each of x, y and z.
using AxisFlags = std::array<bool, 3>;

// The spatial part: one 3D lattice.
struct Lattice3 {
  bool bcc = true;
  Int3 last{1, 1, 1};   // number of the last plane per axis, >= 1
  AxisFlags periodic{}; // axes along which behind the last plane comes plane 0

  [[nodiscard]] int cosets() const { return bcc ? 2 : 1; }
  // Returns the distance of neighbouring planes in lattice units.
  [[nodiscard]] double plane_distance() const { return bcc ? 1 / std::numbers::sqrt2 : 1.0; }
  // Returns the cell volume in lattice units: the sum of a kernel over the sites times this is its integral
  // in the mean.
  [[nodiscard]] double cell_volume() const { return bcc ? std::numbers::sqrt2 : 1.0; }

  // Returns the sites per axis of one coset (x, y, z).
  [[nodiscard]] Int3 dims(int coset) const {
    Int3 n;
    for (size_t a = 0; a < 3; ++a) n[a] = bcc ? (last[a] - coset) / 2 + 1 : last[a] + 1;
    return n;
  }
  [[nodiscard]] int64_t sites(int coset) const {
    const Int3 n = dims(coset);
    return int64_t{n[0]} * n[1] * n[2];
  }
  // Returns the plane number of site i of a coset, along any axis.
  [[nodiscard]] int32_t plane(int coset, int32_t i) const { return bcc ? 2 * i + coset : i; }
  // Returns the number of planes that stand side by side along an axis.
  [[nodiscard]] int32_t planes(size_t axis) const { return last[axis] + 1; }
  // Returns where the domain of a lattice without planes outside ends along an axis, in planes: at the last
  // one, or when periodic at plane 0 again.
  [[nodiscard]] int32_t end_plane(size_t axis) const { return periodic[axis] ? planes(axis) : last[axis]; }
  [[nodiscard]] bool any_periodic() const { return periodic[0] || periodic[1] || periodic[2]; }
  // Returns the site of the coset, along `axis`, whose value i has by mirroring, or when periodic by going
  // round; i may be any integer.
  [[nodiscard]] int32_t mirror(size_t axis, int coset, int32_t i) const;

  bool operator==(const Lattice3&) const = default;
};

// Lattice distances along x, y, z in source samples, and along t in frames.
using LatticeScales = std::array<double, 4>;

enum class LatticeKind : uint8_t { d4star = 1, bcc = 2, cc = 3 };

struct Lattice4 {
  LatticeKind kind = LatticeKind::d4star;
  std::array<uint32_t, 4> dims{1, 1, 1, 1}; // source samples per axis (x, y, z, t); t = 1: a static volume
  Lattice3 space;
  Vec3 space_step{1, 1, 1}; // distance of planes in source index units, per axis
  Int3 before{0, 0, 0};     // planes before source sample 0, per axis; even but for CC
  Int3 behind{0, 0, 0};     // planes behind the last source sample
  int32_t last_layer = 0;   // time planes 0 .. last_layer; a static lattice has one layer per coset
  double time_step = 1;     // distance of layers in frames; 0 for a static lattice
  int32_t lead = 0;         // layers before frame 0, even: layer `lead` is at frame 0; 0 when static
  bool periodic = false;    // in time: behind the last layer comes layer 0, at frame dims[3]

  // Makes a lattice with the distances `scales`. In space they are realised by whole numbers of planes, so
  // that they come out a little smaller. A series of one step becomes BCC (kind d4star or bcc) or 3D CC.
  // `lead` layers lie beyond each end of time; `margins` counts the planes outside both faces of each axis,
  // which must be even. periodic: the distance of layers is as much smaller as a whole turn of them takes,
  // and there is no lead. turning: the same for planes along axes of space, which have no margins.
  static Lattice4 fit(LatticeKind kind, const std::array<uint32_t, 4>& dims,
                      const LatticeScales& scales = {1, 1, 1, 1}, int32_t lead = 0,
                      const Int3& margins = {0, 0, 0}, bool periodic = false, const AxisFlags& turning = {});

  [[nodiscard]] bool is_static() const { return time_step == 0; }
  [[nodiscard]] int32_t layers() const { return last_layer + 1; }
  // Returns the coset that a layer belongs to.
  [[nodiscard]] int coset(int32_t layer) const { return space.bcc ? layer & 1 : 0; }
  // Layers of one coset are this many layers apart.
  [[nodiscard]] int32_t layer_period() const { return space.bcc ? 2 : 1; }
  [[nodiscard]] double layer_frame(int32_t layer) const { return (layer - lead) * time_step; }
  // Returns the layer distance in lattice units, the unit of the temporal kernels.
  [[nodiscard]] double layer_distance() const { return space.plane_distance(); }
  // Returns the layer whose values `layer` has by mirroring, or when periodic by going round; it may be any
  // integer. A static lattice maps onto its cosets.
  [[nodiscard]] int32_t mirror_layer(int32_t layer) const;
  // Returns whether what lies behind the last sample of an axis (x, y, z, t) is the first one.
  [[nodiscard]] bool turns(size_t axis) const { return axis == 3 ? periodic : space.periodic[axis]; }
  // The domain along an axis is [0, domain_end]: up to the last sample, or when periodic up to the first one
  // again.
  [[nodiscard]] double domain_end(size_t axis) const { return turns(axis) ? dims[axis] : dims[axis] - 1.0; }
  [[nodiscard]] double last_frame() const { return domain_end(3); }
  // Returns the source frame that stands at a whole number of frames, which may be any where time is
  // periodic.
  [[nodiscard]] int64_t turned_frame(int64_t frame) const { return turned_sample(3, frame); }
  // The same of a sample along any axis.
  [[nodiscard]] int64_t turned_sample(size_t axis, int64_t sample) const {
    const int64_t n = dims[axis];
    return turns(axis) ? ((sample % n) + n) % n : sample;
  }
  // Returns the source frame nearest to a moment; the later one of two at equal distance.
  [[nodiscard]] int64_t nearest_frame(double frame) const;

  // These return the position of a plane along an axis, and of a site, in source index units.
  [[nodiscard]] double plane_position(size_t axis, double plane) const {
    return (plane - before[axis]) * space_step[axis];
  }
  [[nodiscard]] Vec3 site_position(int coset, const Int3& i) const {
    Vec3 p;
    for (size_t a = 0; a < 3; ++a) p[a] = plane_position(a, space.plane(coset, i[a]));
    return p;
  }
  // Returns where source sample 0 is, in lattice units from plane 0 of each axis.
  [[nodiscard]] Vec3 first_sample() const {
    const double d = space.plane_distance();
    return {d * before[0], d * before[1], d * before[2]};
  }
  // Returns the number of planes from the first source sample of an axis to the end of the domain.
  [[nodiscard]] int32_t inner_planes(size_t axis) const {
    return space.end_plane(axis) - before[axis] - behind[axis];
  }
  [[nodiscard]] bool has_margins() const { return before != Int3{} || behind != Int3{}; }
  // Returns whether it goes on beyond its ends other than as its mirror image, or has planes outside.
  [[nodiscard]] bool has_domain() const { return has_margins() || periodic || space.any_periodic(); }
  // Returns the lattice unit along each axis in source index units: dividing by it gives lattice units.
  [[nodiscard]] Vec3 lattice_unit() const {
    const double d = space.plane_distance();
    return {space_step[0] / d, space_step[1] / d, space_step[2] / d};
  }
  // Returns how many sites of layers begin .. end - 1 lie outside the source samples along x, y and z.
  [[nodiscard]] int64_t sites_outside(int32_t begin, int32_t end) const;
  // Returns the distances as they are; along t 0 when static.
  [[nodiscard]] LatticeScales scales() const {
    const Vec3 unit = lattice_unit();
    return {unit[0], unit[1], unit[2], time_step / layer_distance()};
  }
  // Returns the same, but 1 where they are smaller only for a whole number of planes.
  [[nodiscard]] LatticeScales nominal_scales() const;
  [[nodiscard]] int64_t sites() const;
  // Returns whether its sites are the source samples, one by one.
  [[nodiscard]] bool sites_are_samples() const;

  bool operator==(const Lattice4&) const = default;
};

// Returns one number for the three distances in space: their geometric mean, or without rounding the distance
// itself where they are the same.
[[nodiscard]] double mean_in_space(const LatticeScales& scales);

} // namespace bccsplat
