// SPDX-License-Identifier: Apache-2.0
// Follows light through extinctions on a grid that is sheared along its way, and looks up what came through.
#include "shade/light_volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace bccsplat {
namespace {

// Two axes of a plane of nodes: the value between four of them. Beyond the grid there is nothing.
class PlaneOfNodes {
 public:
  PlaneOfNodes(const float* first, std::array<size_t, 2> stride, std::array<int, 2> nodes)
      : first_(first), stride_(stride), nodes_(nodes) {}
  [[nodiscard]] float at(double x, double y) const {
    const double fx = std::floor(x), fy = std::floor(y);
    const int i = static_cast<int>(fx), j = static_cast<int>(fy);
    const auto tx = static_cast<float>(x - fx), ty = static_cast<float>(y - fy);
    const float low = node(i, j) + tx * (node(i + 1, j) - node(i, j));
    const float high = node(i, j + 1) + tx * (node(i + 1, j + 1) - node(i, j + 1));
    return low + ty * (high - low);
  }

 private:
  [[nodiscard]] float node(int i, int j) const {
    if (i < 0 || j < 0 || i >= nodes_[0] || j >= nodes_[1]) return 0;
    return first_[static_cast<size_t>(i) * stride_[0] + static_cast<size_t>(j) * stride_[1]];
  }
  const float* first_;
  std::array<size_t, 2> stride_;
  std::array<int, 2> nodes_;
};

// The grid turned so that light comes along its last axis, from the last plane to the first or the other way.
class Beams {
 public:
  Beams(const LightGrid& grid, const LightWay& way) : grid_(grid) {
    Vec3 in_nodes;
    for (size_t a = 0; a < 3; ++a) in_nodes[a] = way.direction[a] / grid.step[a];
    for (size_t a = 0; a < 3; ++a)
      if (std::fabs(in_nodes[a]) > std::fabs(in_nodes[along_])) along_ = a;
    across_ = {along_ == 0 ? size_t{1} : size_t{0}, along_ == 2 ? size_t{1} : size_t{2}};
    const double planes = std::fabs(in_nodes[along_]); // that the vector crosses
    up_ = in_nodes[along_] > 0;
    path_ = static_cast<float>(way.length / planes);
    for (size_t n = 0; n < 2; ++n) {
      nodes_[n] = grid.nodes[across_[n]];
      shear_[n] = in_nodes[across_[n]] / planes;
      const double last = shear_[n] * (planes_of() - 1); // of the plane that light reaches last
      first_[n] = static_cast<int>(std::floor(std::min(0.0, last)));
      columns_[n] = static_cast<int>(std::ceil(nodes_[n] - 1 + std::max(0.0, last))) - first_[n] + 1;
    }
  }

  [[nodiscard]] std::vector<float> through(std::span<const float> extinction, const Context& context) const {
    const size_t columns = static_cast<size_t>(columns_[0]) * static_cast<size_t>(columns_[1]);
    // Optical depths from where light comes in to each plane, the column's extinction there, the plane's.
    std::vector<float> depth(columns, 0.0f), before(columns, 0.0f), out(extinction.size());
    for (int n = 0; n < planes_of(); ++n) {
      context.progress.check();
      add_plane(n, plane_of(extinction.data(), n), depth, before, context);
      tell_plane(n, depth, out, context);
    }
    return out;
  }

 private:
  [[nodiscard]] int planes_of() const { return grid_.nodes[along_]; }
  [[nodiscard]] size_t stride(size_t axis) const {
    size_t s = 1;
    for (size_t a = 0; a < axis; ++a) s *= static_cast<size_t>(grid_.nodes[a]);
    return s;
  }
  // The nodes of the plane that light reaches after n others.
  [[nodiscard]] size_t offset_of(int n) const {
    return static_cast<size_t>(up_ ? planes_of() - 1 - n : n) * stride(along_);
  }
  [[nodiscard]] PlaneOfNodes plane_of(const float* all, int n) const {
    return {all + offset_of(n), {stride(across_[0]), stride(across_[1])}, nodes_};
  }
  // Where column 0 passes the plane that light reaches after n others, in nodes.
  [[nodiscard]] double place(size_t axis, int n) const { return first_[axis] - shear_[axis] * n; }

