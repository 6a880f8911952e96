// SPDX-License-Identifier: Apache-2.0
// Writes the kernel as nested products and the sites in its reach as a table of offsets, around the one body.
#include "gpu/shader.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "base/text.h"
#include "lattice/lattice.h"
#include "points/brick.h"

namespace bccsplat {
namespace {

constexpr const char* compute_glsl = "#version 430\n";
#if defined(__EMSCRIPTEN__)
constexpr const char* raster_glsl = "#version 300 es\n";
#else
constexpr const char* raster_glsl = "#version 330\n";
#endif

constexpr const char* march_body =
#include "gpu/march.glsl.inc"
    ;

std::string number(double x) {
  std::string out = concat(static_cast<float>(x));
  return out.find_first_of(".en") == std::string::npos ? out + ".0" : out;
}

std::string define(const std::string& name, const std::string& value) {
  return "#define " + name + " " + value + "\n";
}
std::string define(const std::string& name, int value) { return define(name, std::to_string(value)); }

// Returns sum_j a[j] u^j as nested products.
std::string nested(const std::vector<double>& a) {
  std::string out = number(a.back());
  for (size_t j = a.size() - 1; j-- > 0;)
    out = (a[j] != 0 ? "(" + number(a[j]) + "+" : std::string("(")) + "u*" + out + ")";
  return out;
}

std::string kernel_text(const RadialKernel& kernel, bool bcc) {
  std::vector<double> a(kernel.a.begin(), kernel.a.begin() + kernel.terms), slope;
  for (size_t j = 1; j < a.size(); ++j) slope.push_back(static_cast<double>(j) * a[j]);
  const double sites = kernel.radius / coset_pitch(bcc);
  return define("PHI(u)", nested(a)) + define("SLOPE(u)", nested(slope)) +
         define("OVER_RADIUS2", number(1 / (sites * sites)));
}

// How near a site is at least to the points between 0 and 1/2 of it along an axis, in sites.
double nearest_along(int site) { return site > 0 ? site - 0.5 : -site; }

using Offsets = std::vector<Int3>;
Offsets reached_sites(const RadialKernel& kernel, bool bcc) {
  constexpr int most = 2; // no kernel reaches farther than two sites of a coset
  const double sites = kernel.radius / coset_pitch(bcc);
  Offsets out;
  for (int z = -most; z <= most; ++z)
    for (int y = -most; y <= most; ++y)
      for (int x = -most; x <= most; ++x)
        if (std::hypot(nearest_along(x), nearest_along(y), nearest_along(z)) < sites)
          out.push_back({x, y, z});
  return out;
}

std::string reached_text(const RadialKernel& kernel, bool bcc) {
  const Offsets sites = reached_sites(kernel, bcc);
  const std::string count = std::to_string(sites.size());
  std::string out = define("REACHED", count) + "const vec3 reached[" + count + "] = vec3[" + count + "](";
  for (size_t n = 0; n < sites.size(); ++n)
    out += (n > 0 ? "," : "") + std::string("vec3(") + number(sites[n][0]) + "," + number(sites[n][1]) + "," +
           number(sites[n][2]) + ")";
  return out + ");\n";
}

const char* const buffer_sites = R"(
layout(std430, binding = 0) readonly buffer Sites { float sites[]; };
#define PLACE int
int place_in(uint which, ivec3 at) { return ((int(which) * EDGE + at.z) * EDGE + at.y) * EDGE + at.x; }
float site_value(int place, ivec3 to) { return sites[place + (to.z * EDGE + to.y) * EDGE + to.x]; }
)";
const char* const texture_sites = R"(
uniform highp sampler3D sites;
#define PLACE ivec3
ivec3 place_in(uint which, ivec3 at) {
  return ivec3(int(which) & 1023, int(which >> 10) & 1023, int(which >> 20)) * EDGE + at;
}
float site_value(ivec3 place, ivec3 to) { return texelFetch(sites, place + to, 0).r; }
)";
const char* const merge_buffers = R"(
layout(std430, binding = 0) buffer Sites { float sites[]; };
layout(std430, binding = 1) readonly buffer Layer { float layer[]; };
layout(std430, binding = 2) readonly buffer From { uint from[]; };
uniform uint first, table, adds;
uniform float weight;
void main() {
  const uint size = uint(EDGE * EDGE * EDGE);
  uint at = gl_GlobalInvocationID.x, brick = gl_WorkGroupID.y, own = from[table + brick];
  if (at >= size || (own == 0u && adds != 0u)) return;
  uint to = (first + brick) * size + at;
  float part = weight * layer[own * size + at];
  sites[to] = adds != 0u ? sites[to] + part : part;
}
)";
const char* const merge_textures = R"(
uniform highp usampler2D from; // by layer and brick, in rows of 1024
uniform float weights[LAYERS];
uniform ivec3 atlas; // bricks along x and y; of this moment; the first of them
uniform ivec2 table; // entry of the first layer; how many
uniform int plane;
layout(location = 0) out highp float site;
ivec3 place_in(int n, int brick, ivec3 at) {
  int entry = table.x + n * atlas.y + brick;
  int which = int(texelFetch(from, ivec2(entry & 1023, entry >> 10), 0).r);
  return ivec3(which & 1023, which >> 10 & 1023, which >> 20) * EDGE + at;
}
void main() {
  ivec3 at = ivec3(ivec2(gl_FragCoord.xy), plane), of = at / EDGE;
  int brick = (of.z * atlas.x + of.y) * atlas.x + of.x - atlas.z;
  at -= of * EDGE;
  if (brick < 0 || brick >= atlas.y) discard;
)";
const char* const compute_main = R"(
void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, picture.z);
  if (pixel.x >= picture.x || pixel.y >= picture.y) return;
  vec4 color, more;
  draw_pixel(pixel, color, more);
  int n = pixel.y * picture.x + pixel.x;
  pixels[n] = color, pixels[picture.x * picture.y + n] = more;
}
)";
const char* const fragment_main = R"(
layout(location = 0) out highp vec4 pixel_color;
layout(location = 1) out highp vec4 pixel_more;
void main() { draw_pixel(ivec2(gl_FragCoord.xy), pixel_color, pixel_more); }
)";

