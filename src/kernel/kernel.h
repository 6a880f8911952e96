// SPDX-License-Identifier: Apache-2.0
// Reconstruction kernels K(x, t) = phi(|x|) beta(t) on BCC and D4*, and the prefilters that make them
// interpolate. Lengths are in lattice units (T): coset pitch sqrt2, nearest sites of the two cosets sqrt(3/2)
// apart in space. The table of kernels, and what a new one needs, are in kernel.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace bccsplat {

// phi(r) = sum_j a[j] u^j with u = max(0, 1 - r^2 / radius^2): compact and rotation invariant, without a
// table or exp. Gaussians are the same form with enough terms: exp(-g r^2) = exp(-g R^2) exp(g R^2 u). The
// sum of phi over the sites of BCC is 1 in the mean.
struct RadialKernel {
  static constexpr int max_terms = 20;
  double radius = 0;
  int terms = 0; // a[0] .. a[terms-1]
  std::array<double, max_terms> a{};

  [[nodiscard]] double value(double r2) const; // r2 = r^2
  [[nodiscard]] double slope(double r2) const; // d phi / d(r^2): the gradient at x is 2 x slope(|x|^2)
};

// beta(dt) over the layers of one coset (pitch sqrt2): a centred B-spline, bent a little, or
// scale * exp(-g dt^2) cut at half_width. Splines sum to 1 over the layers of each coset at any phase; the
// bends keep that, the support, the sign and the continuous slope. With h the distance of a layer from the
// end of the support and x = 1 - 2 |dt|, both in pitches,
//   order 3: the outer layers gain h^2 (1 - h) (bend[0] (2 h - 1) + bend[1]), which the middle one gives;
//   order 4: the outer layers gain bend[0] h^2 (1 - h)^2, and each of the middle ones gives as much;
//   even order 2 m: the nearer of the two middle layers gains bend[1] x (1 - x^2)^m, which the other gives.
// They bring the error of slow waves, which pulses with the phase of dt, to about the same at any phase.
struct TemporalKernel {
  enum class Shape : uint8_t { bspline, gaussian };
  Shape shape = Shape::bspline;
  int order = 3; // B-spline: 2 hat, 3 quadratic, 4 cubic
  std::array<double, 2> bend{};
  double gaussian = 0;   // g, per T^2
  double scale = 1;      // of a Gaussian, so that its sum over the layers of a coset is 1 in the mean
  double half_width = 0; // beta is 0 from here on; order * sqrt2 / 2 for a B-spline

  [[nodiscard]] double value(double dt) const;
  [[nodiscard]] double slope(double dt) const;                   // d beta / d dt
  [[nodiscard]] double integral(double begin, double end) const; // of beta over [begin, end]
};

// One prefilter stage, c_(j+1) = A c_j + B f, where f are the samples and c_0 = f:
//   A = self + spatial S + temporal T + mixed ST + cross X,
//   B = source + source_spatial S + source_temporal T + source_mixed ST.
// S sums the 6 own-coset spatial neighbours (sqrt2 away), T the 2 own-coset temporal ones (layers m +- 2), ST
// is S of those two layers, X sums the nearest neighbours in the other coset (16 on D4*: 8 spatial corners in
// each of the layers m +- 1; the 8 corners on BCC). Neighbours beyond the domain are mirror images. T and ST
// are 0 on BCC. B makes polynomials with complex roots possible; products of A alone lose 20 dB and more. A
// stage costs one S and one X pass: it is h0 + S h1 + X h2 with h0, h1, h2 linear in c and f at one place.
struct PrefilterStage {
  double self = 1, spatial = 0, temporal = 0, mixed = 0, cross = 0;
  double source = 0, source_spatial = 0, source_temporal = 0, source_mixed = 0;
  // On Cartesian lattices T sums layers this far apart; B then has no part in time.
  int stride = 1;
  // On Cartesian lattices, where the pole p is not 0, A is `self` times the inverse of (1 - p w) (1 - p / w)
  // along each of x, y and z, w a step of one site: p^|n| / (1 - p^2) from the n-th neighbour, up to
  // `pole_reach` ones.
  double pole = 0;
  static constexpr int pole_reach = 15;

  [[nodiscard]] bool uses_source() const {
    return source != 0 || source_spatial != 0 || source_temporal != 0 || source_mixed != 0;
  }
};

// The distance up to which coefficients look: planes (1/sqrt2) in space, layers in time.
struct Reach {
  int space = 0, time = 0;
};
[[nodiscard]] Reach prefilter_reach(std::span<const PrefilterStage> stages);

// The largest sum of any kernel over the sites of its lattice: the ripple of radial16 on BCC, and more than
// that of any on CC.
[[nodiscard]] constexpr double largest_site_sum(bool bcc) { return bcc ? 1.02 : 1.1; }

struct Kernel {
  std::string name; // canonical, "radial20+b3"
  RadialKernel space;
  TemporalKernel time;
  std::vector<PrefilterStage> prefilter4; // samples on D4* -> coefficients, applied in order
  std::vector<PrefilterStage> prefilter3; // samples on BCC -> coefficients
  // Whether reconstruction divides by the lattice sum of the weights (the paper's kernel).
  bool normalised = false;
  // Bound of max |coefficient| / max |sample|: the sum of |taps| of the worse prefilter.
  double prefilter_gain = 1;

  // Returns how many layers on either side of an instant matter: kernel support plus prefilter reach.
  [[nodiscard]] int reach_layers() const;
};

// The names are fast (radial16+b2), default (radial20+b3), fine (radial24+b4), exact (for Cartesian lattices,
// cc_kernel.h; on others the same as default), paper, gauss09, or SPACE+TIME with SPACE one of radial16
// radial18 radial20 radial24 and TIME one of b2 b3 b4. An empty name is default. Throws not_found naming the
// nearest.
[[nodiscard]] Kernel make_kernel(std::string_view name);
[[nodiscard]] std::vector<std::string> kernel_names();

// Returns the sum of phi over all sites of BCC at a point (lattice units), relative to its mean 1: in closed
// form for the paper's Gaussian, 1 for kernels that are not normalised.
[[nodiscard]] double lattice_sum(const Kernel& kernel, double x, double y, double z);

} // namespace bccsplat
