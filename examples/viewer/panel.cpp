// SPDX-License-Identifier: Apache-2.0
// The controls of the viewer: time, cut and view, the transfer function as a curve over the histogram, and
// what the last picture took.
#include "viewer/panel.h"

#include "viewer/palette.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace viewer {
namespace {

// Lets points of the curve be dragged up and down, with the histogram of the stored values behind them.
void curve_editor(Wish& wish, const Facts& facts) {
  const ImVec2 size(ImGui::GetContentRegionAvail().x, 110), from = ImGui::GetCursorScreenPos();
  const auto x_of = [&](float f) { return from.x + f * size.x; };
  const auto y_of = [&](float v) { return from.y + (1 - std::sqrt(v)) * size.y; }; // small opacities count
  ImGui::InvisibleButton("curve", size);
  if (ImGui::IsItemActive()) {
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const float at = std::clamp((mouse.x - from.x) / size.x, 0.f, 1.f) * (curve_points - 1);
    const float height = std::clamp(1 - (mouse.y - from.y) / size.y, 0.f, 1.f);
    wish.opacity[std::lround(at)] = height * height;
  }
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.AddRectFilled(from, ImVec2(from.x + size.x, from.y + size.y), IM_COL32(20, 20, 24, 255));
  for (size_t i = 0; i < facts.histogram.size(); ++i) {
    const float f = static_cast<float>(i) / 256;
    draw.AddLine(ImVec2(x_of(f), from.y + size.y),
                 ImVec2(x_of(f), from.y + size.y * (1 - 0.9f * facts.histogram[i])),
                 IM_COL32(60, 60, 70, 255), 2);
  }
  ImVec2 before;
  for (int i = 0; i < curve_points; ++i) {
    const float f = static_cast<float>(i) / (curve_points - 1);
    const ImVec2 point(x_of(f), y_of(wish.opacity[i]));
    const auto rgb = palette_color(wish.palette, f);
    if (i > 0) draw.AddLine(before, point, IM_COL32(200, 200, 200, 255), 1.5f);
    draw.AddCircleFilled(point, 5,
                         ImGui::GetColorU32(ImVec4(static_cast<float>(std::sqrt(rgb[0])),
                                                   static_cast<float>(std::sqrt(rgb[1])),
                                                   static_cast<float>(std::sqrt(rgb[2])), 1)));
    draw.AddCircle(point, 5, IM_COL32(255, 255, 255, 255));
    before = point;
  }
}

bccsplat_look made_look(const bccsplat_volume* volume) {
  bccsplat_look look{};
  look.struct_size = sizeof look;
  check(bccsplat_volume_get_look(volume, 0, BCCSPLAT_LOOK_DEFAULT, BCCSPLAT_MODE_COMPOSITE, &look));
  return look;
}

// Linear between the look's points and constant beyond them.
float opacity_at(const bccsplat_look& look, double value) {
  uint32_t i = 0;
  while (i < look.opacity_count && look.opacities[i][0] <= value) ++i;
  const double* after = look.opacities[std::min(i, look.opacity_count - 1)];
  const double* before = look.opacities[i > 0 ? i - 1 : 0];
  const double width = after[0] - before[0], f = width > 0 ? (value - before[0]) / width : 0;
  return static_cast<float>(before[1] + f * (after[1] - before[1]));
}

void scene_statistics(const Picture& p) {
  const bccsplat_scene_status& s = p.scene;
  ImGui::Text("%s, %.0f %% of the work",
              p.fine           ? "fine"
              : p.wish.playing ? "draft"
                               : "coarse",
              100 * s.progress);
  ImGui::Text("the last call: %.0f ms, %.0f to cut, %.0f to draw", s.ms_total, s.ms_cut, s.ms_draw);
  ImGui::Text("level %u, %.2f MB read", s.level, static_cast<double>(s.bytes_read) / 1e6);
}

void renderer_statistics(const Picture& p) {
  const auto percent = [](uint64_t part, uint64_t whole) {
    return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0;
  };
  const bccsplat_render_stats& s = p.stats;
  ImGui::Text("%s, %.0f ms, %u threads", p.fine ? "fine" : "draft", s.ms_total, s.threads);
  ImGui::Text("slice: %.0f ms, %.2f MB read, level %u", p.slice.milliseconds,
              static_cast<double>(p.slice.bytes_read) / 1e6, p.slice.level);
  ImGui::Text("points: %llu", static_cast<unsigned long long>(s.points_total));
  ImGui::Text("  invisible or out of view: %.1f %%", 100 - percent(s.points_after_cull, s.points_total));
  ImGui::Text("  visits hidden: %.1f %%", percent(s.points_occluded, s.points_splatted + s.points_occluded));
  ImGui::Text("%llu tiles, %llu sheets of %.3g T", static_cast<unsigned long long>(s.tiles),
              static_cast<unsigned long long>(s.sheets), s.sheet_step);
}

void statistics(const Picture& p, const Counts& counts) {
  p.wish.of_scene() ? scene_statistics(p) : renderer_statistics(p);
  ImGui::Text("%d drafts, %d fine, %d cancelled", counts.drafts.load(), counts.fine.load(),
              counts.cancelled.load());
}

} // namespace

