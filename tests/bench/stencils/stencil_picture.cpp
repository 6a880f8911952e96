// SPDX-License-Identifier: Apache-2.0
// Draws tile by tile, as the splatter does: four sheets are raised at a time, classified and composited.
#include "tests/bench/stencils/stencil_picture.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <vector>

#include "shade/absorption.h"
#include "shade/preintegrate.h"
#include "splat/sheet/sheet.h"
#include "splat/sheet/sheet_args.h"
#include "splat/tile/sheet_source.h"
#include "splat/tile/tile_rays.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {
namespace {

constexpr int border = 2; // pixels and sheets that fourth-order differences look at
constexpr int at_once = most_raised;
static_assert(at_once + 2 * border <= static_cast<int>(finished_sheets));

// CPU time, not that of a clock as add_lap(): other programs on the machine do not count.
void add_cpu_lap(std::clock_t& from, double& sum) {
  const std::clock_t now = std::clock();
  sum += 1e3 * static_cast<double>(now - from) / CLOCKS_PER_SEC;
  from = now;
}

// How far beyond the domain samples are of use to the pixels of its rays, planes.
double planes_beyond(const StencilView& v, int taps) {
  const double slant = std::max(std::fabs(v.shift[0]), std::fabs(v.shift[1]));
  const double pixel =
      std::max(std::fabs(v.u[0]) + std::fabs(v.u[1]), v.pitch_v * (std::fabs(v.v[0]) + std::fabs(v.v[1])));
  return (border + 0.5) * slant + border * pixel + (0.5 * taps + 1);
}

struct Shot {
  const Scene& scene;
  const StencilView& stencil;
  const SampleSheets& sheets;
  const RaiseRows &across, &down;
  const ClassTable& table;
  const std::vector<std::array<float, 4>>& whole;
  double opacity_stop;
  int taps, halfway;
  bool whole_sheets;
  std::array<int64_t, 2> range; // of sheets
  int plane_blocks;             // per row and column of a tile with its border
};

class StencilTile {
 public:
  StencilTile(const Shot& shot, const PlannedTile& tile, TileMemory& memory, TileScratch& scratch,
              StencilTimes& times)
      : shot_(shot), view_(shot.stencil.view), tile_(tile), m_(memory), scratch_(scratch), times_(times),
        pitch_(raise_block * shot.plane_blocks), plane_floats_(static_cast<size_t>(pitch_ * pitch_) + 64) {}

  void draw(Image& image) {
    clock_ = std::clock();
    prepare();
    add_cpu_lap(clock_, times_.plan);
    for (int64_t k = first_; k <= last_ && open_ > 0; k += at_once) {
      while (raised_ <= k + at_once - 1 + border) {
        raise_sheets(raised_);
        raised_ += at_once;
      }
      add_cpu_lap(clock_, times_.raise);
      const int64_t end = std::min(k + at_once, last_ + 1);
      list_.clear();
      for (int64_t sheet = k; sheet < end; ++sheet) list_.push_back(sheet_args(sheet));
      open_ -= simd_sheet_loops().composite(list_);
      add_cpu_lap(clock_, times_.shade);
    }
    write(image);
    add_cpu_lap(clock_, times_.write);
  }

 private:
  void prepare() {
    m_.prepare_pixels(tile_.width, tile_.height);
    float** const planes[] = {&pixel_.red,   &pixel_.green, &pixel_.blue, &pixel_.alpha,
                              &pixel_.depth, &pixel_.value, &pixel_.time};
    size_t n = 0;
    for (float** p : planes) *p = m_.pixel_plane(n++, tile_.height);
    pixel_.value = pixel_.time = nullptr;
    const TileRays rays =
        make_rays(*shot_.scene.slice, view_, tile_, m_.pixel_pitch, m_.pixel_plane(n, tile_.height), pixel_);
    open_ = rays.open;
    if (open_ == 0) return;
    first_ = std::max(static_cast<int64_t>(std::ceil(rays.low - 0.5)), shot_.range[0]);
    last_ = std::min(static_cast<int64_t>(std::floor(rays.high + 0.5)), shot_.range[1]);
    raised_ = first_ - border;
    // What is never raised is looked at with weight 0, and must be a number.
    if (scratch_.planes.capacity() < finished_sheets * plane_floats_) {
      scratch_.planes.reserve(finished_sheets * plane_floats_);
      std::fill_n(scratch_.planes.data(), finished_sheets * plane_floats_, 0.0f);
    }
  }

  [[nodiscard]] float* plane(int64_t k) const {
    return scratch_.planes.data() + finished_slot(k) * plane_floats_;
  }

