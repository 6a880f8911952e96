// SPDX-License-Identifier: Apache-2.0
// Contours of the sheets on dense, nearly opaque fields in magnified views: a ramp in flat light, whose
// pictures differ by how segments are classified alone, and a ball under the default light.
#include <cmath>
#include <memory>

#include "tests/bench/render/render.h"
#include "tests/bench/sheet_residue.h"

namespace bccsplat::bench {
namespace {

constexpr int samples = 48;

struct Dense {
  const char* name;
  TransferFunction function;
};

std::vector<Dense> dense_functions() {
  const std::vector<ColorPoint> colors{
      {0.3, {0.2, 0.3, 0.9}}, {0.6, {0.3, 0.8, 0.3}}, {0.9, {0.9, 0.3, 0.1}}};
  return {{"ramp to 0.95", {colors, {{0.3, 0}, {1, 0.95}}}},
          {"0.85 in a tenth", {{{0, {0.5, 0.6, 0.8}}, {1, {1, 1, 1}}}, {{0.35, 0}, {0.45, 0.85}, {1, 0.95}}}},
          {"step to 0.9", {colors, {{0.4, 0}, {0.4, 0.9}, {1, 0.95}}}}};
}

FieldScene ramp(const Vec3& along, double slope) {
  const double middle = 0.5 * (samples - 1);
  return {"ramp",
          samples,
          [=](const Vec3& p, Vec3* gradient) {
            if (gradient) *gradient = slope * along;
            return 0.5 + slope * dot(along, p - Vec3{middle, middle, middle});
          },
          {}};
}

FieldScene ball(double width) {
  const double middle = 0.5 * (samples - 1);
  return {"ball",
          samples,
          [=](const Vec3& p, Vec3* gradient) {
            const Vec3 from = p - Vec3{middle, middle, middle};
            const double r = length(from), e = std::exp((r - 15) / width), value = 1 / (1 + e);
            if (gradient) *gradient = (r > 0 ? -value * (1 - value) / (width * r) : 0) * from;
            return value;
          },
          {}};
}

struct Shown {
  const char* light;
  double pixels; // per T
  bool perspective;
};

void add_rows(std::vector<Row>& rows, const FieldScene& of, const SampledScene& sampled, const Shown& shown,
              const std::string& field, const Report& report) {
  BenchContext two(2), one(1);
  const int size = report.quick ? 64 : 192;
  for (const Dense& f : dense_functions()) {
    FieldScene scene = of;
    scene.function = f.function;
    Camera camera = scene_camera(scene, size, shown.pixels, shown.perspective);
    if (shown.perspective) camera.fovy_degrees *= size / (shown.pixels * samples * 1.75);
    Scene s = splat_scene(scene, sampled, camera);
    if (std::string(shown.light) == "flat") s.lights.ambient = 1, s.lights.diffuse = s.lights.specular = 0;
    RenderOptions o;
    ImageStorage truth(size, size, true);
    RenderOptions fine;
    fine.sheet_step = report.quick ? 1.0 / 8 : 1.0 / 16, fine.preintegrate = Preintegrate::on;
    fine.kernel_form = KernelForm::flat_form, fine.opacity_stop = 1;
    (void)render(s, fine, two.get(), truth.image);
    Row row{word("field", field), word("light", shown.light),
            word("view", shown.perspective ? "perspective" : "orthographic"),
            figure("px per T", shown.pixels, 0), word("function", f.name)};
    for (const auto& [name, quality, preintegrate] :
         {std::tuple("normal", Quality::normal, Preintegrate::automatic),
          {"by entries", Quality::normal, Preintegrate::off},
          {"by integrals", Quality::normal, Preintegrate::on},
          {"fine", Quality::fine, Preintegrate::automatic}}) {
      o.quality = quality, o.preintegrate = preintegrate, o.kernel_form = KernelForm::flat_form;
      ImageStorage out(size, size);
      const RenderStats stats = render(s, o, one.get(), out.image);
      const double step =
          make_view(*s.slice, resolve_camera(camera), size, size, stats.sheet_step).step_world;
      const SheetResidue r = sheet_residue(out.image, truth.image, step);
      row.push_back(figure(std::string(name) + ", /255", r.sheets, 2));
      if (o.preintegrate == Preintegrate::automatic && quality == Quality::normal) {
        row.push_back(figure("beside", r.beside, 2));
        row.push_back(word("chosen", stats.drawn.preintegrated ? "integrals" : "entries"));
      }
      row.push_back(figure("dB", image_error(out.image, truth.image).psnr(), 1));
    }
    rows.push_back(row);
  }
}

} // namespace

void render_grain(const Report& report) {
  // From the default direction, 25 degrees aslant.
  const WorldCamera from = resolve_camera(scene_camera({"", samples, {}, {}}, 192, 8));
  const Vec3 along = std::cos(0.44) * from.forward + std::sin(0.44) * from.right;
  std::vector<Row> rows;
  for (const double slope : {0.02, 0.05, 0.1}) {
    const FieldScene field = ramp(along, slope);
    const SampledScene sampled = sample_scene(field, LatticeKind::bcc, "default");
    for (const Shown& shown : {Shown{"flat", 8, false}, Shown{"flat", 8, true}})
      add_rows(rows, field, sampled, shown, concat("ramp, ", slope, " per T"), report);
    if (report.quick) break;
  }
  for (const double width : {1.0, 2.0, 4.0}) {
    const FieldScene field = ball(width);
    const SampledScene sampled = sample_scene(field, LatticeKind::bcc, "default");
    for (const char* light : {"flat", "default"})
      add_rows(rows, field, sampled, {light, 5, false}, concat("ball, edge ", width, " T"), report);
    if (report.quick) break;
  }
  report.table("What of the error has the period of the sheets, dense fields, against sheets of 1/16 T",
               rows);
}

} // namespace bccsplat::bench
