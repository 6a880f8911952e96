// SPDX-License-Identifier: Apache-2.0
// Whether the picture of a case is what it should be: against the slow reference, a scene against a renderer,
// a budget against the whole, parts against one, deep samples against the flat picture.
#pragma once

#include <limits>

#include "field_truth.h"

namespace host::pairs {

class PictureTruth {
 public:
  using Pixels = std::vector<float>;

  PictureTruth(const Device& device, const Asked& asked, const FieldTruth& field)
      : device_(device), asked_(asked), field_(field), slice_(field.cut(true)) {
    const Range& r = field.range();
    const double low = r.low, high = r.high;
    colors_ = {low, .1, .2, .9, (low + high) / 2, .2, .9, .3, high, 1, .3, .1};
    opacities_ = {low + .15 * r.length(), 0, high, .25};
    function_.colors = colors_.data(), function_.color_count = 3;
    function_.opacities = opacities_.data(), function_.opacity_count = 2;
    label_colors_ = {1, 1, 0, 0, 2, 0, 0, 1};
    label_function_ = function_;
    label_function_.colors = label_colors_.data(), label_function_.color_count = 2;
    check(bccsplat_slice_fit_camera(
        slice_.get(), asked.perspective ? BCCSPLAT_PROJECTION_PERSPECTIVE : BCCSPLAT_PROJECTION_ORTHOGRAPHIC,
        20, 30, width, height, &camera_));
    if (asked.behind_things) place_things();
  }
  void check_picture() {
    const Asked& a = asked_;
    const Frame frame = make_frame(a.planes);
    draw(a, whole(), frame);
    const Pixels picture = plane(frame, BCCSPLAT_FRAME_RGBA);
    if (a.planes & BCCSPLAT_FRAME_DEEP) compare(flattened(frame), picture, 1e-4, "the deep picture");
    if (a.in_parts) compare(drawn_in_parts(), picture, 1e-3, "the picture of parts");
    if (a.drawn == Drawn::budget) compare(drawn_in_time(), picture, 2e-3, "the picture of a budget");
    Asked other = a;
    if (a.drawn == Drawn::scene || a.drawn == Drawn::budget || a.drawn == Drawn::two) {
      other.drawn = Drawn::renderer;
      // Of two in one place, whose densities are halved, each has its surfaces.
      if (a.drawn == Drawn::two)
        other.surfaces.insert(other.surfaces.end(), a.surfaces.begin(), a.surfaces.end());
      compare(drawn(other), picture, a.drawn == Drawn::two ? 2e-2 : 1e-5, "the renderer's picture");
    }
    check_against_reference(frame, other);
  }

 private:
  static constexpr uint32_t width = 28, height = 24;

