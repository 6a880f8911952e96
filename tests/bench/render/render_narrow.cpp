// SPDX-License-Identifier: Apache-2.0
// Transfer functions narrower than the change of the field from sheet to sheet: slabs classified by one entry
// against pre-integrated ones, both against the exact integration of the field that the samples stand for.
#include <cmath>

#include "tests/bench/render/render.h"

namespace bccsplat::bench {
namespace {

struct Function {
  const char* name;
  TransferFunction function;
};

TransferFunction colored() {
  TransferFunction f;
  f.colors = {{0, {0.2, 0.3, 0.9}}, {0.5, {0.3, 0.8, 0.3}}, {1, {0.9, 0.3, 0.1}}};
  f.opacities = {{0, 0}};
  return f;
}

// A triangle of that half-width.
void add_peak(TransferFunction& f, double value, double half, double opacity) {
  f.opacities.push_back({value - half, 0});
  f.opacities.push_back({value, opacity});
  f.opacities.push_back({value + half, 0});
}

std::vector<Function> functions() {
  std::vector<Function> list;
  for (const double half : {0.01, 0.03}) {
    list.push_back({half == 0.01 ? "peak, half-width .01" : "peak, half-width .03", colored()});
    add_peak(list.back().function, 0.5, half, 0.95);
  }
  TransferFunction edges = colored();
  edges.opacities = {{0, 0}, {0.35, 0}, {0.35, 0.3}, {0.55, 0.3}, {0.55, 0}, {0.7, 0}, {0.7, 0.6}, {1, 0.6}};
  list.push_back({"steps", edges});
  TransferFunction shells = colored();
  for (const double value : {0.3, 0.45, 0.6, 0.75}) add_peak(shells, value, 0.01, 0.6);
  list.push_back({"four peaks, half-width .01", shells});
  TransferFunction bands; // of colour, on a ramp
  for (int n = 0; n < 10; ++n) {
    const Vec3 color = n % 2 ? Vec3{0.9, 0.5, 0.1} : Vec3{0.1, 0.3, 0.8};
    bands.colors.push_back({0.1 * n, color});
    bands.colors.push_back({0.1 * (n + 1), color});
  }
  bands.opacities = {{0.3, 0}, {1, 0.1}};
  list.push_back({"ramp, bands of colour .1 wide", bands});
  TransferFunction ramp = colored();
  ramp.opacities = {{0.3, 0}, {1, 0.1}};
  list.push_back({"ramp", ramp});
  return list;
}

void compare(const Report& report, const FieldScene& scene, const SampledScene& sampled, double pixels,
             double exact_step) {
  BenchContext one(1);
  const int size = static_cast<int>(std::ceil(scene.samples * 1.75 * pixels / 16)) * 16;
  const Camera camera = scene_camera(scene, size, pixels);
  constexpr int stride = 8;
  std::vector<Row> rows;
  for (const Function& f : functions()) {
    FieldScene with = scene;
    with.function = f.function;
    const Scene s = splat_scene(with, sampled, camera);
    RenderOptions plain, lit;
    plain.shading = false, plain.opacity_stop = lit.opacity_stop = 1;
    const auto exact = true_image(with, sampled, camera, plain, size, stride, true, exact_step);
    const auto exact_lit = true_image(with, sampled, camera, lit, size, stride, true, exact_step);
    std::vector<Method> flat, shaded;
    std::vector<bool> chosen;
    for (const double step : {1.0, 0.5, 0.25}) {
      plain.sheet_step = lit.sheet_step = step;
      plain.preintegrate = lit.preintegrate = Preintegrate::automatic;
      ImageStorage out(size, size);
      chosen.push_back(render(s, lit, one.get(), out.image).drawn.preintegrated);
      for (const Preintegrate p : {Preintegrate::off, Preintegrate::on}) {
        plain.preintegrate = lit.preintegrate = p;
        flat.push_back(splat_method("", s, plain, one));
        shaded.push_back(splat_method("", s, lit, one));
      }
    }
    const std::vector<double> ms = least_ms(shaded, size, report.quick ? 1 : 5);
    for (size_t i = 0; i < flat.size(); i += 2) {
      const auto db = [&](const Method& m, const Image& truth) {
        return method_error(m, size, truth, stride).psnr();
      };
      rows.push_back({word("function", f.name), figure("step T", flat[i].step, 2),
                      word("chosen", chosen[i / 2] ? "on" : "off"),
                      figure("unshaded dB off", db(flat[i], exact->image), 1),
                      figure("on", db(flat[i + 1], exact->image), 1),
                      figure("shaded dB off", db(shaded[i], exact_lit->image), 1),
                      figure("shaded on", db(shaded[i + 1], exact_lit->image), 1), figure("ms off", ms[i], 1),
                      figure("ms on", ms[i + 1], 1), figure("ratio", ms[i + 1] / ms[i], 2)});
    }
  }
  report.table(
      concat(scene.name, ' ', scene.samples, "^3, ", pixels,
             " px per T: slabs by one entry (off) and by integrals (on), PSNR against the own field"),
      rows);
}

} // namespace

void render_narrow(const Report& report) {
  const FieldScene scene = marschner_lobb_scene(report.quick ? 20 : 41);
  const SampledScene sampled = sample_scene(scene, LatticeKind::bcc, "default");
  compare(report, scene, sampled, 2, report.quick ? 1.0 / 64 : 1.0 / 128);
  if (report.quick) return;
  const FieldScene rings = bessel_scene(41);
  compare(report, rings, sample_scene(rings, LatticeKind::bcc, "default"), 2, 1.0 / 128);
}

} // namespace bccsplat::bench
