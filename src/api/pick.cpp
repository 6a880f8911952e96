// SPDX-License-Identifier: Apache-2.0
// What a ray meets, for hosts.
#include <algorithm>
#include <cmath>

#include "api/handles.h"
#include "api/numbers.h"
#include "api/render_options.h"
#include "api/structs.h"
#include "scene/default_look.h"
#include "scene/pick.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

PickRay read_ray(const bccsplat_ray& in) {
  require_choice(in.pick, BCCSPLAT_PICK_OPACITY, "bccsplat_ray.pick");
  if (in.pick == 0)
    fail(Code::invalid_argument, "bccsplat_ray.pick says what to look for: BCCSPLAT_PICK_VALUE, _MAXIMUM or "
                                 "_OPACITY");
  require_numbers(in.origin, "bccsplat_ray.origin"), require_numbers(in.direction, "bccsplat_ray.direction");
  require_range(std::hypot(in.direction[0], in.direction[1], in.direction[2]), smallest_length,
                2 * largest_number, "bccsplat_ray.direction: its length");
  require_number(in.begin, "bccsplat_ray.begin"), require_number(in.end, "bccsplat_ray.end");
  if (in.begin > in.end) fail(Code::invalid_argument, "bccsplat_ray.end is before its begin");
  if (in.pick == BCCSPLAT_PICK_OPACITY && !(in.threshold > 0 && in.threshold < 1))
    fail(Code::invalid_argument, "bccsplat_ray.threshold is ", in.threshold,
         "; an opacity to be reached is above 0 and below 1");
  if (in.pick == BCCSPLAT_PICK_VALUE) require_number(in.threshold, "bccsplat_ray.threshold");
  PickRay ray;
  ray.kind = static_cast<PickKind>(in.pick);
  ray.origin = vec3(in.origin), ray.direction = normalized(vec3(in.direction));
  ray.begin = in.begin, ray.threshold = in.threshold;
  if (in.begin != 0 || in.end != 0) ray.end = in.end;
  return ray;
}

void fill(bccsplat_hit& out, const PickHit& hit) {
  out.found = 1;
  out.distance = hit.distance, out.value = hit.value;
  std::copy(hit.world.begin(), hit.world.end(), out.world);
  std::copy(hit.place.begin(), hit.place.end(), out.uvw);
  std::copy(hit.gradient.begin(), hit.gradient.end(), out.gradient);
}

} // namespace

extern "C" {

bccsplat_status bccsplat_slice_pick(const bccsplat_slice* slice, const bccsplat_ray* ray, bccsplat_hit* hit) {
  return guard([&] {
    require(slice, "slice"), require(ray, "ray"), require(hit, "hit");
    check_output(hit, "hit");
    const bccsplat_ray in = read_struct(ray, "bccsplat_ray");
    PickRay asked = read_ray(in);
    const OpenVolume& volume = slice->volume->file;
    if (volume.axes()->any() && !slice->open.cut.even)
      fail(Code::unsupported, "pick: the volume's axes are unevenly spaced: cut the slice with ",
           "bccsplat_slice_options.space BCCSPLAT_SPACE_EVEN");
    Progress progress;
    watch(progress, slice->token);
    progress.throw_if_cancelled();
    TransferFunction function;
    if (asked.kind == PickKind::opacity)
      function = in.transfer_function
                     ? read_function(in.transfer_function)
                     : default_function(volume, slice->open.channel, slice->open.slice, RenderOptions{});
    asked.function = &function;
    bccsplat_hit out{};
    if (const auto found = pick(slice->open, asked, slice->volume->device->context(progress)))
      fill(out, *found);
    write_struct(hit, out, "hit");
  });
}

} // extern "C"