Facts read_facts(const bccsplat_volume* volume) {
  bccsplat_volume_info info{};
  bccsplat_channel_info channel{};
  info.struct_size = sizeof info, channel.struct_size = sizeof channel;
  check(bccsplat_volume_get_info(volume, &info));
  check(bccsplat_volume_get_channel_info(volume, 0, &channel));
  Facts f;
  f.last_frame = static_cast<double>(info.dims[3] - 1);
  const bccsplat_look look = made_look(volume);
  f.range = {look.range[0], look.range[1]};
  f.iso_value = look.iso_value;
  if (!(f.range[0] < f.range[1])) f.range = {channel.kept_range[0], channel.kept_range[0] + 1};
  for (size_t i = 0; i < f.opacity.size(); ++i)
    f.opacity[i] = opacity_at(look, f.range[0] + static_cast<double>(i) / (curve_points - 1) *
                                                     (f.range[1] - f.range[0]));
  f.name = channel.name, f.unit = channel.unit, f.time_unit = info.time_unit;
  f.time_first = info.time_first, f.time_last = info.time_last;
  const double most = static_cast<double>(*std::max_element(channel.histogram, channel.histogram + 256));
  const double low = channel.kept_range[0], width = channel.kept_range[1] - low;
  for (size_t i = 0; i < 256 && most > 0 && width > 0; ++i) { // over our range, not the stored one
    const double value = f.range[0] + (static_cast<double>(i) + 0.5) / 256 * (f.range[1] - f.range[0]);
    const auto bin = static_cast<size_t>(std::clamp((value - low) / width * 256, 0.0, 255.0));
    f.histogram[i] =
        static_cast<float>(std::log1p(static_cast<double>(channel.histogram[bin])) / std::log1p(most));
  }
  return f;
}

void panel(Wish& wish, Play& play, const Facts& facts, const Picture* shown, const Counts& counts,
           const std::string& recorded) {
  ImGui::SetNextWindowPos(ImVec2(0, 0));
  ImGui::SetNextWindowSize(ImVec2(panel_width, ImGui::GetIO().DisplaySize.y));
  ImGui::Begin("panel", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove);
  ImGui::PushItemWidth(-90);
  const auto slider = [](const char* label, double& value, double low, double high) {
    auto v = static_cast<float>(value);
    if (ImGui::SliderFloat(label, &v, static_cast<float>(low), static_cast<float>(high))) value = v;
  };
  ImGui::Text("%s %.4g .. %.4g %s", facts.name.c_str(), facts.range[0], facts.range[1], facts.unit.c_str());
  slider("frame", wish.frame, 0, facts.last_frame);
  if (facts.last_frame > 0)
    ImGui::Text("time about %.4g %s",
                facts.time_first + wish.frame / facts.last_frame * (facts.time_last - facts.time_first),
                facts.time_unit.c_str());
  ImGui::Separator();
  ImGui::Text("4D plane: frames later across the box");
  slider("tilt x", wish.tilt[0], -facts.last_frame, facts.last_frame);
  slider("tilt y", wish.tilt[1], -facts.last_frame, facts.last_frame);
  slider("tilt z", wish.tilt[2], -facts.last_frame, facts.last_frame);
  if (ImGui::Button("upright")) wish.tilt = {};
  ImGui::Separator();
  ImGui::Text("opacity over the value (drag)");
  curve_editor(wish, facts);
  ImGui::Combo("colours", &wish.palette, palette_names, static_cast<int>(std::size(palette_names)));
  ImGui::Separator();
  ImGui::Checkbox("trail", &wish.trail);
  slider("frames back", wish.trail_frames, 0.5, std::max(1.0, facts.last_frame));
  ImGui::Separator();
  ImGui::Checkbox("isosurfaces (i; up and down move them)", &wish.iso);
  for (size_t i = 0; wish.iso && i < wish.surfaces.size(); ++i)
    slider(("value " + std::to_string(i + 1)).c_str(), wish.surfaces[i].value, facts.range[0],
           facts.range[1]);
  ImGui::Separator();
  ImGui::Text("cut open (keys x y z, [ and ])");
  for (size_t a = 0; a < 3; ++a) {
    const std::string axis(1, "xyz"[a]);
    ImGui::Checkbox(axis.c_str(), &wish.open[a]);
    ImGui::SameLine();
    slider(("to " + axis).c_str(), wish.open_to[a], 0, 1);
  }
  ImGui::Separator();
  ImGui::Checkbox("play (space)", &play.on);
  ImGui::SameLine();
  ImGui::Checkbox("loop", &play.loop);
  slider("frames/s", play.speed, 0.25, 60);
  ImGui::Checkbox("record (r)", &play.record);
  if (!recorded.empty()) ImGui::TextWrapped("%s", recorded.c_str());
  ImGui::Separator();
  if (shown && !shown->error.empty())
    ImGui::TextWrapped("%s", shown->error.c_str());
  else if (shown)
    statistics(*shown, counts);
  ImGui::TextWrapped("Drag the picture to orbit, wheel to zoom, q to quit.");
  ImGui::PopItemWidth();
  ImGui::End();
}

} // namespace viewer
