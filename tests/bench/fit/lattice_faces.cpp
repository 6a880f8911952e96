#include "tests/bench/fit/lattice_faces.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "base/context.h"
#include "fit/ends.h"
#include "fit/field_model.h"
#include "fit/filter.h"
#include "fit/site_axis.h"

namespace bccsplat::bench {
namespace {

constexpr int margin = 6; // planes, even: cosets stay where they are

// Offsets along a face whose three numbers are as odd as `parity`, those of equal magnitudes together.
std::vector<std::vector<std::array<int, 3>>> orbits(int dimensions, int parity, double most) {
  std::map<std::array<int, 3>, std::vector<std::array<int, 3>>> by_size;
  const int reach = static_cast<int>(std::sqrt(most)), layers = dimensions == 4 ? reach : 0;
  for (int t = -layers; t <= layers; ++t)
    for (int v = -reach; v <= reach; ++v)
      for (int u = -reach; u <= reach; ++u) {
        const bool odd = u & 1;
        if (odd != (parity != 0) || odd != ((v & 1) != 0) || (dimensions == 4 && odd != ((t & 1) != 0)) ||
            u * u + v * v + t * t > most)
          continue;
        std::array<int, 3> size{std::abs(u), std::abs(v), std::abs(t)};
        std::sort(size.begin(), size.end());
        by_size[size].push_back({u, v, t});
      }
  std::vector<std::vector<std::array<int, 3>>> list;
  for (auto& [size, offsets] : by_size) list.push_back(std::move(offsets));
  return list;
}

double site_correlation(int dimensions, double planes, const std::array<int, 3>& a,
                        const std::array<int, 3>& b) {
  double square = planes * planes;
  for (size_t i = 0; i < 3; ++i) square += (a[i] - b[i]) * (a[i] - b[i]);
  return field_correlation(dimensions, std::sqrt(square / 2));
}

// The layers of a volume as dense arrays of planes with margins.
class DenseLayers {
 public:
  DenseLayers(const MemorySamples& samples, const Lattice4& wide) : wide_(wide) {
    const Lattice4& inner = samples.lattice();
    for (int32_t m = 0; m < inner.layers(); ++m) {
      const int c = inner.coset(m);
      const BrickLayer layer = samples.read_layer(0, m, {}, context_);
      const Int3 n = wide_.space.dims(c);
      std::vector<float>& to = layers_.emplace_back();
      for (int32_t z = 0; z < n[2]; ++z)
        for (int32_t y = 0; y < n[1]; ++y)
          for (int32_t x = 0; x < n[0]; ++x) {
            const Int3 i{x, y, z};
            Int3 from;
            for (size_t a = 0; a < 3; ++a) from[a] = inner.space.mirror(a, c, i[a] - margin / 2);
            to.push_back(layer.value(from[0], from[1], from[2]));
          }
    }
  }

  // Predicts the margins at both ends of an axis, along everything that is there by now.
  void predict(size_t axis, std::span<const FaceStencil> stencils) {
    std::vector<std::vector<float>> out = layers_;
    const int last = wide_.space.last[axis] - 2 * margin;
    for (int32_t m = 0; m < static_cast<int32_t>(layers_.size()); ++m)
      for (int beyond = 1; beyond <= margin; ++beyond)
        for (const bool high : {false, true})
          predict_plane(m, axis, high, high ? last + beyond : -beyond,
                        stencils[static_cast<size_t>(beyond) - 1], out[static_cast<size_t>(m)]);
    layers_ = std::move(out);
  }

  [[nodiscard]] MemorySamples samples(float air) const {
    std::vector<std::vector<BrickLayer>> channels(1);
    for (int32_t m = 0; m < static_cast<int32_t>(layers_.size()); ++m)
      channels[0].push_back(layer_from_dense(wide_.space, wide_.coset(m), layers_[static_cast<size_t>(m)]));
    return {wide_, {air}, std::move(channels)};
  }

