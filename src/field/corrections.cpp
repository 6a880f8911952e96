// SPDX-License-Identifier: Apache-2.0
// Weighs at each point the corrections of the 16 source samples around it, by a fall-off along each axis, and
// adds their sum. Tables of frames and bricks of corrections are cached, and each task has the last ones at
// hand.
#include "field/corrections.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>

#include "base/damage.h"
#include "base/would_block.h"

namespace bccsplat {
namespace {

constexpr double same_place = 1e-6;    // index units: a point this close to a source sample is meant to be it
constexpr uint64_t task_points = 4096; // of a task
constexpr size_t bricks_at_hand = 64;  // of a task
constexpr uint64_t frame_part = 4;     // of the cache is for frames, the rest for bricks

} // namespace

Corrections::Corrections(std::unique_ptr<const CorrectionSource> source, MemoryBudget& budget,
                         uint64_t cache_bytes)
    : source_(std::move(source)), geometry_(source_->lattice().dims), budget_(budget),
      frames_(cache_bytes / frame_part), bricks_(cache_bytes - cache_bytes / frame_part) {
  for (size_t a = 0; a < 4; ++a) {
    n_[a] = source_->lattice().dims[a];
    if (n_[a] > INT32_MAX)
      fail(Code::limit_exceeded, "corrections of a series of ", n_[a], " samples an axis");
  }
}

template<class Key, class Value>
void Corrections::keep(LruCache<Key, Value>& cache, const Key& key, const std::shared_ptr<const Value>& value,
                       uint64_t bytes) const {
  if (!budget_.try_reserve(bytes)) return;
  cache.insert(key, value, bytes, Reservation::adopt(budget_, bytes));
}

std::shared_ptr<const Corrections::Frame> Corrections::frame(int64_t number) const {
  if (auto found = frames_.find(number)) return found;
  CorrectionSource::Frame read = source_->read_frame(number);
  auto made = std::make_shared<Frame>();
  made->table = std::move(read.table);
  made->whole = SparseGrid(std::move(read.add)), made->set = SparseGrid(std::move(read.set));
  std::shared_ptr<const Frame> result = std::move(made);
  keep(frames_, number, result,
       sizeof(Frame) + result->table.size() * sizeof(CorrectionBrick) + result->whole.bytes() +
           result->set.bytes());
  return result;
}

std::shared_ptr<const SparseGrid> Corrections::brick(int64_t frame, const CorrectionBrick& entry) const {
  const std::pair key{frame, entry.brick};
  if (auto found = bricks_.find(key)) return found;
  auto made = std::make_shared<const SparseGrid>(source_->read_brick(entry));
  keep(bricks_, key, made, made->bytes());
  return made;
}

bool Corrections::meets(const CorrectionBrick& entry, const Box& box) const {
  const Int3 from = geometry_.origin(entry.brick);
  bool near = true;
  for (size_t a = 0; a < 3; ++a)
    near = near && from[a] < box.end[a] && from[a] + correction_edge > box.begin[a];
  return near;
}

void Corrections::list_reads(int64_t number, bool missing, const Box& box,
                             std::vector<ByteRange>& out) const {
  if (!missing || !frames_.contains(number))
    for (const ByteRange& place : source_->places(number)) out.push_back(place);
  const auto held = frame(number); // the budget may have no room to keep it
  for (const CorrectionBrick& entry : held->table)
    if (meets(entry, box) && (!missing || !bricks_.contains({number, entry.brick})))
      out.push_back(entry.block.range());
}

uint64_t Corrections::count() const {
  if (const auto told = source_->told_count()) return *told;
  uint64_t sum = 0;
  Attempts attempts;
  for (int64_t f = 0; f < n_[3]; ++f) {
    try {
      const auto held = frame(f);
      for (const CorrectionBrick& entry : held->table) sum += entry.count;
      sum += held->whole.size() + held->set.size();
    } catch (const WouldBlock& e) {
      attempts.add(e);
    } catch (const Error& e) {
      // What is damaged is found by a check of the file, or by whoever looks there.
      if (!is_damage(e.code()) && !source_->goes_without(e)) throw;
    }
  }
  attempts.throw_if_waiting();
  return sum;
}

void Corrections::each(int64_t number, const std::function<void(const Int3&, float)>& body,
                       const Box& box) const {
  const auto f = frame(number);
  f->whole.each(body);
  Attempts attempts;
  for (const CorrectionBrick& entry : f->table) {
    if (!meets(entry, box)) continue;
    const Int3 from = geometry_.origin(entry.brick);
    attempts.attempt([&] {
      brick(number, entry)->each([&](const Int3& at, float value) {
        body({from[0] + at[0], from[1] + at[1], from[2] + at[2]}, value);
      });
    });
  }
  attempts.throw_if_waiting();
}

void Corrections::each_set(int64_t number, const std::function<void(const Int3&, float)>& body) const {
  frame(number)->set.each(body);
}

// The frames and bricks that a task has at hand: neighbouring points share them. What has to wait counts as
// empty, so that the other points tell what they lack, too.
class Corrections::Lookup {
 public:
  Lookup(const Corrections& of, Attempts& attempts) : of_(of), attempts_(attempts) {}

