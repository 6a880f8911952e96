// SPDX-License-Identifier: Apache-2.0
// Reads and checks what pictures are asked to be: cameras, options, transfer functions, lights.
#include "api/render_options.h"

#include <cmath>
#include <string_view>

#include "api/handles.h"
#include "api/numbers.h"
#include "api/structs.h"

namespace bccsplat::api {
namespace {

// Degrees across a perspective picture. In narrower ones gradients of pixels drown in the rounding of floats;
// in wider ones the first sheet is seen in the middle of the picture alone.
constexpr double smallest_angle = 1e-3, largest_angle = 170;

// Angles of up to 120 degrees in radians; nobody looks through so long a lens.
constexpr double likely_radians = 2.1;

} // namespace

void hint_at_camera(bccsplat_device& device, const Camera& camera) {
  if (!camera.perspective || camera.fovy_degrees > likely_radians) return;
  device.hint(bccsplat_device::Hint::fovy_in_radians,
              concat("camera: fovy_degrees is ", camera.fovy_degrees,
                     ", a very narrow view; an angle in radians is to be multiplied by 180 / pi"));
}

void hint_at_options(bccsplat_device& device, const RenderOptions& options) {
  if (options.surfaces.empty() || options.mode == RenderMode::isosurface) return;
  device.hint(bccsplat_device::Hint::surfaces_ignored,
              "render options: surfaces are drawn by BCCSPLAT_MODE_ISOSURFACE alone; this mode ignores them");
}

Camera read_camera(const bccsplat_camera* camera) {
  const auto in = read_struct(camera, "bccsplat_camera");
  require_choice(in.projection, BCCSPLAT_PROJECTION_PERSPECTIVE, "bccsplat_camera.projection");
  require_numbers(in.position, "bccsplat_camera.position", largest_view);
  require_numbers(in.target, "bccsplat_camera.target", largest_view);
  require_numbers(in.up, "bccsplat_camera.up", largest_view);
  if (in.projection == BCCSPLAT_PROJECTION_PERSPECTIVE)
    require_range(in.fovy_degrees, smallest_angle, largest_angle, "bccsplat_camera.fovy_degrees");
  else
    require_range(in.ortho_height, 1 / largest_view, largest_view, "bccsplat_camera.ortho_height");
  Camera c;
  c.perspective = in.projection == BCCSPLAT_PROJECTION_PERSPECTIVE;
  c.position = vec3(in.position), c.target = vec3(in.target), c.up = vec3(in.up);
  c.fovy_degrees = in.fovy_degrees, c.ortho_height = in.ortho_height;
  (void)resolve_camera(c); // refuses what cannot be looked through
  return c;
}

namespace {

std::vector<IsoSurface> read_surfaces(const bccsplat_render_options& in) {
  if (in.surface_count > BCCSPLAT_MAX_ISO_SURFACES)
    fail(Code::invalid_argument, "render options: ", in.surface_count, " surfaces; at most ",
         int{BCCSPLAT_MAX_ISO_SURFACES});
  if (in.surface_count > 0) require(in.surfaces, "bccsplat_render_options.surfaces");
  std::vector<IsoSurface> out;
  for (uint32_t n = 0; n < in.surface_count; ++n) {
    const bccsplat_iso_surface& s = in.surfaces[n];
    const std::string name = concat("bccsplat_render_options.surfaces[", n, "]");
    const auto field = [&](const char* of) { return name + of; };
    require_number(s.value, field(".value").c_str(), largest_value);
    require_range(s.opacity, 0, 1, field(".opacity").c_str());
    require_zero(s.reserved, field(".reserved").c_str());
    IsoSurface surface{s.value, s.opacity, {}};
    if (s.use_color) {
      require_range(s.color, 0, largest_colour, field(".color").c_str());
      surface.color = vec3(s.color);
    }
    out.push_back(surface);
  }
  return out;
}

} // namespace

RenderOptions read_render_options(const bccsplat_render_options* options) {
  const auto in = read_struct(options, "bccsplat_render_options");
  constexpr uint32_t set_bits = BCCSPLAT_RENDER_SET_ISO | BCCSPLAT_RENDER_SET_GRADIENT_NOISE;
  constexpr uint32_t skip_bits = BCCSPLAT_SKIP_TRANSFER_FUNCTION | BCCSPLAT_SKIP_FRUSTUM |
                                 BCCSPLAT_SKIP_OCCLUSION | BCCSPLAT_SKIP_EMPTY_SHEETS |
                                 BCCSPLAT_SKIP_FINE_DETAIL | BCCSPLAT_SKIP_UNCHANGED;
  if (in.set_mask & ~set_bits) fail(Code::invalid_argument, "render options: unknown bits in set_mask");
  require_choice(in.mode, BCCSPLAT_MODE_MAXIMUM, "bccsplat_render_options.mode");
  require_choice(in.quality, BCCSPLAT_QUALITY_BEST, "bccsplat_render_options.quality");
  require_choice(in.shading, BCCSPLAT_SHADING_ON, "bccsplat_render_options.shading");
  if (in.disable_skips & ~skip_bits)
    fail(Code::invalid_argument, "render options: unknown bits in disable_skips");
  require_zero_or(in.sheet_step, 1e-3, 16, "bccsplat_render_options.sheet_step");
  require_zero_or(in.opacity_stop, least_opacity_stop, 1, "bccsplat_render_options.opacity_stop");
  require_range(in.tile_size, 0, largest_tile, "bccsplat_render_options.tile_size");
  require_choice(in.preintegrate, BCCSPLAT_PREINTEGRATE_ON, "bccsplat_render_options.preintegrate");
  require_choice(in.smooth_edges, BCCSPLAT_SMOOTH_EDGES_ON, "bccsplat_render_options.smooth_edges");
  RenderOptions out;
  if (in.preintegrate)
    out.preintegrate = in.preintegrate == BCCSPLAT_PREINTEGRATE_ON ? Preintegrate::on : Preintegrate::off;
  if (in.mode) out.mode = static_cast<RenderMode>(in.mode);
  if (in.quality) out.quality = static_cast<Quality>(in.quality);
  if (in.shading) out.shading = in.shading == BCCSPLAT_SHADING_ON;
  out.smooth_edges = in.smooth_edges ? in.smooth_edges == BCCSPLAT_SMOOTH_EDGES_ON
                                     : quality_settings(out.quality).smooth_edges;
  const bool iso_given = in.set_mask & BCCSPLAT_RENDER_SET_ISO;
  if (iso_given) require_number(in.iso_value, "bccsplat_render_options.iso_value", largest_value);
  out.surfaces = read_surfaces(in);
  if (out.mode == RenderMode::isosurface && !iso_given && out.surfaces.empty())
    fail(Code::invalid_argument,
         "render options: mode isosurface needs iso_value (and its bit in set_mask) or surfaces");
  if (in.set_mask & BCCSPLAT_RENDER_SET_GRADIENT_NOISE)
    require_range(in.gradient_noise, 0, largest_value, "bccsplat_render_options.gradient_noise");
  out.iso_value = in.iso_value;
  out.sheet_step = in.sheet_step;
  if (in.opacity_stop != 0) out.opacity_stop = in.opacity_stop;
  out.disable_skips = in.disable_skips;
  out.tile_size = in.tile_size;
  out.reference = in.reference != 0;
  require_zero_or(in.depth_opacity, 1e-6, 1, "bccsplat_render_options.depth_opacity");
  if (in.depth_opacity != 0) out.depth_opacity = in.depth_opacity;
  require_range(in.deep_tolerance, 0, 1, "bccsplat_render_options.deep_tolerance");
  if (in.deep_tolerance > 0) out.deep_tolerance = in.deep_tolerance;
  require_choice(in.backend, BCCSPLAT_BACKEND_GPU, "bccsplat_render_options.backend");
  require_zero(in.reserved2, "bccsplat_render_options.reserved2");
  return out;
}

void use_device(RenderOptions& options, const bccsplat_device& device) {
  options.backend = device.backend, options.gpu = device.gpu;
}

RenderOptions read_render_options(const bccsplat_render_options* options, const bccsplat_device& device) {
  RenderOptions out = read_render_options(options);
  use_device(out, device);
  const auto in = read_struct(options, "bccsplat_render_options");
  if (in.backend) out.backend = static_cast<Backend>(in.backend);
  return out;
}

void use_target(RenderOptions& options, bccsplat_frame& frame, const HostView& view) {
  if (!frame.gl_drawers) return;
  if (options.reference) fail(Code::unsupported, "render: the reference integrator draws into no texture");
  GpuTarget& target = frame.target;
  if (target.depth_texture != 0) {
    if (!view.matrices)
      fail(Code::invalid_argument, "render: the frame's depth_texture needs a view by matrices");
    if (view.depth.pixels)
      fail(Code::invalid_argument, "render: the view has depths, and so has the frame; give one of them");
    const DeviceDepth depth = device_depth(*view.matrices);
    target.perspective = depth.perspective, target.reversed = view.matrices->reversed;
    target.constant = depth.constant, target.factor = depth.factor;
  }
  options.backend = Backend::gpu, options.gpu = frame.gl, options.target = &target;
}

bccsplat_backend drawn_by(const RenderStats& stats) {
  return std::string_view(stats.drawer) == "gpu" ? BCCSPLAT_BACKEND_GPU : BCCSPLAT_BACKEND_CPU;
}

void write_camera(const Camera& camera, bccsplat_camera* out) {
  bccsplat_camera c{};
  c.projection = camera.perspective ? BCCSPLAT_PROJECTION_PERSPECTIVE : BCCSPLAT_PROJECTION_ORTHOGRAPHIC;
  for (size_t a = 0; a < 3; ++a)
    c.position[a] = camera.position[a], c.target[a] = camera.target[a], c.up[a] = camera.up[a];
  c.fovy_degrees = camera.fovy_degrees, c.ortho_height = camera.ortho_height;
  write_struct(out, c, "camera");
}

TransferFunction read_function(const bccsplat_transfer_function* function) {
  const auto in = read_struct(function, "bccsplat_transfer_function");
  require_zero(in.reserved, "bccsplat_transfer_function.reserved");
  if (in.color_count > 0) require(in.colors, "colors");
  if (in.opacity_count > 0) require(in.opacities, "opacities");
  TransferFunction f;
  for (uint32_t i = 0; i < in.color_count; ++i) {
    const double* p = in.colors + 4 * size_t{i};
    require_number(p[0], "bccsplat_transfer_function.colors: a value", largest_value);
    f.colors.push_back({p[0], {p[1], p[2], p[3]}});
  }
  for (uint32_t i = 0; i < in.opacity_count; ++i) {
    const double* p = in.opacities + 2 * size_t{i};
    require_number(p[0], "bccsplat_transfer_function.opacities: a value", largest_value);
    f.opacities.push_back({p[0], p[1]});
  }
  require_zero_or(in.unit_distance, 1 / largest_distance, largest_distance,
                  "bccsplat_transfer_function.unit_distance");
  f.unit_distance = in.unit_distance;
  f.check();
  return f;
}

namespace {

constexpr double most_shininess = 1e6;

// Towards a light: its length counts for nothing, but must be one.
void check_direction(const double (&v)[3]) {
  require_numbers(v, "bccsplat_light.direction");
  const double length = std::hypot(v[0], v[1], v[2]);
  require_zero_or(length, smallest_length, 2 * largest_number, "bccsplat_light.direction: its length");
}

} // namespace

Lights read_lights(const bccsplat_lights* lights) {
  const auto in = read_struct(lights, "bccsplat_lights");
  if (in.count > most_lights)
    fail(Code::invalid_argument, "lights: ", in.count, " given, at most ", most_lights);
  if (in.count > 0) require(in.lights, "lights");
  Lights out;
  if (in.count > 0) out.lights.clear();
  for (uint32_t i = 0; i < in.count; ++i) {
    check_direction(in.lights[i].direction);
    require_range(in.lights[i].color, 0, largest_colour, "bccsplat_light.color");
    out.lights.push_back({vec3(in.lights[i].direction), vec3(in.lights[i].color)});
  }
  if (in.ambient != 0 || in.diffuse != 0 || in.specular != 0 || in.shininess != 0) {
    require_range(in.ambient, 0, largest_colour, "bccsplat_lights.ambient");
    require_range(in.diffuse, 0, largest_colour, "bccsplat_lights.diffuse");
    require_range(in.specular, 0, largest_colour, "bccsplat_lights.specular");
    require_range(in.shininess, 0, most_shininess, "bccsplat_lights.shininess");
    out.ambient = in.ambient, out.diffuse = in.diffuse, out.specular = in.specular,
    out.shininess = in.shininess;
  }
  require_choice(static_cast<int32_t>(in.shadow), 1, "bccsplat_lights.shadow");
  require_choice(static_cast<int32_t>(in.occlusion), 1, "bccsplat_lights.occlusion");
  out.shadow = in.shadow != 0, out.occlusion = in.occlusion != 0;
  return out;
}

} // namespace bccsplat::api