  [[nodiscard]] bccsplat_view whole() const {
    auto v = sized<bccsplat_view>();
    v.camera = &camera_;
    if (asked_.behind_things) v.depth = depth_.data(), v.depth_kind = BCCSPLAT_DEPTH_PLANAR;
    return v;
  }
  // A wall through the middle of what is drawn, before the left half of the picture.
  void place_things() {
    double squares = 0;
    for (size_t k = 0; k < 3; ++k) squares += std::pow(camera_.target[k] - camera_.position[k], 2);
    for (uint32_t n = 0; n < width * height; ++n)
      depth_.push_back(n % width < width / 2 ? static_cast<float>(std::sqrt(squares))
                                             : std::numeric_limits<float>::infinity());
  }
  [[nodiscard]] Frame make_frame(uint32_t planes, uint32_t of_width = width) const {
    bccsplat_frame* f = nullptr;
    check(bccsplat_frame_create(device_.get(), of_width, height, planes, &f));
    return Frame(f);
  }
  static Pixels plane(const Frame& frame, uint32_t channel) {
    auto p = sized<bccsplat_plane>();
    check(bccsplat_frame_get_channel(frame.get(), channel, &p));
    return {p.pixels, p.pixels + size_t{p.components} * p.width * p.height};
  }
  [[nodiscard]] std::array<bccsplat_clip, 1> clips() const {
    bccsplat_clip c{};
    c.normal[0] = 1, c.normal[1] = .5;
    for (size_t k = 0; k < 3; ++k) c.offset -= c.normal[k] * camera_.target[k];
    return {c};
  }
  [[nodiscard]] bccsplat_render_options options(const Asked& a) const {
    auto o = a.render;
    o.quality = BCCSPLAT_QUALITY_FINE, o.smooth_edges = BCCSPLAT_SMOOTH_EDGES_OFF;
    const Range& r = field_.range();
    o.set_mask |= BCCSPLAT_RENDER_SET_ISO, o.iso_value = r.low + .45 * r.length();
    surfaces_ = a.surfaces;
    for (bccsplat_iso_surface& s : surfaces_) s.value = r.low + s.value * r.length();
    o.surfaces = surfaces_.data(), o.surface_count = static_cast<uint32_t>(surfaces_.size());
    if (a.drawn == Drawn::two || a.planes & BCCSPLAT_FRAME_DEEP) o.opacity_stop = 1;
    return o;
  }
  [[nodiscard]] Pixels drawn(const Asked& a) const {
    const Frame frame = make_frame(a.planes);
    draw(a, whole(), frame);
    return plane(frame, BCCSPLAT_FRAME_RGBA);
  }
  void draw(const Asked& a, const bccsplat_view& view, const Frame& frame) const {
    if (a.drawn == Drawn::renderer)
      draw_by_renderer(a, view, frame);
    else
      draw_by_scene(make_scene(a), a, view, frame, 0);
  }
  void draw_by_renderer(const Asked& a, const bccsplat_view& view, const Frame& frame) const {
    bccsplat_renderer* created = nullptr;
    check(bccsplat_renderer_create(device_.get(), &created));
    const Renderer renderer(created);
    check(bccsplat_renderer_set_slice(created, slice_.get()));
    check(bccsplat_renderer_set_transfer_function(created, &function_));
    check(bccsplat_renderer_set_view(created, &view));
    if (a.has_trail) check(bccsplat_renderer_set_trail(created, &a.trail));
    if (a.lights.shadow) check(bccsplat_renderer_set_lights(created, &a.lights));
    const auto cuts = clips();
    if (a.clipped) check(bccsplat_renderer_set_clips(created, cuts.data(), cuts.size()));
    const auto o = options(a);
    check(bccsplat_renderer_set_options(created, &o));
    check(bccsplat_renderer_render(created, frame.get()));
  }
  using Scene = Handle<bccsplat_scene>;
  [[nodiscard]] Scene make_scene(const Asked& a) const {
    bccsplat_scene* created = nullptr;
    check(bccsplat_scene_create(device_.get(), &created));
    Scene scene(created);
    auto i = sized<bccsplat_instance>();
    i.transfer_function = &function_;
    if (a.has_trail) i.trail = &a.trail;
    static constexpr double labels[1] = {1};
    if (a.drawn == Drawn::masked) {
      i.set_mask = BCCSPLAT_INSTANCE_SET_MASK_CHANNEL, i.mask_channel = 1;
      i.mask_labels = labels, i.mask_label_count = 1;
    }
    if (a.drawn == Drawn::painted) {
      i.set_mask = BCCSPLAT_INSTANCE_SET_COLOR_CHANNEL, i.color_channel = 1;
      i.color_function = &label_function_;
    }
    if (a.drawn == Drawn::two) i.density = .5;
    uint64_t id = 0;
    for (int n = 0; n < (a.drawn == Drawn::two ? 2 : 1); ++n)
      check(bccsplat_scene_add(created, field_.volume().get(), &i, &id));
    check(bccsplat_scene_set_time(created, a.still() ? 0 : .5 * FieldTruth::moment));
    if (a.lights.shadow) check(bccsplat_scene_set_lights(created, &a.lights));
    const auto cuts = clips();
    if (a.clipped) check(bccsplat_scene_set_clips(created, cuts.data(), cuts.size()));
    return scene;
  }
  bool draw_by_scene(const Scene& scene, const Asked& a, const bccsplat_view& view, const Frame& frame,
                     double budget) const {
    const auto o = options(a);
    auto status = sized<bccsplat_scene_status>();
    check(bccsplat_scene_render(scene.get(), &view, frame.get(), &o, budget, &status));
    return status.complete != 0;
  }
  [[nodiscard]] Pixels drawn_in_time() const {
    const Frame frame = make_frame(asked_.planes);
    const Scene scene = make_scene(asked_);
    int calls = 1;
    while (!draw_by_scene(scene, asked_, whole(), frame, .05))
      demand(++calls < 2000, "a budget never ends in the whole picture");
    return plane(frame, BCCSPLAT_FRAME_RGBA);
  }
  [[nodiscard]] Pixels drawn_in_parts() const {
    Pixels picture(size_t{4} * width * height);
    for (uint32_t begin = 0, next = 0; begin < width; begin = next) {
      next = begin == 0 ? 17 : width;
      const Frame frame = make_frame(asked_.planes, next - begin);
      auto v = whole();
      v.picture_size[0] = width, v.picture_size[1] = height, v.region_begin[0] = begin;
      if (v.depth) v.depth += begin, v.depth_row_bytes = width * sizeof(float);
      draw(asked_, v, frame);
      const Pixels part = plane(frame, BCCSPLAT_FRAME_RGBA);
      for (uint32_t y = 0; y < height; ++y)
        std::copy_n(part.begin() + std::ptrdiff_t{4} * y * (next - begin), 4 * (next - begin),
                    picture.begin() + std::ptrdiff_t{4} * (y * width + begin));
    }
    return picture;
  }
  static Pixels flattened(const Frame& frame) {
    auto deep = sized<bccsplat_deep>();
    check(bccsplat_frame_get_deep(frame.get(), &deep));
    Pixels sums(size_t{4} * width * height);
    for (size_t p = 0; p < size_t{width} * height; ++p)
      for (uint64_t n = deep.first[p]; n < deep.first[p + 1]; ++n) {
        const float* const sample = deep.samples + 6 * n; // z, z_back, opacity, red, green, blue
        const float open = 1 - sums[4 * p + 3];
        for (size_t k = 0; k < 4; ++k) sums[4 * p + k] += open * sample[k == 3 ? 2 : 3 + k];
      }
    return sums;
  }
  static double largest(const Pixels& p) {
    double most = 1;
    for (const float v : p) most = std::max(most, std::fabs(double{v}));
    return most;
  }
  static void compare(const Pixels& got, const Pixels& want, double most, const char* what) {
    const double off = largest_difference(got, want);
    demand(off <= most * largest(want), what, " is off by ", off, " of ", largest(want));
  }
  // A picture against that of the slow reference, which says what it does not draw.
  void check_against_reference(const Frame& picture, Asked a) const {
    a.render.reference = 1, a.render.backend = BCCSPLAT_BACKEND_CPU;
    const Frame slow = make_frame(a.planes);
    const bool flat = a.dims[2] == 1; // and so without any shadow
    const bool shadows = a.lights.shadow && a.render.mode == BCCSPLAT_MODE_DEFAULT && !flat;
    const bool deep = a.planes & BCCSPLAT_FRAME_DEEP;
    const bool draws_it = !a.has_trail && !shadows && !deep && a.drawn != Drawn::painted;
    bool drawn = true;
    try {
      draw(a, whole(), slow);
    } catch (const Refusal& r) {
      if (draws_it || r.status != BCCSPLAT_ERROR_UNSUPPORTED) throw;
      drawn = false;
    }
    demand(drawn == draws_it, "the reference draws what it says that it does not");
    if (drawn) compare_with_reference(picture, slow);
  }
  void compare_with_reference(const Frame& fast, const Frame& slow) const {
    const Pixels got = plane(fast, BCCSPLAT_FRAME_RGBA), want = plane(slow, BCCSPLAT_FRAME_RGBA);
    double squares = 0;
    for (size_t n = 0; n < got.size(); ++n) squares += std::pow(double{got[n]} - want[n], 2);
    const double rmse = std::sqrt(squares / double(got.size())) / largest(want);
    demand(rmse <= 2e-2, "off the reference by RMSE ", rmse, " of ", largest(want));
    for (const uint32_t channel : {BCCSPLAT_FRAME_DEPTH, BCCSPLAT_FRAME_VALUE, BCCSPLAT_FRAME_TIME}) {
      if (!(asked_.planes & channel)) continue;
      const Pixels a = plane(fast, channel), b = plane(slow, channel);
      for (size_t n = 0; n < a.size(); ++n) {
        if (got[4 * n + 3] < .6 || want[4 * n + 3] < .6) continue; // beside an edge
        const bool integral = asked_.render.mode == BCCSPLAT_MODE_XRAY;
        // The mean time of next to nothing.
        if (integral && channel == BCCSPLAT_FRAME_TIME && std::fabs(want[4 * n]) < 1e-3 * largest(want))
          continue;
        const double unit = channel != BCCSPLAT_FRAME_VALUE ? 1
                            : integral                      ? largest(want)
                                                            : field_.range().length();
        demand(a[n] == b[n] || (std::isnan(a[n]) && std::isnan(b[n])) || std::fabs(a[n] - b[n]) <= .5 * unit,
               "plane ", channel, " has ", a[n], ", the reference ", b[n]);
      }
    }
  }

  const Device& device_;
  const Asked& asked_;
  const FieldTruth& field_;
  Slice slice_;
  bccsplat_camera camera_ = sized<bccsplat_camera>();
  std::vector<double> colors_, opacities_, label_colors_;
  std::vector<float> depth_;
  mutable std::vector<bccsplat_iso_surface> surfaces_;
  bccsplat_transfer_function function_ = sized<bccsplat_transfer_function>(),
                             label_function_ = sized<bccsplat_transfer_function>();
};

} // namespace host::pairs
