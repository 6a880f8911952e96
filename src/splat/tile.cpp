#include "splat/tile.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "kernel/cc_kernel.h"
#include "splat/sheet.h"
#include "splat/surface.h"

namespace bccsplat {
namespace {

using Clock = std::chrono::steady_clock;
constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

// Adds the time since `from` to `sum` and starts the next stage.
void lap(Clock::time_point& from, double& sum) {
  const auto now = Clock::now();
  sum += std::chrono::duration<double, std::milli>(now - from).count();
  from = now;
}

class Tile {
 public:
  Tile(const TileJob& job, const PlannedTile& tile, TileMemory& memory, SplatStats& stats)
      : scene_(*job.scene), options_(*job.options), plan_(*job.plan), job_(job), tile_(tile), m_(memory),
        stats_(stats), view_(*scene_.view), kernels_(options_.scalar ? scalar_kernels() : simd_kernels()),
        sheet_kernels_(options_.scalar ? scalar_sheet_kernels() : simd_sheet_kernels()),
        time_(*scene_.slice) {
    const bool shaded = options_.mode == RenderMode::composite && options_.shading;
    analytic_ = shaded && options_.gradient == GradientMethod::analytic;
    differences_ = shaded && !analytic_ ? plan_.lead : 0;
    m_.prepare(plan_, tile.width, tile.height, analytic_);
    prepare_pixels();
  }

  TilePixels draw() {
    if (first_ <= last_) march();
    return finish();
  }

 private:
  void prepare_pixels() {
    float** const planes[] = {&pixel_.red,   &pixel_.green, &pixel_.blue, &pixel_.alpha,
                              &pixel_.depth, &pixel_.value, &pixel_.time};
    size_t n = 0;
    for (float** p : planes) *p = m_.pixel_plane(n++, tile_.height);
    float *enter = m_.pixel_plane(n++, tile_.height), *leave = m_.pixel_plane(n++, tile_.height);
    float* path = m_.pixel_plane(n++, tile_.height);
    float *vx = m_.pixel_plane(n++, tile_.height), *vy = m_.pixel_plane(n++, tile_.height),
          *vz = m_.pixel_plane(n++, tile_.height);
    pixel_.enter = enter, pixel_.leave = leave, pixel_.path = path;
    pixel_.view_x = vx, pixel_.view_y = vy, pixel_.view_z = vz;
    if (!options_.with_value) pixel_.value = nullptr;
    if (!options_.with_time) pixel_.time = nullptr;

    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (int y = 0; y < tile_.height; ++y)
      for (int x = 0; x < m_.pixel_pitch; ++x) {
        const auto p = static_cast<size_t>(y) * static_cast<size_t>(m_.pixel_pitch) + static_cast<size_t>(x);
        pixel_.depth[p] = infinity;
        enter[p] = infinity, leave[p] = -infinity; // of pixels beside the tile, too
        if (x >= tile_.width) continue;
        const double i = tile_.x + x, j = tile_.y + y;
        const auto [k0, k1] = ray_interval(*scene_.slice, view_, i, j);
        const Vec3 ray = view_.lattice_to_world.vector(view_.ray(i, j));
        const double step = length(ray);
        path[p] = static_cast<float>(step);
        vx[p] = static_cast<float>(-ray[0] / step), vy[p] = static_cast<float>(-ray[1] / step);
        vz[p] = static_cast<float>(-ray[2] / step);
        if (!(k0 < k1)) continue;
        enter[p] = static_cast<float>(k0), leave[p] = static_cast<float>(k1);
        low = std::min(low, k0), high = std::max(high, k1);
        ++open_;
      }
    if (options_.mode == RenderMode::maximum)
      std::fill_n(pixel_.red, static_cast<size_t>(m_.pixel_pitch) * static_cast<size_t>(tile_.height),
                  -infinity);
    if (!(low <= high)) return;
    // Surfaces lie between two sheets, of which one may stand outside the domain; slabs reach half a sheet
    // beyond it.
    const bool surface = options_.mode == RenderMode::isosurface;
    first_ = static_cast<int64_t>(surface ? std::floor(low) : std::ceil(low - 0.5));
    last_ = static_cast<int64_t>(surface ? std::ceil(high) : std::floor(high + 0.5));
    first_ = std::max({first_, view_.first_sheet(), plan_.first_sheet - plan_.lead});
    last_ = std::min(last_, plan_.last_sheet + plan_.lead);
  }

