// SPDX-License-Identifier: Apache-2.0
// What answers where the library was built without motion.
#include "base/error.h"
#include "motion/moving_series.h"

namespace bccsplat::motion {
namespace {

[[noreturn]] void fail_without_motion() {
  fail(Code::missing_feature,
       "slice: moments that follow the motion were left out of this library; build it with "
       "BCCSPLAT_WITH_MOTION");
}

} // namespace

MovingSeries::MovingSeries(const Coefficients& coefficients, const TimeAxis& /*times*/)
    : coefficients_(coefficients) {
  fail_without_motion();
}
std::vector<size_t> MovingSeries::frames_of(double /*frame*/) const { fail_without_motion(); }
void MovingSeries::prepare(double /*frame*/, const Context& /*context*/) const { fail_without_motion(); }
void MovingSeries::follow(Slice& /*moment*/, const Context& /*context*/) const { fail_without_motion(); }

} // namespace bccsplat::motion
