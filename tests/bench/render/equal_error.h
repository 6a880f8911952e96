// SPDX-License-Identifier: Apache-2.0
// Ways of drawing that a step makes cheaper or nearer, compared at equal error and at equal time.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/bench/render/render.h"

namespace bccsplat::bench {

// One way of drawing, from its longest step to its shortest.
struct Way {
  std::string name;
  std::vector<Method> methods;
  bool at_any_step = true;      // else only those of `methods` can be had
  bool rays = false;            // else the splatter
  double before_ms = 0;         // what a picture needs before it that no other shares
  double held_mib = 0;          // memory between pictures, without the picture
  std::vector<double> ms, psnr; // of each method
};

// The splatter's options for a step, with what the quality settings take near it.
[[nodiscard]] RenderOptions options_at(double step);

// Fills ms and psnr: CPU time, least of `rounds` in which the methods of all ways take turns, and the error
// against the truth's pixels.
void measure_ways(std::vector<Way>& ways, int size, int rounds, const Image& truth, int stride);

// The least time in which a way reaches an error, and the least error that it reaches in a time; between two
// steps a straight line from one to the other, over the logarithm of the time.
[[nodiscard]] std::optional<double> time_to_reach(const Way& way, double psnr);
[[nodiscard]] std::optional<double> psnr_within(const Way& way, double ms);

// Every method of every way, and the plot DIR/SUITE-equal-NAME.png.
void report_ways(const Report& report, const std::string& scene, const std::string& how,
                 const std::string& name, const std::vector<Way>& ways);
// A row for each way: times to reach 32, 36, 40 dB and more, errors in the times of two others.
[[nodiscard]] std::vector<Row> equal_rows(const std::string& scene, const std::vector<Way>& ways,
                                          double draft_ms, double normal_ms);

// A row of times of rays over those of the splatter's fastest way, to the same errors.
[[nodiscard]] Row ratio_row(const std::string& scene, const std::vector<Way>& ways);

} // namespace bccsplat::bench
