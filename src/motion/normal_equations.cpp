// SPDX-License-Identifier: Apache-2.0
#include "motion/normal_equations.h"

#include <cmath>

namespace bccsplat::motion {
namespace {

constexpr int32_t most_rounds = 16;
constexpr double accuracy = 1e-3; // of the residual, to begin with

using Values = std::vector<Float3>;

double dot(const Values& a, const Values& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i)
    for (size_t k = 0; k < 3; ++k) sum += double{a[i][k]} * b[i][k];
  return sum;
}

class Equations {
 public:
  Equations(const Flow& flow, const std::vector<Sight>& sights, float smoothness)
      : nodes_(flow.nodes), sights_(sights), diagonal_(flow.velocity.size()) {
    double sum = 0;
    size_t seen = 0;
    for (const Sight& s : sights)
      for (size_t k = 0; k < 8; ++k)
        for (size_t a = 0; a < 3; ++a)
          diagonal_[s.corners.node[k]][a] +=
              s.corners.share[k] * s.corners.share[k] * s.slope[a] * s.slope[a];
    for (const Float3& d : diagonal_) {
      const double all = double{d[0]} + d[1] + d[2];
      sum += all, seen += all > 0;
    }
    smoothness_ = seen > 0 ? static_cast<float>(smoothness * sum / (3.0 * static_cast<double>(seen))) : 1;
    for (Float3& d : diagonal_)
      for (float& v : d) v += 6 * smoothness_;
  }

  // What is left of the equations when nothing has changed.
  [[nodiscard]] Values residual(const Values& velocity) const {
    Values r(velocity.size());
    add_differences(velocity, -1, r);
    for (const Sight& s : sights_)
      for (size_t k = 0; k < 8; ++k)
        for (size_t a = 0; a < 3; ++a)
          r[s.corners.node[k]][a] -= s.corners.share[k] * s.slope[a] * s.difference;
    return r;
  }
  [[nodiscard]] Values product(const Values& x) const {
    Values r(x.size());
    add_differences(x, 1, r);
    for (const Sight& s : sights_) {
      float change = 0;
      for (size_t k = 0; k < 8; ++k) {
        const Float3& v = x[s.corners.node[k]];
        change += s.corners.share[k] * (s.slope[0] * v[0] + s.slope[1] * v[1] + s.slope[2] * v[2]);
      }
      for (size_t k = 0; k < 8; ++k) {
        const float w = s.corners.share[k] * change;
        for (size_t a = 0; a < 3; ++a) r[s.corners.node[k]][a] += w * s.slope[a];
      }
    }
    return r;
  }
  [[nodiscard]] Values preconditioned(Values r) const {
    for (size_t i = 0; i < r.size(); ++i)
      for (size_t a = 0; a < 3; ++a) r[i][a] /= diagonal_[i][a];
    return r;
  }

 private:
  void add_differences(const Values& x, float sign, Values& r) const {
    for (size_t i = 0; i < x.size(); ++i) {
      const Int3 n = nodes_.node(i);
      for (size_t axis = 0; axis < 3; ++axis) {
        if (n[axis] + 1 >= nodes_.dims[axis]) continue;
        Int3 next = n;
        ++next[axis];
        const size_t j = nodes_.index(next);
        for (size_t a = 0; a < 3; ++a) {
          const float d = sign * smoothness_ * (x[i][a] - x[j][a]);
          r[i][a] += d, r[j][a] -= d;
        }
      }
    }
  }

  const Nodes& nodes_;
  const std::vector<Sight>& sights_;
  Values diagonal_;
  float smoothness_ = 0;
};

} // namespace

std::vector<Float3> better_by(const Flow& flow, const std::vector<Sight>& sights, float smoothness) {
  const Equations equations(flow, sights, smoothness);
  Values x(flow.velocity.size()), r = equations.residual(flow.velocity), z = equations.preconditioned(r),
                                  p = z;
  double size = dot(r, z);
  const double enough = size * accuracy * accuracy;
  for (int32_t round = 0; round < most_rounds && size > enough; ++round) {
    const Values q = equations.product(p);
    const auto step = static_cast<float>(size / dot(p, q));
    for (size_t i = 0; i < x.size(); ++i)
      for (size_t a = 0; a < 3; ++a) x[i][a] += step * p[i][a], r[i][a] -= step * q[i][a];
    z = equations.preconditioned(r);
    const double next = dot(r, z);
    const auto turn = static_cast<float>(next / size);
    for (size_t i = 0; i < x.size(); ++i)
      for (size_t a = 0; a < 3; ++a) p[i][a] = z[i][a] + turn * p[i][a];
    size = next;
  }
  return x;
}

} // namespace bccsplat::motion