  SheetArgs sheet_args(int64_t k) const {
    const Slice& slice = *shot_.scene.slice;
    SheetArgs a{.tile = {.x = tile_.x,
                         .y = tile_.y,
                         .width = tile_.width,
                         .height = tile_.height,
                         .pitch = m_.pixel_pitch,
                         .plane_pitch = pitch_},
                .field = {.base = slice.base, .above_air = slice.base - slice.air},
                .classes = {.table = &shot_.table,
                            .whole = shot_.whole.data(),
                            .stop = static_cast<float>(shot_.opacity_stop)},
                .shading = {.on = true, .lights = &shot_.scene.lights},
                .pixel = pixel_};
    const auto values = [&](int64_t sheet) { return plane(sheet) + border * pitch_ + border; };
    set_sheet(a, slice, view_, k, false, border, [&](int64_t sheet, size_t) { return values(sheet); });
    // The slant is a part of the basis, so that no pixel has to take it off.
    GradientBasis& b = a.basis;
    for (size_t n = 0; n < 3; ++n) {
      b.x[n] -= b.slant_x * b.z[n];
      b.y[n] -= b.slant_y * b.z[n];
    }
    b.slant_x = b.slant_y = 0;
    if (shot_.halfway > 0) set_halfway(a, view_, k, shot_.halfway, values);
    return a;
  }

  // The samples that the pixels of a domain's rays may look at on sheets k .. k + at_once - 1.
  struct Needed {
    std::array<double, 2> low, high;
  };
  [[nodiscard]] Needed needed(int64_t k) const {
    const StencilView& s = shot_.stencil;
    const Slice& slice = *shot_.scene.slice;
    const double plane = slice.lattice.plane_distance();
    Needed n;
    for (size_t a = 0; a < 2; ++a) {
      const double pitch = a == 0 ? 1 : s.pitch_v;
      const auto& map = a == 0 ? s.u : s.v;
      const double near = s.origin[a] + static_cast<double>(k) * s.shift[a],
                   far = near + (at_once - 1) * s.shift[a];
      const double beyond =
          (border + 0.5) * std::fabs(s.shift[a]) / pitch + border * (std::fabs(map[0]) + std::fabs(map[1]));
      const double begin = slice.domain_begin[s.axes[a]] / plane, end = slice.domain_end[s.axes[a]] / plane;
      n.low[a] = (begin - std::max(near, far)) / pitch - beyond;
      n.high[a] = (end - std::min(near, far)) / pitch + beyond;
    }
    return n;
  }

  // The smallest and largest of map[0] i + map[1] j over a block of pixels of the plane.
  [[nodiscard]] std::array<double, 2> extent(const std::array<double, 2>& map, int i, int j) const {
    constexpr double half = 0.5 * (raise_block - 1);
    const double middle = map[0] * (left() + i + half) + map[1] * (top() + j + half);
    const double reach = half * (std::fabs(map[0]) + std::fabs(map[1]));
    return {middle - reach, middle + reach};
  }
  [[nodiscard]] int left() const { return tile_.x - border; }
  [[nodiscard]] int top() const { return tile_.y - border; }

  // The blocks of a strip of pixel columns, and the samples that these are raised from.
  struct Strip {
    int x = 0;
    std::vector<int> blocks; // rows of pixels that they begin at
    double low_u = 1e300, high_u = -1e300, low_v = 1e300, high_v = -1e300;
  };
  void find_strips(int64_t k) {
    const StencilView& s = shot_.stencil;
    const Needed n = needed(k);
    strips_.resize(shot_.plane_blocks);
    for (int x = 0; x < pitch_; x += raise_block) {
      Strip& strip = strips_[x / raise_block];
      strip.x = x, strip.blocks.clear();
      strip.low_u = strip.low_v = 1e300, strip.high_u = strip.high_v = -1e300;
      for (int y = 0; y < pitch_; y += raise_block) {
        const auto u = extent(s.u, x, y), v = extent(s.v, x, y);
        if (u[1] < n.low[0] || u[0] > n.high[0] || v[1] < n.low[1] || v[0] > n.high[1]) continue;
        strip.blocks.push_back(y);
        strip.low_u = std::min(strip.low_u, u[0]), strip.high_u = std::max(strip.high_u, u[1]);
        strip.low_v = std::min(strip.low_v, v[0]), strip.high_v = std::max(strip.high_v, v[1]);
      }
    }
  }

