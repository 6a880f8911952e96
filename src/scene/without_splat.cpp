// SPDX-License-Identifier: Apache-2.0
// What answers where the library was built without its splatter: the CPU draws nothing.
#include "base/error.h"
#include "scene/picture.h"
#include "scene/trail.h"

namespace bccsplat {
namespace {

[[noreturn]] void fail_without(const char* what) {
  fail(Code::missing_feature, "render: ", what,
       " come from the CPU's drawers, and the library was built without them; build it with "
       "BCCSPLAT_WITH_SPLAT");
}

} // namespace

FieldAt slice_field(const Slice& /*slice*/, std::shared_ptr<const LatticeSums> /*sums*/) {
  fail_without("reference pictures");
}
double reference_step(const TransferFunction& /*function*/, const std::array<double, 2>& /*bounds*/) {
  fail_without("reference pictures");
}
void draw_reference(const Shot& /*shot*/, const FieldAt& /*field*/, const ReferenceOptions& /*options*/,
                    const Context& /*context*/, Image& /*image*/) {
  fail_without("reference pictures");
}

Trail make_trail(const OpenVolume& /*volume*/, const OpenSlice& /*slice*/, const TrailOptions& /*options*/,
                 const Context& /*context*/) {
  fail_without("trails");
}
std::vector<TransferFunction> TrailLook::functions_with(const TransferFunction& /*of_slice*/) const {
  fail_without("trails");
}
void show_trail(const Trail& /*trail*/, const TrailLook& /*look*/, Scene& /*scene*/) {
  fail_without("trails");
}
TransferFunction tinted(const TransferFunction& /*function*/, const Vec3& /*color*/) {
  fail_without("trails");
}
Vec3 ramp_color(int /*interval*/, int /*intervals*/) { fail_without("trails"); }

} // namespace bccsplat
