// SPDX-License-Identifier: Apache-2.0
// Where the parts stand: title and moment top left, the colour bar on the right, the axes and the scale in
// the lower corners. All sizes go with the smaller side of the picture.
#include "tool/annotate/annotation.h"
#include "readers/system.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "tool/annotate/axes_gizmo.h"
#include "tool/annotate/bars.h"
#include "tool/annotate/box_outline.h"
#include "tool/annotate/font.h"
#include "tool/annotate/scale_bar.h"
#include "tool/annotate/ticks.h"
#include "tool/view/dates.h"
#include "tool/view/picture_output.h"
#include "tool/view/picture_shape.h"

namespace bcc4 {
namespace {

constexpr double em_share = 0.027, least_em = 12; // of the smaller side, and pixels that are still read
constexpr double margin_em = 1, title_em = 1.25, line_em = 1.5;
constexpr double bar_width_share = 0.4, bar_height_share = 0.55, two_bars_height_share = 0.7;
constexpr double scale_share = 0.22;

std::string with_unit(const std::string& text, const std::string& unit) {
  return unit.empty() ? text : concat(text, " ", unit);
}

// The hyperplane of a slice that is not a moment.
std::string plane_text(const Cut& where) {
  if (where.point) return "";
  const double* p = where.plane;
  for (size_t a = 0; a < 3; ++a)
    if (p[a] != 0 && p[(a + 1) % 4] == 0 && p[(a + 2) % 4] == 0 && p[(a + 3) % 4] == 0)
      return concat(std::string(1, "xyz"[a]), " = ", short_number(-p[4] / p[a], 4));
  std::string numbers;
  for (size_t i = 0; i < 5; ++i) numbers += concat(i ? ", " : "", short_number(p[i], 3));
  return "plane " + numbers;
}

// A date where the file tells one, else the time in its unit.
std::string moment_text(const bccsplat_volume_info& v, const Dates& dates, double time,
                        const std::string& text) {
  if (std::string date = dates.of(time); !date.empty()) return date;
  return v.dims[3] > 1 ? with_unit("t = " + text, v.time_unit) : "";
}

std::vector<std::string> moments_of(const Volume& volume, const std::vector<Picture>& pictures) {
  const bccsplat_volume_info v = volume_info(volume);
  std::vector<double> times;
  for (const Picture& p : pictures)
    if (p.where.is_time_slice) times.push_back(p.where.time);
  const std::vector<std::string> texts = tick_texts(times);
  std::vector<std::string> out;
  const Dates dates(volume);
  size_t next = 0;
  for (const Picture& p : pictures) {
    if (!p.where.is_time_slice)
      out.push_back(plane_text(p.where));
    else
      out.push_back(moment_text(v, dates, p.where.time, texts[next])), ++next;
  }
  return out;
}

void tell_missing(const RenderArguments& a, const char* part, const char* why) {
  if (a.annotate->by_name) std::fprintf(stderr, "bcc4: --annotate %s: %s\n", part, why);
}

} // namespace

Annotation::Annotation(const RenderArguments& a, const Volume& volume, uint32_t channel,
                       std::vector<std::array<double, 4>> colors, bool of_labels, double iso_value,
                       const std::vector<Picture>& pictures)
    : a_(a), parts_(*a.annotate), volume_(volume_info(volume)), title_(a.title),
      spatial_unit_(volume_.spatial_unit), colors_(std::move(colors)), moments_(moments_of(volume, pictures)),
      names_(world_names(volume)), one_unit_(!different_units(volume)) {
  require_font();
  const bccsplat_channel_info c = channel_info(volume, channel);
  heading_ = *c.name ? c.name : "value";
  if (a.mode == BCCSPLAT_MODE_XRAY)
    heading_ = concat(heading_, " × ", spatial_unit_.empty() ? "length" : spatial_unit_.c_str());
  if (*c.unit) heading_ = concat(heading_, " [", c.unit, "]");
  if (a.iso.size() > 1) fields_ = surface_bar(heading_, a.iso, colors_);
  constexpr size_t most_fields = 64; // that can be read, two colours for each
  constexpr double told = 256;       // labels as far from each other are one in a bin of the histogram
  const bool each =
      of_labels && colors_.size() <= 2 * most_fields && c.kept_range[1] - c.kept_range[0] < told;
  if (each && !fields_ && a.mode != BCCSPLAT_MODE_ISOSURFACE && a.mode != BCCSPLAT_MODE_XRAY)
    fields_ = label_bar(heading_, colors_);
  if (a.mode == BCCSPLAT_MODE_ISOSURFACE) {
    std::array<double, 4> only = colors_.front();
    for (const auto& color : colors_)
      if (color[0] <= iso_value) only = color;
    only[0] = iso_value;
    if (!a.iso.empty() && a.iso.front().use_color) std::copy_n(a.iso.front().color, 3, only.begin() + 1);
    colors_ = {only};
  }
  if (title_.empty()) title_ = to_text(to_path(a.file).stem());
  std::string written = heading_ + spatial_unit_;
  if (parts_.title) written += title_;
  for (const std::string& moment : moments_) written += moment;
  if (const std::string none = missing_letters(written); !none.empty())
    std::fprintf(stderr, "bcc4: --annotate: boxes are drawn for letters that the font does not have: %s\n",
                 none.c_str());
  // Dark letters on what is bright; on a transparent picture bright ones with a dark seam, which can
  // be read on either.
  if (const auto b = linear_background(a); b && 0.21 * (*b)[0] + 0.72 * (*b)[1] + 0.07 * (*b)[2] > 0.2)
    std::swap(ink_.color, ink_.halo);
  for (const Picture& p : pictures) is_time_slice_.push_back(p.where.is_time_slice);
  if (parts_.time && moments_.front().empty())
    tell_missing(a, "time", "the file has one moment only, or the slice is at a point of its own");
  if (parts_.scale && !pictures.front().where.is_time_slice)
    tell_missing(a, "scale", "only where the axes of a slice are those of space");
  else if (parts_.scale && !one_unit_)
    tell_missing(a, "scale", "the axes of the file have different units");
}

std::optional<ColorBar> Annotation::color_bar(const std::optional<XrayExposure>& exposure) const {
  if (fields_) return fields_;
  if (a_.mode != BCCSPLAT_MODE_XRAY) return ColorBar{heading_, colors_};
  if (!exposure || !(exposure->white > 0)) return std::nullopt;
  return ColorBar{heading_, {{0, 0, 0, 0}, {exposure->white, 1, 1, 1}}};
}

void Annotation::draw(const Image& image, size_t number, const bccsplat_camera& camera,
                      const bccsplat_slice_info& domain, const std::optional<XrayExposure>& exposure,
                      const std::optional<ColorBar>& trail) const {
  Canvas canvas(image);
  const double w = canvas.width(), h = canvas.height(), side = std::min(w, h);
  const double em = std::max(least_em, em_share * side), margin = margin_em * em;
  const Projection projection(camera, w, h);
  if (parts_.box) draw_box(canvas, projection, domain, std::max(1.0, side / 700), ink_.color);
  double baseline = margin + title_em * em * 0.8;
  if (parts_.title) {
    canvas.text(fitted_text(title_, title_em * em, w - 2 * margin), {margin, baseline}, title_em * em,
                Anchor::left, ink_);
    baseline += line_em * em;
  }
  if (parts_.time && !moments_[number].empty())
    canvas.text(fitted_text(moments_[number], em, w - 2 * margin), {margin, baseline}, em, Anchor::left,
                ink_);
  if (parts_.colorbar) {
    std::vector<ColorBar> bars;
    if (const auto bar = color_bar(exposure)) bars.push_back(*bar);
    if (trail) bars.push_back(*trail);
    // One below the other, a line apart.
    const double height = (bars.size() > 1 ? two_bars_height_share : bar_height_share) * h;
    const double top = std::max((h - height) / 2, 3.5 * em);
    const double each = (height + line_em * em) / std::max(1.0, static_cast<double>(bars.size()));
    for (size_t n = 0; n < bars.size(); ++n)
      draw_color_bar(canvas, bars[n], {w - margin, top + static_cast<double>(n) * each}, bar_width_share * w,
                     each - line_em * em, em, ink_);
  }
  if (parts_.axes)
    draw_axes(canvas, projection, domain, volume_, names_, {margin + 3.2 * em, h - margin - 3.2 * em}, em,
              ink_);
  const double length = projection.world_per_pixel(domain_centre(domain));
  if (parts_.scale && is_time_slice_[number] && one_unit_ && length > 0)
    draw_scale_bar(canvas, length, spatial_unit_, {w - margin, h - margin - 0.3 * em}, scale_share * w, em,
                   ink_);
}

} // namespace bcc4