  void march() {
    const int64_t wanted_first = std::max(first_ - differences_, view_.first_sheet());
    const int64_t wanted_last = last_ + differences_;
    const int64_t first_slab = std::max(plan_.first_slab, wanted_first - plan_.after);
    const int64_t last_slab = std::min(plan_.last_slab, wanted_last + plan_.before);
    const bool keep_empty = plan_.air_visible || (options_.disable_skips & skip_empty_sheets);
    size_t next_brick = 0;
    int64_t dirty = first_slab - plan_.before - 1; // the last sheet that holds anything
    auto clock = Clock::now();
    for (int64_t s = first_slab; s <= last_slab && open_ > 0; ++s) {
      if (((s - first_slab) & 15) == 0) job_.context->progress.check();
      while (next_brick < tile_.bricks.size() && plan_.bricks[tile_.bricks[next_brick]].first_slab <= s) {
        activate(tile_.bricks[next_brick++], first_slab, last_slab);
        lap(clock, stats_.ms_transform);
      }
      const size_t bin = bin_of(s);
      SplatRecord* const records = m_.bins[bin].data();
      if (m_.bin_end[bin] != records) {
        splat_bin(s, records, static_cast<size_t>(m_.bin_end[bin] - records));
        m_.bin_end[bin] = records;
        dirty = s + plan_.after;
        lap(clock, stats_.ms_splat);
      }
      // Sheet k is complete.
      const int64_t k = s - plan_.before;
      filled_[static_cast<size_t>(k & 7)] = k <= dirty;
      if (k <= dirty) extract(k);
      const int64_t ready = k - differences_; // differences look at the sheets behind
      if (ready >= first_ && ready <= last_) {
        if (!keep_empty && options_.mode != RenderMode::isosurface &&
            !filled_[static_cast<size_t>(ready & 7)])
          ++stats_.sheets_skipped;
        else
          process(ready);
      }
      lap(clock, stats_.ms_shade);
    }
  }

  void activate(uint32_t planned, int64_t first_slab, int64_t last_slab) {
    const PlannedBrick& b = plan_.bricks[planned];
    const SplatBrick& points = scene_.points->bricks[b.brick];
    const bool occlusion = !(options_.disable_skips & skip_occlusion) && closed_ > 0;
    if (occlusion) {
      sum_open_pixels();
      if (hidden(b.rect)) {
        stats_.points_occluded += points.count;
        return;
      }
    }
    TransformArgs t;
    t.position = scene_.points->position.data() + points.first;
    t.coefficient = scene_.points->coefficient.data() + points.first;
    t.count = points.count;
    t.frame = &b.frame;
    t.isotropic = plan_.isotropic;
    t.lateral = plan_.lateral.data();
    t.half_x = plan_.half_x.data(), t.half_y = plan_.half_y.data();
    t.columns = plan_.columns.data(), t.rows = plan_.rows.data();
    t.base_slab = plan_.first_slab;
    t.first_slab = first_slab, t.last_slab = last_slab;
    t.tile_x = tile_.x - plan_.border, t.tile_y = tile_.y - plan_.border;
    t.width = m_.width, t.height = m_.height;
    t.bin_end = m_.bin_end.data(), t.bin_mask = m_.bin_mask();
    const int64_t from = std::max(first_slab, b.first_slab), to = std::min(last_slab, b.last_slab);
    for (int64_t s = from; s <= to; ++s) m_.make_room(bin_of(s), points.count + 1);
    const size_t trash = m_.bins.size() - 1;
    m_.bin_end[trash] = m_.bins[trash].data();
    m_.make_room(trash, points.count + 16);
    if (occlusion) t.open_sum = m_.open_sum.data(), t.around = plan_.border;
    const TransformCounts counts = kernels_.transform(t);
    stats_.points_splatted += counts.accepted;
    stats_.points_occluded += counts.occluded;
  }

  [[nodiscard]] size_t bin_of(int64_t slab) const {
    return static_cast<size_t>(slab - plan_.first_slab) & m_.bin_mask();
  }

