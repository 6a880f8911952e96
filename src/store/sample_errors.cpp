// SPDX-License-Identifier: Apache-2.0
#include "store/sample_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "base/error.h"

namespace bccsplat {
namespace {

// What 32-bit floats hold of a value of magnitude 1, and a few units in the last place.
constexpr double held_by_floats = 0x1p-20;

} // namespace

void ErrorSum::add(const ErrorSum& other) {
  largest = std::max(largest, other.largest);
  squares.add(other.squares);
  count += other.count;
}

double ErrorSum::rms() const { return count ? std::sqrt(squares.value() / static_cast<double>(count)) : 0; }

double ErrorSum::psnr(double peak) const {
  if (count == 0) return std::numeric_limits<double>::quiet_NaN();
  const double off = rms();
  return off == 0 ? std::numeric_limits<double>::infinity() : 20 * std::log10(peak / off);
}

bool SampleErrors::yields_to(const SampleErrors& other) const {
  if (other.all.count == 0) return false;
  if (all.count == 0 || other.all.largest > all.largest) return true;
  const auto place = [](const SampleErrors& e) {
    return std::tuple(e.frame, e.voxel[2], e.voxel[1], e.voxel[0]);
  };
  return other.all.largest == all.largest && place(other) < place(*this);
}

void SampleErrors::add(const SampleErrors& other) {
  if (yields_to(other)) frame = other.frame, voxel = other.voxel, expected = other.expected, got = other.got;
  all.add(other.all), non_air.add(other.non_air), bare.add(other.bare);
  lost += other.lost, corrected += other.corrected;
}

void require_psnr(const std::string& channel, const SampleErrors& e, const Range& range, double psnr,
                  const std::optional<Range>& told) {
  const double peak = range.high - range.low, reached = e.all.psnr(peak);
  if (peak == 0 && e.all.largest > 0)
    fail(Code::bound_not_met, "channel '", channel, "': the source is ", range.low,
         " everywhere, so that no PSNR can be told; make that its air, or bound the error itself");
  if (!(reached < psnr)) return;
  // Corrections within a bound leave two thirds of it in the mean.
  const double bound = 1.5 * peak * std::pow(10, -psnr / 20),
               magnitude = std::max(std::fabs(range.low), std::fabs(range.high)),
               held = held_by_floats * magnitude;
  const std::string advice =
      bound >= held
          ? concat("a smaller scale, lattice CC, more bits, or abs_error ", bound, " would do")
          : concat("values near ", magnitude, " are read as 32-bit floats, which hold errors down to about ",
                   held, "; ask for at most ", 20 * std::log10(1.5 * peak / held), " dB");
  const bool wider = told && told->high - told->low > peak;
  const std::string cause = wider
                                ? concat("; steps are those of the range that was told, ", told->low, " to ",
                                         told->high, ", and the source's is ", range.low, " to ", range.high)
                                : "";
  fail(Code::bound_not_met, "channel '", channel, "': ", reached, " dB reached, ", psnr,
       " asked for; the largest difference is at frame ", e.frame, ", voxel (", e.voxel[0], ", ", e.voxel[1],
       ", ", e.voxel[2], "): ", e.got, " instead of ", e.expected, cause, "; ", advice);
}

} // namespace bccsplat