  [[nodiscard]] const Frame& frame(int64_t number) {
    auto& held = frames_[number & 1];
    if (held.first == number) return *held.second;
    held = {number, std::make_shared<const Frame>()};
    attempts_.attempt([&] { held.second = of_.frame(number); });
    return *held.second;
  }

  // The correction of a source sample; 0: none.
  [[nodiscard]] float value(int64_t number, const Int3& at) {
    const Frame& f = frame(number);
    if (f.table.empty()) {
      const float* found = f.whole.find(at[0], at[1], at[2]);
      return found ? *found : 0;
    }
    const SparseGrid* grid = brick(number, f, of_.geometry_.brick_of(at));
    constexpr int edge = correction_edge;
    const float* found = grid ? grid->find(at[0] % edge, at[1] % edge, at[2] % edge) : nullptr;
    return found ? *found : 0;
  }

 private:
  [[nodiscard]] const SparseGrid* brick(int64_t number, const Frame& f, uint32_t n) {
    const std::pair key{number, n};
    if (key == last_) return last_grid_;
    last_ = key;
    const auto entry = std::lower_bound(f.table.begin(), f.table.end(), n,
                                        [](const CorrectionBrick& b, uint32_t v) { return b.brick < v; });
    if (entry == f.table.end() || entry->brick != n) return last_grid_ = nullptr;
    if (bricks_.size() > bricks_at_hand) bricks_.clear();
    auto& held = bricks_[key];
    if (held) return last_grid_ = held.get();
    held = std::make_shared<const SparseGrid>();
    attempts_.attempt([&] { held = of_.brick(number, *entry); });
    return last_grid_ = held.get();
  }

  const Corrections& of_;
  Attempts& attempts_;
  std::array<std::pair<int64_t, std::shared_ptr<const Frame>>, 2> frames_{{{-1, nullptr}, {-1, nullptr}}};
  std::map<std::pair<int64_t, uint32_t>, std::shared_ptr<const SparseGrid>> bricks_;
  std::pair<int64_t, uint32_t> last_{-1, 0};
  const SparseGrid* last_grid_ = nullptr;
};

namespace {

// The source samples around a place along one axis, with weights and slopes; those beyond the ends have none,
// or are those at the other end of a periodic axis.
struct Around {
  std::array<int64_t, 2> at{};
  std::array<double, 2> weight{}, slope{};

  [[nodiscard]] bool none(size_t k) const { return weight[k] == 0 && slope[k] == 0; }

