// SPDX-License-Identifier: Apache-2.0
// Parses rays, and asks the library for the values along them or for what it picks, of no more of the volume
// than lies around them.
#include "tool/probe/rays.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "tool/cli.h"
#include "tool/view/render_function.h"
#include "tool/view/slice_choice.h"

namespace bcc4 {
namespace {

constexpr uint32_t most_samples = 1 << 20;

// "X0,Y0,Z0:X1,Y1,Z1" as six numbers.
std::array<double, 6> parse_ray(const std::string& text) {
  const auto ends = split(text, ":");
  if (ends.size() != 2)
    fail_usage("--ray ", text, ": X0,Y0,Z0:X1,Y1,Z1 is expected, from one place to another");
  std::array<double, 6> ray{};
  for (size_t e = 0; e < 2; ++e) {
    const std::vector<double> place = option_numbers("--ray", std::string(ends[e]), 3);
    std::copy(place.begin(), place.end(), ray.begin() + static_cast<std::ptrdiff_t>(3 * e));
  }
  if (std::equal(ray.begin(), ray.begin() + 3, ray.begin() + 3))
    fail_usage("--ray ", text, ": ends where it begins");
  return ray;
}

std::array<double, 3> along(const std::array<double, 3>& from, const std::array<double, 3>& direction,
                            double distance) {
  return {from[0] + distance * direction[0], from[1] + distance * direction[1],
          from[2] + distance * direction[2]};
}

// The samples around all rays, whose ends are in index space, with some to spare, so that a look takes them
// for no single plane; none: they pass by the volume.
std::optional<SampleBox> samples_around(const std::vector<double>& ends, const bccsplat_volume_info& v) {
  constexpr double spare = 2;
  SampleBox box;
  for (size_t a = 0; a < 3; ++a) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (size_t n = a; n < ends.size(); n += 3) low = std::min(low, ends[n]), high = std::max(high, ends[n]);
    const auto last = static_cast<double>(v.dims[a] - 1);
    low = std::max(0.0, std::floor(low) - spare), high = std::min(last, std::ceil(high) + spare);
    if (!(low <= high)) return std::nullopt;
    box.begin[a] = static_cast<uint64_t>(low);
    box.dims[a] = static_cast<uint64_t>(high - low) + 1;
  }
  return box;
}

} // namespace

void add_rays(const Command& command, RayArguments& a) {
  command.add_texts("--ray", "X0,Y0,Z0:X1,Y1,Z1",
                    "A line from one place to another: the values along it, or what the next three options "
                    "look for; may be given several times",
                    [&a](const std::string& t) { a.rays.push_back(parse_ray(t)); });
  add_number(command, "--first", a.first,
             "Along each --ray the first place where the field passes this value");
  command.add_flag("--maximum", a.maximum, "Along each --ray the place of the largest value");
  add_number(command, "--opacity", a.opacity,
             "Along each --ray where the opacity from its beginning on reaches this, above 0 and below 1");
  command
      .add_option("--tf", a.tf,
                  "ParaView colour map (JSON) of --opacity, as render --dump-tf writes them (default: the "
                  "file's look)")
      .type_name("FILE.json");
  command.add_text("--samples", "N", "Values along each --ray, its ends included (default: one a sample)",
                   [&a](const std::string& t) {
                     a.samples = option_number<uint32_t>("--samples", t);
                     if (*a.samples < 2 || *a.samples > most_samples)
                       fail_usage("--samples ", t, ": 2 to ", most_samples);
                   });
}

void check_rays(const RayArguments& a) {
  const int looked_for = (a.first ? 1 : 0) + (a.opacity ? 1 : 0) + (a.maximum ? 1 : 0);
  if (a.rays.empty() && (looked_for > 0 || a.samples || !a.tf.empty()))
    fail_usage("--first, --maximum, --opacity, --tf and --samples go with --ray X0,Y0,Z0:X1,Y1,Z1");
  if (looked_for > 1) fail_usage("--first, --maximum and --opacity exclude each other");
  if (looked_for > 0 && a.samples)
    fail_usage("--samples is for the values along a ray, without ", a.first     ? "--first"
                                                                    : a.maximum ? "--maximum"
                                                                                : "--opacity");
  if (!a.tf.empty() && !a.opacity) fail_usage("--tf goes with --opacity");
  if (a.first && !std::isfinite(*a.first)) fail_usage("--first ", *a.first, ": must be finite");
  if (a.opacity && !(*a.opacity > 0 && *a.opacity < 1))
    fail_usage("--opacity ", *a.opacity, ": above 0 and below 1");
}