  // Brings the sums of open pixels up to date when enough have closed since.
  void sum_open_pixels() {
    if (summed_closed_ > 0 && (closed_ - summed_closed_) * 16 < open_) return;
    summed_closed_ = closed_;
    const int pitch = m_.width + 1;
    m_.open_sum.assign(static_cast<size_t>(pitch * (m_.height + 1)), 0);
    for (int y = 0; y < m_.height; ++y) {
      int32_t* row = m_.open_sum.data() + (y + 1) * pitch;
      int32_t sum = 0;
      const int py = y - plan_.border;
      for (int x = 0; x < m_.width; ++x) {
        const int px = x - plan_.border;
        if (px >= 0 && py >= 0 && px < tile_.width && py < tile_.height) {
          const auto p =
              static_cast<size_t>(py) * static_cast<size_t>(m_.pixel_pitch) + static_cast<size_t>(px);
          sum += pixel_.alpha[p] < stop() && pixel_.enter[p] <= pixel_.leave[p];
        }
        row[x + 1] = row[x + 1 - pitch] + sum;
      }
    }
  }

  // Whether every pixel of the tile inside the rectangle of the picture, and around it, is finished.
  [[nodiscard]] bool hidden(const std::array<int, 4>& rect) const {
    const int around = plan_.border, left = tile_.x - plan_.border, top = tile_.y - plan_.border;
    const auto sum = [&](int y, int x) {
      y = std::clamp(y - top, 0, m_.height), x = std::clamp(x - left, 0, m_.width);
      return m_.open_sum[static_cast<size_t>(y * (m_.width + 1) + x)];
    };
    const int x0 = rect[0] - around, y0 = rect[1] - around, x1 = rect[2] + around, y1 = rect[3] + around;
    return sum(y1, x1) - sum(y1, x0) - sum(y0, x1) + sum(y0, x0) == 0;
  }

  void splat_bin(int64_t s, const SplatRecord* records, size_t count) {
    const auto n = static_cast<size_t>(s - plan_.first_slab);
    const SlabLanes lanes = plan_.lanes(s);
    SplatArgs a;
    a.record = records, a.count = count;
    a.lanes = &lanes, a.kernel = job_.kernel;
    a.depth2 = static_cast<float>(plan_.depth2);
    a.isotropic = plan_.isotropic, a.spare = plan_.spare;
    a.columns = plan_.columns[n], a.rows = plan_.rows[n];
    for (size_t q = 0; q < (analytic_ ? 4u : 1u); ++q) a.ring[q] = m_.ring_origin(q);
    a.groups = plan_.groups, a.group_floats = m_.group_floats;
    a.pitch = m_.ring_pitch, a.width = m_.width, a.height = m_.height;
    kernels_.splat(a);
    stats_.contributions += count * static_cast<uint64_t>(plan_.sheets) * static_cast<uint64_t>(a.columns) *
                            static_cast<uint64_t>(a.rows);
  }

  void extract(int64_t k) {
    const auto slot = static_cast<size_t>(((k % plan_.sheets) + plan_.sheets) % plan_.sheets);
    ExtractArgs e;
    e.lane = static_cast<int>(slot & 3);
    e.pitch = m_.ring_pitch, e.width = m_.width, e.height = m_.height, e.plane_pitch = m_.plane_pitch;
    for (size_t q = 0; q < (analytic_ ? 4u : 1u); ++q) {
      e.ring = m_.ring_origin(q) + (slot >> 2) * m_.group_floats;
      e.plane = m_.plane_origin(k, q);
      kernels_.extract(e);
    }
    if (scene_.slice->kernel.normalised) normalise(k);
  }

  // Divides a sheet by the lattice sum of the weights (kernels that ask for it).
  void normalise(int64_t k) {
    float* plane = m_.plane_origin(k, 0);
    for (int y = 0; y < m_.height; ++y)
      for (int x = 0; x < m_.width; ++x) {
        float& v = plane[y * m_.plane_pitch + x];
        if (v == 0) continue;
        const Vec3 p =
            view_.sample(tile_.x - plan_.border + x, tile_.y - plan_.border + y, static_cast<double>(k));
        const Slice& slice = *scene_.slice;
        v /= static_cast<float>(lattice_sum(slice.kernel, slice.lattice.bcc, p[0], p[1], p[2]));
      }
  }