  // Makes the samples that the strips need.
  void fill_window(int64_t k) {
    Strip all;
    for (const Strip& s : strips_) {
      all.low_u = std::min(all.low_u, s.low_u), all.high_u = std::max(all.high_u, s.high_u);
      all.low_v = std::min(all.low_v, s.low_v), all.high_v = std::max(all.high_v, s.high_v);
    }
    if (all.low_u > all.high_u) return;
    const int taps = shot_.taps / 2 + 1; // one more, for places are rounded
    const int u = static_cast<int>(std::floor(all.low_u)) - taps,
              v = static_cast<int>(std::floor(all.low_v)) - taps;
    const int width = static_cast<int>(std::ceil(all.high_u)) + taps + 2 - u;
    rows_ = static_cast<int>(std::ceil(all.high_v)) + taps + shot_.stencil.phases_v - v;
    row_floats_ = (width + 31) / 32 * 32;
    const size_t each = static_cast<size_t>(row_floats_) * rows_,
                 floats = at_once * each + 2 * SampleSheets::spare;
    if (scratch_.window.capacity() < floats) {
      scratch_.window.reserve(floats);
      std::fill_n(scratch_.window.data(), floats, 0.0f);
    }
    for (size_t n = 0; n < at_once; ++n) {
      samples_[n] = {k, u, v, scratch_.window.data() + SampleSheets::spare + n * each};
      shot_.sheets.fill_window(k + static_cast<int64_t>(n), width, rows_, row_floats_, samples_[n]);
    }
  }

  // Raises sheets k .. k + at_once - 1, a strip of pixel columns at a time.
  void raise_sheets(int64_t k) {
    find_strips(k);
    if (shot_.whole_sheets) {
      rows_ = shot_.sheets.height(), row_floats_ = shot_.sheets.pitch();
      for (size_t n = 0; n < at_once; ++n) samples_[n] = shot_.sheets.sheet(k + static_cast<int64_t>(n));
    } else {
      add_cpu_lap(clock_, times_.raise);
      fill_window(k);
      add_cpu_lap(clock_, times_.fill);
    }
    for (const Strip& strip : strips_)
      if (!strip.blocks.empty()) raise_strip(k, strip);
  }

  void raise_strip(int64_t k, const Strip& strip) {
    const int x = strip.x;
    const StencilView& s = shot_.stencil;
    // A sixty-fourth more on either side, for places are rounded.
    const int v0 = static_cast<int>(std::floor(strip.low_v - 0.02)) - (shot_.taps / 2 - 1),
              v1 = static_cast<int>(std::floor(strip.high_v + 0.02)) + shot_.taps / 2 + 1;
    const int rows = (v1 - v0 + raise_block - 1) / raise_block * raise_block, strip_pitch = rows + 48;
    const size_t each = static_cast<size_t>(strip_pitch) * raise_block;
    if (scratch_.strip.capacity() < at_once * each) {
      scratch_.strip.reserve(at_once * each);
      std::fill_n(scratch_.strip.data(), at_once * each, 0.0f);
    }
    RaiseBlock b;
    b.taps = shot_.taps, b.sheets = at_once;
    b.out_pitch = strip_pitch;
    for (int r0 = 0; r0 < rows; r0 += raise_block) {
      for (int r = 0; r < raise_block; ++r) {
        const int v = v0 + r0 + r;
        const auto start = shot_.across.at(s.slope_u() * left() + s.row_u() * v);
        set_row(b, r, start, x);
        for (size_t n = 0; n < at_once; ++n) {
          const int row = std::clamp(v - samples_[n].first_v, 0, rows_ - 1);
          b.source[n][r] = samples_[n].samples + static_cast<std::ptrdiff_t>(row) * row_floats_ +
                           start.whole - samples_[n].first_u;
        }
      }
      for (size_t n = 0; n < at_once; ++n) b.out[n] = scratch_.strip.data() + n * each + r0;
      raise_turned(b);
    }
    b.out_pitch = pitch_;
    for (int r = 0; r < raise_block; ++r) {
      const auto start = shot_.down.at(s.v[0] * (left() + x + r) + s.v[1] * top());
      set_row(b, r, start, 0);
      for (size_t n = 0; n < at_once; ++n)
        b.source[n][r] = scratch_.strip.data() + n * each + (r * strip_pitch) + start.whole - v0;
    }
    for (const int y : strip.blocks) {
      RaiseBlock at = b;
      for (int r = 0; r < raise_block; ++r) at.sample[r] += y, at.weight[r] += y;
      for (int n = 0; n < at_once; ++n)
        at.out[n] = plane(k + n) + static_cast<std::ptrdiff_t>(y) * pitch_ + x;
      raise_turned(at);
    }
  }

  static void set_row(RaiseBlock& b, int r, const RaiseRows::Start& start, int first) {
    b.sample[r] = start.table->sample.data() + first;
    b.weight[r] = start.table->weight.data() + first;
    b.weight_pitch = start.table->pitch;
  }

