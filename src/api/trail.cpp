// SPDX-License-Identifier: Apache-2.0
// Reads what a host says of a trail.
#include <algorithm>

#include "api/numbers.h"
#include "api/render_options.h"
#include "api/structs.h"

namespace bccsplat::api {
namespace {

constexpr double largest_weight = 1e9;

// Returns one function for all sub-intervals, or one for each; none for the slice's.
std::vector<TransferFunction> read_trail_functions(const bccsplat_trail& in, int intervals) {
  if (in.transfer_function && in.transfer_functions)
    fail(Code::invalid_argument, "trail: transfer_function is for all sub-intervals, transfer_functions are "
                                 "one for each; set one of the two");
  std::vector<TransferFunction> functions;
  if (in.transfer_function) functions.push_back(read_function(in.transfer_function));
  for (int i = 0; in.transfer_functions && i < intervals; ++i) {
    const bccsplat_transfer_function* const f = element(in.transfer_functions, static_cast<size_t>(i));
    if (f->struct_size != in.transfer_functions->struct_size)
      fail(Code::invalid_struct_size, "bccsplat_trail.transfer_functions[", i, "]: struct_size is ",
           f->struct_size, ", that of the first ", in.transfer_functions->struct_size, "; give all the same");
    functions.push_back(read_function(f));
  }
  return functions;
}

// Returns one colour for each sub-interval; none for those of the functions.
std::vector<Vec3> read_trail_colors(const bccsplat_trail& in, int intervals) {
  std::vector<Vec3> colors;
  if (!in.colors && (intervals == 1 || in.transfer_functions || in.weights)) return colors;
  for (int i = 0; i < intervals; ++i) {
    const double* c = in.colors ? in.colors + 3 * static_cast<size_t>(i) : nullptr;
    colors.push_back(c ? Vec3{c[0], c[1], c[2]} : ramp_color(i, intervals));
    for (const double part : colors.back()) require_range(part, 0, largest_colour, "bccsplat_trail.colors");
  }
  return colors;
}

// Returns one weight for each sub-interval; none: all alike.
std::vector<double> read_weights(const bccsplat_trail& in, int intervals) {
  std::vector<double> weights;
  if (!in.weights) return weights;
  for (int i = 0; i < intervals; ++i) {
    weights.push_back(in.weights[i]);
    require_range(weights.back(), 0, largest_weight, "bccsplat_trail.weights");
  }
  if (*std::max_element(weights.begin(), weights.end()) == 0)
    fail(Code::invalid_argument,
         "bccsplat_trail.weights are all 0: nothing of the trail would be seen; leave the trail out");
  return weights;
}

} // namespace

AskedTrail read_trail(const bccsplat_trail* trail) {
  const auto in = read_struct(trail, "bccsplat_trail");
  require_zero(in.reserved, "bccsplat_trail.reserved");
  require_zero(in.reserved2, "bccsplat_trail.reserved2");
  require_choice(in.content, BCCSPLAT_TRAIL_MAXIMUM, "bccsplat_trail.content");
  require_choice(in.combine, BCCSPLAT_TRAIL_INTERLEAVED, "bccsplat_trail.combine");
  if (in.samples > most_stills || in.intervals > most_intervals)
    fail(Code::invalid_argument, "trail: at most ", most_stills, " samples in each of ", most_intervals,
         " sub-intervals");
  require_numbers(in.interval, "bccsplat_trail.interval");
  if (!(in.interval[0] <= in.interval[1]))
    fail(Code::invalid_argument, "bccsplat_trail.interval ends before it begins");
  AskedTrail out;
  if (in.content) out.options.content = static_cast<TrailContent>(in.content);
  out.options.interval = {in.interval[0], in.interval[1]};
  out.options.samples = static_cast<int>(in.samples);
  out.options.intervals = std::max(static_cast<int>(in.intervals), 1);
  out.options.weights = read_weights(in, out.options.intervals);
  if (in.combine) out.look.combine = static_cast<TrailCombine>(in.combine);
  out.look.functions = read_trail_functions(in, out.options.intervals);
  out.look.colors = read_trail_colors(in, out.options.intervals);
  out.look.unlit = in.unlit != 0;
  return out;
}

} // namespace bccsplat::api
