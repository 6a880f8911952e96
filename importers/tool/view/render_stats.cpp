// SPDX-License-Identifier: Apache-2.0
#include "tool/view/render_stats.h"

#include <algorithm>

#include "tool/json.h"

namespace bcc4 {
namespace {

double median(const std::vector<bccsplat_render_stats>& renders, double bccsplat_render_stats::*field) {
  std::vector<double> values;
  for (const bccsplat_render_stats& r : renders) values.push_back(r.*field);
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return n % 2 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

} // namespace

bccsplat_render_stats median_stats(const RenderTimes& times) {
  bccsplat_render_stats s = times.renders.back();
  for (double bccsplat_render_stats::*field :
       {&bccsplat_render_stats::ms_transform, &bccsplat_render_stats::ms_splat,
        &bccsplat_render_stats::ms_shade, &bccsplat_render_stats::ms_total, &bccsplat_render_stats::cpu_ms})
    s.*field = median(times.renders, field);
  return s;
}

Json stats_json(const RenderTimes& times, const bccsplat_volume_info& volume) {
  const bccsplat_render_stats s = median_stats(times);
  return {
      {"ms",
       {{"open", times.open_ms},
        {"slice", times.slice.milliseconds},
        {"transform", s.ms_transform},
        {"splat", s.ms_splat},
        {"shade", s.ms_shade},
        {"total", s.ms_total}}},
      {"cpu_ms", s.cpu_ms},
      {"threads", s.threads},
      {"points",
       {{"total", s.points_total},
        {"after_cull", s.points_after_cull},
        {"splatted", s.points_splatted},
        {"occluded", s.points_occluded},
        {"invisible", s.points_invisible}}},
      {"bricks",
       {{"total", s.bricks_total}, {"invisible", s.bricks_invisible}, {"outside", s.bricks_outside}}},
      {"brick_visits", {{"total", s.brick_visits}, {"hidden", s.visits_hidden}, {"unread", s.visits_unread}}},
      {"bytes_read", volume.bytes_read},
      {"bytes_read_by", {{"slice", times.slice.bytes_read}, {"render", s.bytes_read}}},
      {"bytes_file", volume.bytes_file},
      {"tiles", s.tiles},
      {"sheets", s.sheets},
      {"sheets_skipped", s.sheets_skipped},
      {"sheets_reused", s.sheets_reused},
      {"kernel", times.kernel},
      {"level", times.slice.level},
      {"coarse_level", s.coarse_level},
      {"sheet_step", s.sheet_step},
      {"preintegrated", s.preintegrated != 0},
      {"backend", s.backend == BCCSPLAT_BACKEND_GPU ? "gpu" : "cpu"}};
}

} // namespace bcc4