  Around(double p, int64_t n, bool periodic, const FallOff& fall) {
    const double cell = periodic ? std::floor(p) : std::clamp(std::floor(p), -2.0, static_cast<double>(n));
    for (size_t k = 0; k < 2; ++k) {
      at[k] = static_cast<int64_t>(cell) + static_cast<int64_t>(k);
      const double d = p - static_cast<double>(at[k]);
      if (periodic) at[k] = (at[k] % n + n) % n;
      if (at[k] < 0 || at[k] >= n) continue;
      weight[k] = fall.value(d), slope[k] = fall.slope(d);
    }
  }
};

// The source sample a point is meant to be; false: none.
bool source_sample(const Vec4& p, const Lattice4& lattice, std::array<int64_t, 4>& at) {
  const auto& n = lattice.dims;
  for (size_t a = 0; a < 4; ++a) {
    if (n[a] == 1 && a == 3) {
      at[a] = 0;
      continue;
    }
    const double near = std::nearbyint(p[a]);
    if (!(std::fabs(p[a] - near) < same_place) || near < 0 || near > lattice.domain_end(a)) return false;
    at[a] = lattice.turned_sample(a, static_cast<int64_t>(near));
  }
  return true;
}

} // namespace

uint64_t Corrections::add_to_points(std::span<const Vec4> points, std::span<float> values,
                                    std::span<std::array<float, 4>> gradients, const Context& context) const {
  const FallOff fall(shape());
  const Lattice4& lattice = source_->lattice();
  std::atomic<uint64_t> found{0};
  Attempts attempts;
  const auto add = [&](Lookup& look, size_t i) {
    const Vec4& p = points[i];
    const auto around = [&](size_t a) { return Around(p[a], n_[a], lattice.turns(a), fall); };
    const std::array<Around, 3> space{around(0), around(1), around(2)};
    const Around time(n_[3] == 1 ? 0 : p[3], n_[3], lattice.periodic, fall);
    float sum = 0;
    std::array<double, 4> slope{};
    for (size_t m = 0; m < 2; ++m) {
      if (time.none(m) || look.frame(time.at[m]).empty()) continue;
      for (size_t corner = 0; corner < 8; ++corner) {
        const std::array<size_t, 3> k{corner & 1, corner >> 1 & 1, corner >> 2};
        std::array<double, 4> w, s;
        for (size_t a = 0; a < 3; ++a) w[a] = space[a].weight[k[a]], s[a] = space[a].slope[k[a]];
        w[3] = time.weight[m], s[3] = n_[3] == 1 ? 0 : time.slope[m];
        if (space[0].none(k[0]) || space[1].none(k[1]) || space[2].none(k[2])) continue;
        const float value = look.value(time.at[m], {static_cast<int32_t>(space[0].at[k[0]]),
                                                    static_cast<int32_t>(space[1].at[k[1]]),
                                                    static_cast<int32_t>(space[2].at[k[2]])});
        if (value == 0) continue;
        sum += value * static_cast<float>(w[0] * w[1] * w[2] * w[3]);
        for (size_t a = 0; a < 4; ++a) {
          double product = value * s[a];
          for (size_t b = 0; b < 4; ++b) product *= b == a ? 1 : w[b];
          slope[a] += product;
        }
      }
    }
    values[i] += sum;
    if (gradients.empty()) return;
    for (size_t a = 0; a < 4; ++a) gradients[i][a] += static_cast<float>(slope[a]);
  };
  context.tasks.parallel_for((points.size() + task_points - 1) / task_points, [&](uint64_t b) {
    context.progress.check();
    Lookup look(*this, attempts);
    for (size_t i = b * task_points; i < std::min<size_t>(points.size(), (b + 1) * task_points); ++i) {
      if (!std::isnan(values[i])) {
        add(look, i);
        continue;
      }
      std::array<int64_t, 4> at;
      if (!source_sample(points[i], lattice, at)) continue;
      const float* value = look.frame(at[3]).set.find(static_cast<int>(at[0]), static_cast<int>(at[1]),
                                                      static_cast<int>(at[2]));
      if (value) values[i] = *value, ++found;
    }
  });
  attempts.throw_if_waiting();
  return found;
}

} // namespace bccsplat