  [[nodiscard]] const float* sheet_plane(int64_t k, size_t quantity) const {
    const float* origin = filled_[static_cast<size_t>(k & 7)] ? m_.plane_origin(k, quantity)
                                                              : m_.zero_plane.data() + plane_margin;
    return origin + plan_.border * m_.plane_pitch + plan_.border;
  }

  [[nodiscard]] float stop() const { return static_cast<float>(options_.opacity_stop); }

  void process(int64_t k) {
    if (options_.mode == RenderMode::isosurface) {
      find_surface(k);
      return;
    }
    SheetArgs a;
    a.k = static_cast<float>(k);
    if (k == view_.first_sheet()) a.front = 2;
    a.x = tile_.x, a.y = tile_.y, a.width = tile_.width, a.height = tile_.height, a.pitch = m_.pixel_pitch;
    a.value = sheet_plane(k, 0);
    a.plane_pitch = m_.plane_pitch;
    a.shading = options_.shading, a.central = differences_ == 1, a.fourth_order = differences_ == 2;
    a.air = scene_.slice->air;
    a.stop = options_.opacity_stop < 1 ? stop() : 2.0f;
    a.table = scene_.table, a.lights = scene_.lights;
    a.pixel = pixel_;
    if (differences_ > 0) {
      // Nothing is sampled before the first sheet in front of an eye: fewer neighbours there.
      const auto front = std::min<int64_t>(k - view_.first_sheet(), differences_);
      a.after = sheet_plane(k + 1, 0), a.before = front > 0 ? sheet_plane(k - 1, 0) : a.value;
      a.depth_scale = front == 2 ? 8.0f / 12 : front == 1 ? 0.5f : 1.0f;
      a.after2 = a.before2 = a.value;
      if (front == 2)
        a.after2 = sheet_plane(k + 2, 0), a.before2 = sheet_plane(k - 2, 0), a.depth_scale2 = -1.0f / 12;
    } else if (analytic_) {
      a.sum_i = sheet_plane(k, 1), a.sum_j = sheet_plane(k, 2), a.sum_k = sheet_plane(k, 3);
    }
    if (differences_ > 0 || analytic_) set_basis(k, a.basis);
    if (scene_.slice->has_holes) a.hole = find_holes(k);
    if (pixel_.time) {
      const double scale = view_.scale(static_cast<double>(k));
      a.time = {static_cast<float>(time_.at(view_.sample(0, 0, static_cast<double>(k)))),
                static_cast<float>(scale * dot(time_.gradient, view_.ex)),
                static_cast<float>(scale * dot(time_.gradient, view_.ey)), 0};
    }
    if (options_.mode == RenderMode::xray) {
      sheet_kernels_.integrate(a);
    } else if (options_.mode == RenderMode::maximum) {
      sheet_kernels_.maximum(a);
    } else if (job_.stack) {
      add_sheet(a, job_.weight, *job_.stack, job_.group);
    } else {
      const int closed = sheet_kernels_.composite(a);
      closed_ += closed, open_ -= closed;
    }
  }

  void set_basis(int64_t k, GradientBasis& basis) const {
    const Affine3 to_lattice = view_.lattice_to_world.inverse();
    const double scale = view_.scale(static_cast<double>(k));
    Vec3 x, y, z;
    if (differences_ > 0) {
      x = to_lattice.transposed((1 / scale) * view_.gx);
      y = to_lattice.transposed((1 / scale) * view_.gy);
      z = to_lattice.transposed((1 / view_.step) * view_.normal);
      basis.slant_x = static_cast<float>(dot(view_.gx, view_.ez) / scale);
      basis.slant_y = static_cast<float>(dot(view_.gy, view_.ez) / scale);
      basis.slant_per_x = basis.slant_per_y = view_.perspective ? static_cast<float>(1 / scale) : 0.0f;
    } else {
      // d phi / dp = phi'(u) du/dp with u = 1 - |p - site|^2 / R^2.
      const double radius = scene_.slice->kernel.space.radius;
      const double factor = -2 / (radius * radius);
      x = to_lattice.transposed((factor * scale) * view_.ex);
      y = to_lattice.transposed((factor * scale) * view_.ey);
      z = to_lattice.transposed((factor * view_.step) * view_.normal);
    }
    for (size_t a = 0; a < 3; ++a) {
      basis.x[a] = static_cast<float>(x[a]);
      basis.y[a] = static_cast<float>(y[a]);
      basis.z[a] = static_cast<float>(z[a]);
    }
  }

