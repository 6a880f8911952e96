// SPDX-License-Identifier: Apache-2.0
// What answers where the library was built without cuts: moments are the only slices.
#include "base/error.h"
#include "slice/axis_slice.h"
#include "slice/corrected_slice.h"
#include "slice/extraction.h"
#include "slice/plane_slice.h"

namespace bccsplat {
namespace {

[[noreturn]] void fail_without_cuts() {
  fail(Code::missing_feature,
       "slice: cuts other than moments of time were left out of this library; build it with "
       "BCCSPLAT_WITH_CUTS");
}

} // namespace

bool can_turn(const Coefficients& /*coefficients*/, size_t /*axis*/) { return false; }
Slice axis_slice(const Coefficients& /*coefficients*/, size_t /*axis*/, double /*position*/,
                 const Thickness& /*thickness*/, const Context& /*context*/) {
  fail_without_cuts();
}
void list_axis_reads(const Coefficients& /*coefficients*/, size_t /*axis*/, double /*position*/,
                     const Thickness& /*thickness*/, LayerReads& /*out*/) {
  fail_without_cuts();
}

Slice plane_slice(const Coefficients& /*coefficients*/, const Hyperplane& /*hyperplane*/,
                  const HypersliceOptions& /*options*/, const Affine3& /*index_to_world*/,
                  const Context& /*context*/) {
  fail_without_cuts();
}
Slice bare_plane(const Coefficients& /*coefficients*/, const Hyperplane& /*hyperplane*/,
                 const HypersliceOptions& /*options*/, const Affine3& /*index_to_world*/) {
  fail_without_cuts();
}
void list_plane_reads(const Coefficients& /*coefficients*/, const Hyperplane& /*hyperplane*/,
                      const HypersliceOptions& /*options*/, LayerReads& /*out*/) {
  fail_without_cuts();
}
void correct_slice(Slice& /*slice*/, const Coefficients& /*coefficients*/, const Thickness& /*thickness*/,
                   const Context& /*context*/) {
  fail_without_cuts();
}

void Extraction::list_reads(const SampleSource& /*source*/, const Hyperplane& /*hyperplane*/,
                            LayerReads& /*out*/) {
  fail_without_cuts();
}
Extraction::Extraction(const SampleSource& /*source*/, int /*channel*/, const Hyperplane& /*hyperplane*/,
                       const PlaneAxes& /*axes*/, const Affine3& /*lattice_to_slice*/,
                       const Context& /*context*/) {
  fail_without_cuts();
}
std::array<double, 2> Extraction::bounds() const { fail_without_cuts(); }
uint64_t Extraction::sample(std::span<const Vec3> /*uvw*/, std::span<float> /*values*/,
                            std::span<std::array<float, 3>> /*gradients*/, const Context& /*context*/) const {
  fail_without_cuts();
}
void Extraction::sample(const Grid& /*grid*/, float* /*values*/, const Context& /*context*/) const {
  fail_without_cuts();
}
uint64_t Extraction::list(uint64_t /*capacity*/, float* /*uvw*/, float* /*weighted*/,
                          Progress& /*progress*/) const {
  fail_without_cuts();
}
void Extraction::at(std::span<const Vec3> /*points*/, std::span<float> /*values*/,
                    std::span<Vec3> /*gradients*/) const {
  fail_without_cuts();
}
bool Extraction::splat(const ScatterSheet& /*sheet*/) const { fail_without_cuts(); }
void Extraction::each_point(const std::function<void(const Vec3&, float, float)>& /*body*/) const {
  fail_without_cuts();
}

} // namespace bccsplat