 private:
  void predict_plane(int32_t layer, size_t axis, bool high, int plane, const FaceStencil& stencil,
                     std::vector<float>& out) const {
    const int c = wide_.coset(layer);
    if ((plane & 1) != c) return;
    const size_t au = axis == 0 ? 1 : 0, av = axis == 2 ? 1 : 2;
    const Int3 n = wide_.space.dims(c);
    Int3 site;
    site[axis] = (plane + margin - c) / 2;
    const int last = wide_.space.last[axis] - 2 * margin;
    for (site[av] = 0; site[av] < n[av]; ++site[av])
      for (site[au] = 0; site[au] < n[au]; ++site[au]) {
        double sum = 0;
        for (const FaceStencil::Group& g : stencil.groups) {
          double of_group = 0;
          for (const auto& [du, dv, dt] : g.offset) {
            const int32_t from = wide_.is_static() ? (c + (du & 1)) & 1 : wide_.mirror_layer(layer + dt);
            Int3 h; // planes of the wide lattice
            h[axis] = (high ? last - g.plane : g.plane) + margin;
            h[au] = 2 * site[au] + c + du, h[av] = 2 * site[av] + c + dv;
            of_group += value(from, h);
          }
          sum += g.weight * of_group;
        }
        out[static_cast<size_t>((site[2] * n[1] + site[1]) * n[0] + site[0])] = static_cast<float>(sum);
      }
  }

  [[nodiscard]] double value(int32_t layer, const Int3& plane) const {
    const int c = wide_.coset(layer);
    const Int3 n = wide_.space.dims(c);
    Int3 i;
    for (size_t a = 0; a < 3; ++a) i[a] = wide_.space.mirror(a, c, (plane[a] - c) / 2);
    return static_cast<double>(
        layers_[static_cast<size_t>(layer)][static_cast<size_t>((i[2] * n[1] + i[1]) * n[0] + i[0])]);
  }

  Lattice4 wide_;
  std::vector<std::vector<float>> layers_;
  Tasks tasks_{1};
  MemoryBudget memory_;
  Progress progress_;
  Context context_{tasks_, memory_, progress_};
};

// A row of samples at positions, and what a mirror image would give replaced. The taps of a position are as
// many as before: a prediction looks at samples that the filter near an end looks at anyway.
class RowFilter {
 public:
  RowFilter(std::span<const double> positions, int64_t n, RowEnds kind) : n_(n), kind_(kind), ends_(1) {
    const FilterTable table = filter_table(Filter::kaiser8, 1, positions);
    for (size_t p = 0; p < positions.size(); ++p) {
      std::map<int64_t, double> sum;
      for (int k = 0; k < table.taps; ++k)
        add(sum, table.first[p] + k,
            static_cast<double>(table.weight[p * static_cast<size_t>(table.taps) + static_cast<size_t>(k)]));
      weights_.emplace_back(sum.begin(), sum.end());
    }
  }
  [[nodiscard]] size_t positions() const { return weights_.size(); }

  // Filters rows that lie `stride` apart.
  [[nodiscard]] std::vector<float> apply(const std::vector<float>& in, size_t stride) const {
    const auto n = static_cast<size_t>(n_), rows = in.size() / stride / n;
    std::vector<float> out(rows * stride * positions());
    for (size_t r = 0; r < rows; ++r)
      for (size_t p = 0; p < positions(); ++p)
        for (size_t k = 0; k < stride; ++k) {
          double sum = 0;
          for (const auto& [at, weight] : weights_[p])
            sum += weight * static_cast<double>(in[(r * n + static_cast<size_t>(at)) * stride + k]);
          out[(r * positions() + p) * stride + k] = static_cast<float>(sum);
        }
    return out;
  }

 private:
  void add(std::map<int64_t, double>& sum, int64_t at, double weight) {
    const int64_t beyond = std::max(-at, at - (n_ - 1));
    if (beyond <= 0 || weight == 0) {
      sum[std::clamp<int64_t>(at, 0, n_ - 1)] += weight;
      return;
    }
    if (kind_ == RowEnds::odd) {
      sum[at < 0 ? 0 : n_ - 1] += 2 * weight;
      sum[mirror_index(at, n_)] -= weight;
      return;
    }
    const std::vector<double>& w = ends_.weights(beyond, n_);
    for (size_t i = 0; i < w.size(); ++i) {
      const auto inside = static_cast<int64_t>(i);
      sum[at < 0 ? inside : n_ - 1 - inside] += weight * w[i];
    }
  }

