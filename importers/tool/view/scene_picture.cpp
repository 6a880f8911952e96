// SPDX-License-Identifier: Apache-2.0
// Makes a scene of the volumes and channels that are asked for, and draws it.
#include "tool/view/scene_picture.h"

#include "readers/clock.h"
#include "readers/error.h"
#include "readers/lengths.h"
#include "tool/view/asked_trail.h"
#include "tool/view/render_function.h"
#include "tool/view/vectors.h"

namespace bcc4 {
namespace {

// What a channel's values look like: colours and opacities, or the look's where nobody chose any.
std::optional<TransferFunction> function_of(const Volume& volume, uint32_t channel,
                                            const FunctionChoice& choice) {
  const bccsplat_look look = make_look(volume, channel, choice.look, BCCSPLAT_MODE_COMPOSITE);
  return transfer_function(choice, channel_info(volume, channel), look);
}

FunctionChoice choice_of(const OtherVolume& o) {
  FunctionChoice c;
  c.tf = o.tf, c.colormap = o.colormap, c.range = o.range, c.opacity = o.opacity, c.look = o.look;
  return c;
}

FunctionChoice color_choice(const BesideArguments& a) {
  FunctionChoice c;
  c.tf = a.color_tf, c.colormap = a.color_colormap, c.range = a.color_range, c.always = true;
  return c;
}

Vector direction_of(const bccsplat_camera& c) {
  return normalised({c.target[0] - c.position[0], c.target[1] - c.position[1], c.target[2] - c.position[2]});
}

// Towards a light above the left of a camera.
Vector key_light(const bccsplat_camera& camera) {
  constexpr double left = 0.5, above = 0.8, behind = 0.6;
  const Vector ahead = direction_of(camera);
  const Vector right = normalised(cross(ahead, {camera.up[0], camera.up[1], camera.up[2]}));
  const Vector up = cross(right, ahead);
  Vector towards{};
  for (size_t a = 0; a < 3; ++a) towards[a] = above * up[a] - left * right[a] - behind * ahead[a];
  return towards;
}

// How times of the first volume become those of one beside it.
ClockChange clock_beside(const Volume& first, const Volume& other, const std::string& file) {
  if (volume_info(first).dims[3] == 1 || volume_info(other).dims[3] == 1) return {}; // seen at any time
  const auto [from, to] = told_by_both(clock_of(first), clock_of(other));
  const auto change = clock_change(from, to);
  if (!change)
    fail_input("--with ", file, ": its times are in ", clock_text(to), ", those of the first volume in ",
               clock_text(from), ": import one of them anew in the other's unit");
  return *change;
}

// How lengths of a volume beside the first become the first one's, along each axis of the world.
std::array<double, 3> lengths_beside(const Volume& first, const Volume& other, const std::string& file) {
  const auto to = axis_units(first), from = axis_units(other);
  std::array<double, 3> lengths{1, 1, 1};
  for (size_t a = 0; a < lengths.size(); ++a) {
    if (from[a].empty() || to[a].empty()) continue;
    const auto ratio = length_ratio(from[a], to[a]);
    if (!ratio)
      fail_input("--with ", file, ": its ", "xyz"[a], " is in ", from[a], ", that of the first volume in ",
                 to[a], ": import one of them anew in the other's unit");
    lengths[a] = *ratio;
  }
  return lengths;
}

} // namespace

void check_scene(const RenderArguments& a, const std::vector<Picture>& pictures) {
  const auto refuse = [](bool given, const char* option) {
    if (given)
      fail_usage(option,
                 " goes with one channel of one volume, without --with, --color-channel and --mask-channel");
  };
  for (const OtherVolume& other : a.beside.others)
    if (other.trail && !other.color_channel.empty())
      fail_usage("--with: a volume has a trail or a color-channel, not both");
  if (a.trail && !(a.beside.color_channel.empty() && a.beside.mask_channel.empty()))
    fail_usage("--trail goes with --with, but without --color-channel and --mask-channel");
  refuse(a.which.region.has_value(), "--roi (but --box does what it does)");
  refuse(a.which.level.has_value(), "--level");
  refuse(a.which.thickness.has_value(), "--thickness");
  refuse(a.which.method != BCCSPLAT_METHOD_DEFAULT, "--slice-method");
  refuse(a.gradient_noise.has_value() && !a.beside.others.empty(), "--gradient-noise");
  for (const Picture& p : pictures) refuse(!p.where.is_time_slice, "a plane off the time axis");
}

Lighting::Lighting(const BesideArguments& a, const bccsplat_camera& camera) : arguments_(a) {
  const auto add = [&](const Vector& d) { lights_.push_back({{d[0], d[1], d[2]}, {1, 1, 1}}); };
  for (const auto& d : a.lights) add(d);
  if (a.shadow && a.lights.empty()) add(key_light(camera));
}

bccsplat_lights Lighting::as_struct() const {
  auto l = sized<bccsplat_lights>();
  l.count = static_cast<uint32_t>(lights_.size()), l.lights = lights_.data();
  l.shadow = arguments_.shadow ? 1 : 0, l.occlusion = arguments_.occlusion ? 1 : 0;
  return l;
}

ScenePictures::ScenePictures(const Device& device, const Volume& volume, uint32_t channel,
                             const RenderArguments& arguments,
                             const std::optional<TransferFunction>& function,
                             const std::vector<TransferFunction>& trail_functions)
    : a_(arguments), volume_(volume) {
  bccsplat_scene* created = nullptr;
  check(bccsplat_scene_create(device.get(), &created), "scene");
  scene_ = bccsplat::client::Scene(created);
  if (!a_.beside.color_channel.empty()) {
    color_channel_ = find_channel(volume, a_.beside.color_channel);
    color_function_ = function_of(volume, *color_channel_, color_choice(a_.beside));
  }
  placed_.push_back({&volume, channel, function, nullptr, trail_functions});
  for (const OtherVolume& other : a_.beside.others) {
    const Volume& opened = others_.emplace_back(open_volume(device, other.file, "", a_.shape_drawn));
    if (other.trail && volume_info(opened).dims[3] == 1)
      fail_usage("--with: trail: ", other.file, " has one frame, in which nothing moves");
    const uint32_t of_other = find_channel(opened, other.channel);
    const bccsplat_look look = make_look(opened, of_other, other.look, BCCSPLAT_MODE_COMPOSITE);
    Placed& placed = placed_.emplace_back();
    placed.volume = &opened, placed.channel = of_other, placed.other = &other;
    placed.clock = clock_beside(volume, opened, other.file);
    placed.lengths = lengths_beside(volume, opened, other.file);
    placed.function = transfer_function(choice_of(other), channel_info(opened, of_other), look);
    if (auto dense = function_of_dense_trail(choice_of(other), look))
      placed.trail_functions.push_back(std::move(*dense));
  }
  for (Placed& placed : placed_) put(placed);
}

void ScenePictures::put(Placed& placed) {
  const Volume& volume = *placed.volume;
  const std::optional<TransferFunction>& function = placed.function;
  const OtherVolume* const other = placed.other;
  auto i = sized<bccsplat_instance>();
  i.channel = placed.channel;
  i.outside = BCCSPLAT_OUTSIDE_HOLD;
  bccsplat_transfer_function of_values, of_colors;
  if (function) of_values = as_struct(*function), i.transfer_function = &of_values;
  if (other) {
    i.density = other->density;
    for (size_t a = 0; a < 3; ++a)
      i.placement[5 * a] = placed.lengths[a], i.placement[4 * a + 3] = other->move[a];
    i.placement[15] = 1;
    i.time_scale = placed.clock.scale(), i.time_offset = placed.clock.offset();
    if (!other->color_channel.empty()) {
      i.set_mask |= BCCSPLAT_INSTANCE_SET_COLOR_CHANNEL;
      i.color_channel = find_channel(volume, other->color_channel);
    }
  } else if (color_channel_) {
    i.set_mask |= BCCSPLAT_INSTANCE_SET_COLOR_CHANNEL;
    i.color_channel = *color_channel_;
    of_colors = as_struct(*color_function_), i.color_function = &of_colors;
  }
  if (!other && !a_.beside.mask_channel.empty()) {
    i.set_mask |= BCCSPLAT_INSTANCE_SET_MASK_CHANNEL;
    i.mask_channel = find_channel(volume, a_.beside.mask_channel);
    i.mask_labels = a_.beside.mask_labels.data();
    i.mask_label_count = static_cast<uint32_t>(a_.beside.mask_labels.size());
  }
  const AskedTrail trail(a_, placed.trail, placed.trail_functions, other != nullptr);
  i.trail = trail.get();
  const bccsplat_status status = placed.id == 0
                                     ? bccsplat_scene_add(scene_.get(), volume.get(), &i, &placed.id)
                                     : bccsplat_scene_set_instance(scene_.get(), placed.id, &i);
  check(status, other ? other->file : a_.file);
}

void ScenePictures::set_trails(const Cut& where, bool index, const std::array<double, 2>& first) {
  for (Placed& placed : placed_) {
    const std::array<double, 2> before = placed.trail;
    if (!placed.other)
      placed.trail = first;
    else if (placed.other->trail)
      placed.trail =
          trail_interval_beside(*placed.other->trail, index, volume_, where, *placed.volume, placed.clock);
    if (placed.trail != before) put(placed); // set anew it would be made anew
  }
}

std::optional<FittedView::Bounds> ScenePictures::seen_of_others() const {
  std::optional<FittedView::Bounds> all;
  for (const Placed& placed : placed_) {
    if (!placed.other) continue;
    const bccsplat_look look = make_look(*placed.volume, placed.channel, placed.other->look, a_.mode);
    const double air = channel_info(*placed.volume, placed.channel).air;
    const FittedView view(*placed.volume, placed.channel, a_, seen_function(a_, placed.function, look, air),
                          BCCSPLAT_PROJECTION_ORTHOGRAPHIC, {1, 1}, {});
    Cut shape;
    shape.even = has_coordinates(*placed.volume);
    auto seen = view.seen_of_series(shape);
    if (!seen) continue;
    for (size_t n = 0; n < seen->size(); ++n)
      (*seen)[n] = placed.lengths[n % 3] * (*seen)[n] + placed.other->move[n % 3];
    all = all ? united(*all, *seen) : *seen;
  }
  return all;
}

void ScenePictures::set_lights(const bccsplat_lights& lights) {
  check(bccsplat_scene_set_lights(scene_.get(), &lights), "--light");
}

void ScenePictures::set_clips(const std::vector<bccsplat_clip>& clips) {
  check(bccsplat_scene_set_clips(scene_.get(), clips.data(), clips.size()), "--clip");
}

bccsplat_render_stats ScenePictures::draw(double time, const bccsplat_view& view, const Image& image,
                                          const bccsplat_render_options& options) {
  check(bccsplat_scene_set_time(scene_.get(), time), "--time");
  auto status = sized<bccsplat_scene_status>();
  check(bccsplat_scene_render(scene_.get(), &view, image.get(), &options, 0, &status), "render");
  auto stats = sized<bccsplat_render_stats>();
  stats.ms_total = status.ms_total, stats.bytes_read = status.bytes_read;
  stats.level = status.level, stats.backend = status.backend;
  return stats;
}

} // namespace bcc4