// Tells the shader how many cosets a field has, and what beside coefficients.
std::string field_text(const ShaderKind& k) {
  return define("COSETS", k.bcc ? 2 : 1) + define("CORRECTED", k.corrections.has_value()) +
         define("SMOOTH_FALL", k.corrections == CorrectionShape::smooth) + define("MASKED", k.masked) +
         define("HOLES", k.holes);
}

std::string kind_text(const ShaderKind& k) {
  const bool around = k.mode == RenderMode::composite && (k.halves || k.integrals);
  return define("MODE", static_cast<int>(k.mode)) + define("SHADING", k.shading) +
         define("HALVES", k.halves) + define("INTEGRALS", k.integrals) + define("SPLIT", k.split) +
         define("RIPPLE", k.ripple) + define("NORMALISED", k.normalised) +
         define("FIRST_WAVE", number(k.first_wave)) + define("AROUND", around) +
         define("SURFACES", k.surfaces) + define("OBJECTS", k.objects) +
         define("COMBINE", static_cast<int>(k.combine)) + define("CUTS", most_cuts) +
         define("LIGHTS", most_gpu_lights) + define("MOST_SURFACES", most_gpu_surfaces) +
         define("BORDER", brick_border(k.kernel, k.bcc)) +
         define("EDGE", brick_edge + 2 * brick_border(k.kernel, k.bcc)) + field_text(k);
}

} // namespace

int brick_border(const RadialKernel& kernel, bool bcc) {
  constexpr double one_site = 1.5; // in reach of a point half a site from the nearest one
  return kernel.radius / coset_pitch(bcc) > one_site ? 2 : 1;
}

std::string shader_source(const ShaderKind& kind) {
  const bool compute = kind.entry == GpuEntry::compute;
  std::string out = compute ? compute_glsl : raster_glsl;
  if (compute) {
    const std::string edge = std::to_string(compute_edge);
    out += "layout(local_size_x = " + edge + ", local_size_y = " + edge + ") in;\n";
    out += "layout(std430, binding = 1) writeonly buffer Pixels { vec4 pixels[]; };\n";
  }
  out += "precision highp float;\nprecision highp int;\n";
  out += kind_text(kind) + kernel_text(kind.kernel, kind.bcc) + reached_text(kind.kernel, kind.bcc);
  out += compute && kind.sites_in_buffer ? buffer_sites : texture_sites;
  if (!kind.gather.empty()) out += "#define GATHER " + kind.gather + "\n";
  return out + march_body + (compute ? compute_main : fragment_main);
}

std::string over_source(bool from_buffer) {
  std::string out = from_buffer ? compute_glsl : raster_glsl;
  out += "precision highp float;\nprecision highp int;\n";
  out += from_buffer ? "layout(std430, binding = 1) readonly buffer Pixels { vec4 pixels[]; };\n"
                     : "uniform highp sampler2D pixels;\n";
  out += "uniform ivec2 size;\n"
         "layout(location = 0) out vec4 color;\n"
         "void main() {\n"
         "  ivec2 at = ivec2(gl_FragCoord.x, float(size.y) - gl_FragCoord.y);\n";
  out += from_buffer ? "  color = pixels[at.y * size.x + at.x];\n}\n"
                     : "  color = texelFetch(pixels, at, 0);\n}\n";
  return out;
}

std::string merge_source(bool in_buffers, int edge) {
  if (in_buffers)
    return "#version 430\nlayout(local_size_x = " + std::to_string(merge_threads) + ") in;\n" +
           define("EDGE", edge) + merge_buffers;
  std::string out = "#version 330\nprecision highp float;\nprecision highp int;\n" + define("EDGE", edge) +
                    define("LAYERS", layers_at_once);
  std::string sums;
  for (int k = 0; k < layers_at_once; ++k) {
    const std::string n = std::to_string(k);
    out += "uniform highp sampler3D layer" + n + ";\n";
    sums += "  if (table.y > " + n + ") sum += weights[" + n + "] * texelFetch(layer" + n + ", place_in(" +
            n + ", brick, at), 0).r;\n";
  }
  return out + merge_textures + "  float sum = 0.0;\n" + sums + "  site = sum;\n}\n";
}

std::string vertex_source() {
  return std::string(raster_glsl) + "void main() {\n"
                                    "  vec2 corner = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1));\n"
                                    "  gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);\n"
                                    "}\n";
}

} // namespace bccsplat