  void add_plane(int n, const PlaneOfNodes& plane, std::vector<float>& depth, std::vector<float>& before,
                 const Context& context) const {
    context.tasks.parallel_for(static_cast<uint64_t>(columns_[1]), [&](uint64_t row) {
      const int j = static_cast<int>(row);
      for (int i = 0; i < columns_[0]; ++i) {
        const size_t c = row * static_cast<size_t>(columns_[0]) + static_cast<size_t>(i);
        const float here = plane.at(i + place(0, n), j + place(1, n));
        if (n > 0) depth[c] += 0.5f * path_ * (before[c] + here);
        before[c] = here;
      }
    });
  }

  void tell_plane(int n, const std::vector<float>& depth, std::vector<float>& out,
                  const Context& context) const {
    const PlaneOfNodes depths(depth.data(), {1, static_cast<size_t>(columns_[0])}, columns_);
    float* const plane = out.data() + offset_of(n);
    const size_t sx = stride(across_[0]), sy = stride(across_[1]);
    context.tasks.parallel_for(static_cast<uint64_t>(nodes_[1]), [&](uint64_t row) {
      const int j = static_cast<int>(row);
      for (int i = 0; i < nodes_[0]; ++i)
        plane[static_cast<size_t>(i) * sx + row * sy] =
            std::exp(-depths.at(i - place(0, n), j - place(1, n)));
    });
  }

  const LightGrid& grid_;
  size_t along_ = 0;
  std::array<size_t, 2> across_{};
  bool up_ = false; // light comes from the last plane
  float path_ = 0;  // world length from plane to plane
  std::array<double, 2> shear_{};
  std::array<int, 2> nodes_{}, first_{}, columns_{};
};

} // namespace

std::vector<float> light_through(const LightGrid& grid, std::span<const float> extinction,
                                 const LightWay& way, const Context& context) {
  return Beams(grid, way).through(extinction, context);
}

std::span<const WayAround, ways_around> all_around() {
  constexpr double of_axis = 1.0 / 15, of_diagonal = 3.0 / 40;
  static constexpr std::array<WayAround, ways_around> ways{{{{1, 0, 0}, of_axis},
                                                            {{-1, 0, 0}, of_axis},
                                                            {{0, 1, 0}, of_axis},
                                                            {{0, -1, 0}, of_axis},
                                                            {{0, 0, 1}, of_axis},
                                                            {{0, 0, -1}, of_axis},
                                                            {{1, 1, 1}, of_diagonal},
                                                            {{-1, 1, 1}, of_diagonal},
                                                            {{1, -1, 1}, of_diagonal},
                                                            {{-1, -1, 1}, of_diagonal},
                                                            {{1, 1, -1}, of_diagonal},
                                                            {{-1, 1, -1}, of_diagonal},
                                                            {{1, -1, -1}, of_diagonal},
                                                            {{-1, -1, -1}, of_diagonal}}};
  return ways;
}

LightVolume::LightVolume(const LightGrid& grid, std::vector<std::vector<float>> lights,
                         std::vector<float> ambient, Reservation memory)
    : grid_(grid), lights_(std::move(lights)), ambient_(std::move(ambient)), memory_(std::move(memory)) {}

float LightVolume::at(const std::vector<float>& plane, const Vec3& p) const {
  std::array<size_t, 3> low{}, up{};
  std::array<float, 3> t{};
  size_t stride = 1;
  for (size_t a = 0; a < 3; ++a) {
    const double last = grid_.nodes[a] - 1;
    const double place = std::clamp((p[a] - grid_.begin[a]) / grid_.step[a], 0.0, last);
    const double below = std::min(std::floor(place), std::max(last - 1, 0.0));
    low[a] = static_cast<size_t>(below) * stride, up[a] = last > 0 ? stride : 0;
    t[a] = static_cast<float>(place - below);
    stride *= static_cast<size_t>(grid_.nodes[a]);
  }
  const float* const first = plane.data() + low[0] + low[1] + low[2];
  const auto along_x = [&](size_t more) { return first[more] + t[0] * (first[more + up[0]] - first[more]); };
  const auto along_y = [&](size_t more) {
    const float a = along_x(more), b = along_x(more + up[1]);
    return a + t[1] * (b - a);
  };
  const float a = along_y(0), b = along_y(up[2]);
  return a + t[2] * (b - a);
}

} // namespace bccsplat