  void write(Image& image) const {
    for (int y = 0; y < tile_.height; ++y) {
      const size_t row = static_cast<size_t>(y) * m_.pixel_pitch;
      float* rgba = image.rgba.at(tile_.x, tile_.y + y);
      for (size_t x = 0; x < static_cast<size_t>(tile_.width); ++x, rgba += 4)
        rgba[0] = pixel_.red[row + x], rgba[1] = pixel_.green[row + x], rgba[2] = pixel_.blue[row + x],
        rgba[3] = pixel_.alpha[row + x];
    }
  }

  const Shot& shot_;
  const SheetView& view_;
  const PlannedTile& tile_;
  TileMemory& m_;
  TileScratch& scratch_;
  StencilTimes& times_;
  int pitch_; // and rows of a plane
  size_t plane_floats_;
  PixelPlanes pixel_;
  std::vector<SheetArgs> list_;
  std::vector<Strip> strips_;
  std::array<SampleSheet, at_once> samples_; // of the sheets that are raised
  int rows_ = 0, row_floats_ = 0;            // of samples
  std::clock_t clock_ = 0;
  int64_t first_ = 0, last_ = -1, raised_ = 0;
  int open_ = 0;
};

} // namespace

void StencilPicture::prepare_sites(int margin) {
  if (margin_ >= margin && sites_.axes == view_.axes) return;
  prepare_ms_ = 1e3 * cpu_seconds([&] { sites_ = make_site_array(*scene_.slice, view_.axes, margin); });
  margin_ = margin;
}

void StencilPicture::draw(Quality quality, Image& image) {
  times_ = {};
  auto clock = std::clock();
  const QualitySettings settings = quality_settings(quality);
  const Slice& slice = *scene_.slice;
  view_ =
      make_stencil_view(slice, resolve_camera(scene_.camera), image.width, image.height, settings.sheet_step);
  const SheetView& view = view_.view;
  const double unit = scene_.function.unit_distance > 0 ? scene_.function.unit_distance : mean_voxel(slice);
  ClassTable table = make_class_table(scene_.function, slice.bounds[0], slice.bounds[1], slice.base, unit,
                                      settings.table_entries);
  const double change = settings.sheet_step * change_per_unit(slice, *scene_.points);
  const bool integrals = narrowness(scene_.function, table, change, view.step_world) >= narrow_function;
  if (integrals) table.integrals = integrate_values(scene_.function, table);
  std::vector<std::array<float, 4>> whole = table.entry;
  const auto path = static_cast<float>(length(view.lattice_to_world.vector(view.ez)));
  for (auto& entry : whole) entry[3] = absorbed(entry[3] * path);

  const auto range = sheet_range(slice, view);
  const double beyond = planes_beyond(view_, settings_.taps);
  const double reach = slice.kernel.space.radius / slice.lattice.plane_distance();
  prepare_sites(
      static_cast<int>(std::ceil(std::max(beyond, (border + 1) * std::fabs(view_.shift[2])) + reach)) + 3);
  const int side = std::max(image.width, image.height), count = (side + settings_.tile - 1) / settings_.tile,
            size = (side + count - 1) / count;
  const int blocks = (size + 2 * border + raise_block - 1) / raise_block;
  across_.prepare(settings_.taps, view_.density_u, view_.slope_u(), blocks * raise_block);
  down_.prepare(settings_.taps, view_.density_v, view_.v[1], blocks * raise_block);
  const KernelForm form =
      settings.sheet_step >= settings.flat_kernel ? KernelForm::flat_form : KernelForm::exact;
  sheets_.begin(slice, view_, sites_, form, range[0] - border, range[1] + border, beyond);
  add_cpu_lap(clock, times_.plan);
  if (settings_.whole_sheets) sheets_.fill();
  add_cpu_lap(clock, times_.fill);

  const Shot shot{scene_,
                  view_,
                  sheets_,
                  across_,
                  down_,
                  table,
                  whole,
                  RenderOptions{}.opacity_stop,
                  settings_.taps,
                  integrals ? halfway_sheets(view) : 0,
                  settings_.whole_sheets,
                  range,
                  blocks};
  for (int y = 0; y < image.height; y += size)
    for (int x = 0; x < image.width; x += size) {
      PlannedTile tile;
      tile.x = x, tile.y = y;
      tile.width = std::min(size, image.width - x), tile.height = std::min(size, image.height - y);
      StencilTile(shot, tile, memory_, scratch_, times_).draw(image);
    }
}

} // namespace bccsplat::bench