  const uint8_t* find_holes(int64_t k) {
    for (int y = 0; y < tile_.height; ++y)
      for (int x = 0; x < tile_.width; ++x) {
        const auto p = static_cast<size_t>(y) * static_cast<size_t>(m_.pixel_pitch) + static_cast<size_t>(x);
        const float f = static_cast<float>(k);
        const bool inside = f + 0.5f > pixel_.enter[p] && f - 0.5f < pixel_.leave[p];
        m_.hole.data()[p] =
            inside && scene_.slice->is_hole(view_.sample(tile_.x + x, tile_.y + y, static_cast<double>(k)));
      }
    return m_.hole.data();
  }

  // Surfaces between the sheets k - 1 and k.
  void find_surface(int64_t k) {
    if (k - 1 < first_) return;
    const float target = static_cast<float>(options_.iso_value - static_cast<double>(scene_.slice->air));
    const bool filled = filled_[static_cast<size_t>(k & 7)] || filled_[static_cast<size_t>((k - 1) & 7)];
    if (!filled && !(options_.disable_skips & skip_empty_sheets)) {
      ++stats_.sheets_skipped;
      return;
    }
    CrossingArgs c;
    c.k = static_cast<float>(k), c.target = target;
    c.width = tile_.width, c.height = tile_.height, c.pitch = m_.pixel_pitch;
    c.before = sheet_plane(k - 1, 0), c.value = sheet_plane(k, 0), c.plane_pitch = m_.plane_pitch;
    c.alpha = pixel_.alpha, c.enter = pixel_.enter, c.leave = pixel_.leave;
    m_.crossings.resize(static_cast<size_t>(tile_.width * tile_.height));
    c.found = m_.crossings.data();
    const size_t found = sheet_kernels_.crossings(c);
    if (found == 0) return;
    std::vector<Crossing> crossings;
    crossings.reserve(found);
    for (size_t n = 0; n < found; ++n) {
      const int x = static_cast<int>(c.found[n] & 0xffff), y = static_cast<int>(c.found[n] >> 16);
      const std::ptrdiff_t at = y * m_.plane_pitch + x;
      crossings.push_back({tile_.x + x, tile_.y + y, static_cast<double>(k - 1), static_cast<double>(k),
                           static_cast<double>(c.before[at]), static_cast<double>(c.value[at])});
    }
    const auto hits = refine_crossings(*scene_.slice, view_, options_.iso_value, crossings);
    const auto& color =
        scene_.table->entry[static_cast<size_t>(scene_.table->index(static_cast<float>(options_.iso_value)))];
    for (size_t n = 0; n < hits.size(); ++n) {
      const auto p = static_cast<size_t>(crossings[n].j - tile_.y) * static_cast<size_t>(m_.pixel_pitch) +
                     static_cast<size_t>(crossings[n].i - tile_.x);
      const double tolerance = 1e-5;
      if (hits[n].k < static_cast<double>(pixel_.enter[p]) - tolerance ||
          hits[n].k > static_cast<double>(pixel_.leave[p]) + tolerance)
        continue;
      if (scene_.slice->has_holes && scene_.slice->is_hole(hits[n].position)) continue;
      paint(p, color, 1.0f, hits[n].gradient, crossings[n].i, crossings[n].j);
      pixel_.depth[p] = static_cast<float>(hits[n].k);
      if (pixel_.value) pixel_.value[p] = static_cast<float>(options_.iso_value);
      if (pixel_.time) pixel_.time[p] = static_cast<float>(time_.at(hits[n].position));
      ++closed_, --open_;
    }
  }

  void paint(size_t p, const std::array<float, 4>& color, float alpha, const Vec3& gradient, int i, int j) {
    Shading lit{{1, 1, 1}, {}};
    if (options_.shading) lit = shade(*scene_.lights, gradient, to_viewer(view_, i, j));
    float* const out[3] = {&pixel_.red[p], &pixel_.green[p], &pixel_.blue[p]};
    for (size_t c = 0; c < 3; ++c)
      *out[c] = alpha * (color[c] * static_cast<float>(lit.scale[c]) + static_cast<float>(lit.highlight[c]));
    pixel_.alpha[p] = alpha;
  }