  int64_t n_;
  RowEnds kind_;
  EndFrames ends_;
  std::vector<std::vector<std::pair<int64_t, double>>> weights_;
};

} // namespace

MemorySamples resample_without_mirrors(const FitSeries& series, RowEnds ends) {
  const Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, series.dims);
  const auto& n = series.dims;
  std::vector<std::vector<BrickLayer>> channels(1);
  for (int32_t m = 0; m < lattice.layers(); ++m) {
    const int c = lattice.coset(m);
    const double frame = lattice.layer_frame(m);
    const RowFilter in_time({&frame, 1}, n[3], ends);
    std::vector<float> values = in_time.apply(series.values, size_t{n[0]} * n[1] * n[2]);
    size_t stride = 1;
    for (size_t a = 0; a < 3; ++a) {
      const RowFilter along(site_positions(lattice, c, a), n[a], ends);
      values = along.apply(values, stride);
      stride *= along.positions();
    }
    channels[0].push_back(layer_from_dense(lattice.space, c, values));
  }
  return {lattice, {0}, std::move(channels)};
}

size_t FaceStencil::taps() const {
  size_t sum = 0;
  for (const Group& g : groups) sum += g.offset.size();
  return sum;
}

double FaceStencil::noise_gain() const {
  double sum = 0;
  for (const Group& g : groups) sum += g.weight * g.weight * static_cast<double>(g.offset.size());
  return sum;
}

namespace {

// The best sum for the value `distance` beyond the face, at a site of the coset of the plane there or, with
// `between`, of the other one.
FaceStencil best_stencil(int dimensions, int distance, bool between, const FaceRule& rule) {
  FaceStencil s;
  for (int plane = 0; plane <= rule.depth; ++plane) {
    const int parity = (plane + distance + between) & 1;
    for (auto& offsets : orbits(dimensions, parity, parity ? rule.other : rule.own))
      s.groups.push_back({plane, std::move(offsets), 0});
  }
  const size_t n = s.groups.size();
  std::vector<std::vector<double>> a(n + 1, std::vector<double>(n + 2));
  for (size_t i = 0; i < n; ++i) {
    const auto& [plane, offsets, weight] = s.groups[i];
    const auto size = static_cast<double>(offsets.size());
    for (size_t j = 0; j < n; ++j)
      for (const auto& other : s.groups[j].offset)
        a[i][j] += size * site_correlation(dimensions, plane - s.groups[j].plane, offsets[0], other);
    a[i][i] += size * rule.noise;
    a[i][n + 1] = size * site_correlation(dimensions, plane + distance, offsets[0], {});
    a[i][n] = a[n][i] = size; // the sum of the weights is 1
  }
  a[n][n + 1] = 1;
  const std::vector<double> w = solve(std::move(a));
  for (size_t i = 0; i < n; ++i) s.groups[i].weight = w[i];
  return s;
}

} // namespace

FaceStencil predicted_stencil(int dimensions, int distance, const FaceRule& rule) {
  return best_stencil(dimensions, distance, false, rule);
}

FaceStencil odd_stencil(int dimensions, int distance, const FaceRule& rule) {
  FaceStencil s;
  if (distance % 2 == 0)
    s.groups.push_back({0, {{0, 0, 0}}, 1});
  else
    s = best_stencil(dimensions, 0, true, rule);
  for (FaceStencil::Group& g : s.groups) g.weight *= 2;
  s.groups.push_back({distance, {{0, 0, 0}}, -1});
  return s;
}

WithMargin predict_faces(const MemorySamples& samples, StencilOf stencil_of, const FaceRule& rule) {
  Lattice4 wide = samples.lattice();
  WithMargin result{samples, {}};
  for (size_t a = 0; a < 3; ++a) {
    wide.space.last[a] += 2 * margin;
    result.origin[a] = margin * wide.space_step[a];
    wide.dims[a] += static_cast<uint32_t>(std::ceil(2 * result.origin[a]));
  }
  DenseLayers layers(samples, wide);
  const int dimensions = wide.is_static() ? 3 : 4;
  std::array<std::vector<FaceStencil>, 3> stencils;
  for (size_t axis = 0; axis < 3; ++axis) {
    FaceRule fitting = rule;
    fitting.depth = std::min(rule.depth, samples.lattice().space.last[axis]);
    for (int beyond = 1; beyond <= margin; ++beyond)
      stencils[axis].push_back(stencil_of(dimensions, beyond, fitting));
  }
  // Near an edge the first round looks at mirror images beyond the other face, the second at what is
  // predicted there.
  for (int round = 0; round < 2; ++round)
    for (size_t axis = 0; axis < 3; ++axis) layers.predict(axis, stencils[axis]);
  result.samples = layers.samples(samples.air(0));
  return result;
}

} // namespace bccsplat::bench