Rays::Rays(const Volume& volume, uint32_t channel, const RayArguments& arguments, bool index)
    : volume_(volume), channel_(channel), a_(arguments) {
  std::vector<double> ends;
  for (const std::array<double, 6>& given : a_.rays) {
    std::array<double, 6> world = given, samples = given;
    if (index)
      check(bccsplat_volume_index_to_world(volume.get(), 2, given.data(), world.data()), "--ray");
    else
      check(bccsplat_volume_world_to_index(volume.get(), 2, given.data(), samples.data()), "--ray");
    Ray& ray = rays_.emplace_back();
    for (size_t a = 0; a < 3; ++a) ray.from[a] = world[a], ray.direction[a] = world[a + 3] - world[a];
    ray.length = std::hypot(ray.direction[0], ray.direction[1], ray.direction[2]);
    for (double& d : ray.direction) d /= ray.length;
    const double steps = std::ceil(
        std::hypot(samples[3] - samples[0], samples[4] - samples[1], samples[5] - samples[2]) - 1e-9);
    samples_.push_back(
        a_.samples.value_or(static_cast<uint32_t>(std::clamp(steps + 1, 2.0, double{most_samples}))));
    ends.insert(ends.end(), samples.begin(), samples.end());
  }
  if (!a_.tf.empty()) {
    FunctionChoice choice;
    choice.tf = a_.tf;
    const bccsplat_look look = make_look(volume, channel, BCCSPLAT_LOOK_DEFAULT, BCCSPLAT_MODE_COMPOSITE);
    function_ = transfer_function(choice, channel_info(volume, channel), look);
  }
  const bccsplat_volume_info v = volume_info(volume);
  if (v.periodic_axes != 0) return; // the volume ends behind its last sample
  box_ = samples_around(ends, v);
  outside_ = !box_;
}

std::vector<RayPlace> Rays::at(double frame) const { return a_.picks() ? found(frame) : values(frame); }

std::vector<RayPlace> Rays::values(double frame) const {
  double time = 0;
  check(bccsplat_volume_index_to_time(volume_.get(), frame, &time), "");
  std::vector<RayPlace> places;
  std::vector<double> points;
  for (size_t r = 0; r < rays_.size(); ++r)
    for (uint32_t n = 0; n < samples_[r]; ++n) {
      RayPlace& place = places.emplace_back();
      place.ray = r, place.distance = rays_[r].length * n / (samples_[r] - 1);
      place.world = along(rays_[r].from, rays_[r].direction, place.distance);
      points.insert(points.end(), {place.world[0], place.world[1], place.world[2], time});
    }
  std::vector<float> of_points(places.size());
  uint64_t missing = 0; // which are no error where somebody counts them
  check(bccsplat_volume_evaluate_world(volume_.get(), channel_, places.size(), points.data(),
                                       of_points.data(), nullptr, &missing),
        "--ray");
  for (size_t n = 0; n < places.size(); ++n) places[n].value = of_points[n];
  return places;
}

std::vector<RayPlace> Rays::found(double frame) const {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<RayPlace> places(rays_.size(), {0, nan, {nan, nan, nan}, nan, {nan, nan, nan}});
  for (size_t r = 0; r < places.size(); ++r) places[r].ray = r;
  if (outside_) return places;
  Cut cut = cut_at_index(volume_, frame);
  cut.region = box_, cut.even = has_coordinates(volume_);
  const Slice slice = cut_slice(volume_, cut, channel_);
  bccsplat_transfer_function function;
  if (function_) function = as_struct(*function_);
  for (size_t r = 0; r < rays_.size(); ++r) {
    auto ray = sized<bccsplat_ray>();
    ray.pick = a_.maximum ? BCCSPLAT_PICK_MAXIMUM : a_.first ? BCCSPLAT_PICK_VALUE : BCCSPLAT_PICK_OPACITY;
    ray.threshold = a_.first.value_or(a_.opacity.value_or(0));
    std::copy(rays_[r].from.begin(), rays_[r].from.end(), ray.origin);
    std::copy(rays_[r].direction.begin(), rays_[r].direction.end(), ray.direction);
    ray.end = rays_[r].length;
    if (function_) ray.transfer_function = &function;
    auto hit = sized<bccsplat_hit>();
    check(bccsplat_slice_pick(slice.get(), &ray, &hit), "--ray");
    if (hit.found == 0) continue;
    places[r].distance = hit.distance, places[r].value = hit.value;
    std::copy(std::begin(hit.world), std::end(hit.world), places[r].world.begin());
    std::copy(std::begin(hit.gradient), std::end(hit.gradient), places[r].gradient.begin());
  }
  return places;
}

} // namespace bcc4