  TilePixels finish() {
    const auto clock = Clock::now();
    for (int y = 0; y < tile_.height; ++y)
      for (int x = 0; x < tile_.width; ++x) {
        const auto p = static_cast<size_t>(y) * static_cast<size_t>(m_.pixel_pitch) + static_cast<size_t>(x);
        if (options_.mode == RenderMode::xray)
          finish_xray(p);
        else if (options_.mode == RenderMode::maximum)
          finish_maximum(p, x, y);
        else if (options_.mode == RenderMode::composite)
          finish_composite(p);
        if (options_.mode == RenderMode::isosurface && !(pixel_.alpha[p] > 0)) {
          if (pixel_.value) pixel_.value[p] = nan_value;
          if (pixel_.time) pixel_.time[p] = nan_value;
        }
      }
    stats_.ms_shade += std::chrono::duration<double, std::milli>(Clock::now() - clock).count();
    return {tile_.x,      tile_.y,     tile_.width,  tile_.height, m_.pixel_pitch, pixel_.red,
            pixel_.green, pixel_.blue, pixel_.alpha, pixel_.depth, pixel_.value,   pixel_.time};
  }

  void finish_composite(size_t p) {
    const float alpha = pixel_.alpha[p];
    if (pixel_.value) pixel_.value[p] = alpha > 0 ? pixel_.value[p] / alpha : nan_value;
    if (pixel_.time) pixel_.time[p] = alpha > 0 ? pixel_.time[p] / alpha : nan_value;
  }

  void finish_xray(size_t p) {
    const bool inside = pixel_.enter[p] < pixel_.leave[p];
    const float sum = pixel_.red[p];
    pixel_.green[p] = pixel_.blue[p] = sum;
    if (pixel_.value) pixel_.value[p] = inside ? sum : nan_value;
    if (pixel_.time) pixel_.time[p] = pixel_.alpha[p] > 0 ? pixel_.time[p] / pixel_.alpha[p] : nan_value;
    pixel_.alpha[p] = inside ? 1.0f : 0.0f;
  }

  void finish_maximum(size_t p, int x, int y) {
    const float value = pixel_.red[p], k = pixel_.depth[p];
    pixel_.red[p] = 0, pixel_.depth[p] = infinity;
    if (!(value > -infinity)) {
      if (pixel_.value) pixel_.value[p] = nan_value;
      if (pixel_.time) pixel_.time[p] = nan_value;
      return;
    }
    const auto& entry = scene_.table->entry[static_cast<size_t>(scene_.table->index(value))];
    const float alpha = absorbed(entry[3] * scene_.table->unit_distance);
    const int i = tile_.x + x, j = tile_.y + y;
    const Vec3 position = view_.sample(i, j, static_cast<double>(k));
    Vec3 gradient{};
    if (options_.shading) {
      float unused;
      field_at(*scene_.slice, {&position, 1}, {&unused, 1}, {&gradient, 1});
      gradient = view_.lattice_to_world.inverse().transposed(gradient);
    }
    paint(p, entry, alpha, gradient, i, j);
    if (alpha >= 0.5f) pixel_.depth[p] = k;
    if (pixel_.value) pixel_.value[p] = value;
    if (pixel_.time) pixel_.time[p] = static_cast<float>(time_.at(position));
  }

  const SplatScene& scene_;
  const SplatOptions& options_;
  const SplatPlan& plan_;
  const TileJob& job_;
  const PlannedTile& tile_;
  TileMemory& m_;
  SplatStats& stats_;
  const SheetView& view_;
  const SplatKernels& kernels_;
  const SheetKernels& sheet_kernels_;
  TimeField time_;
  bool analytic_ = false;
  int differences_ = 0; // neighbours on either side that gradients look at
  PixelPlanes pixel_;
  int64_t first_ = 0, last_ = -1; // sheets of this tile
  int open_ = 0, closed_ = 0;     // pixels
  int summed_closed_ = 0;         // closed pixels that open_sum knows of
  std::array<bool, 8> filled_{};  // whether a plane holds anything, by sheet & 7
};

} // namespace

TilePixels draw_tile(const TileJob& job, const PlannedTile& tile, TileMemory& memory, SplatStats& stats) {
  return Tile(job, tile, memory, stats).draw();
}

} // namespace bccsplat
