#include "slice/point_order.h"

#include <algorithm>
#include <numeric>

namespace bccsplat {
namespace {

constexpr uint64_t block = 4096; // points of one task

struct Summary {
  int32_t low = INT32_MAX, high = INT32_MIN; // windows
  uint64_t jumps = 0;                        // from cell to cell
};

// Stable: places of points by rising key, keys below `count`.
std::vector<uint64_t> counting_sort(std::span<const uint32_t> keys, uint64_t count) {
  std::vector<uint64_t> start(count + 1);
  for (const uint32_t k : keys) ++start[k + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<uint64_t> order(keys.size());
  for (uint64_t n = 0; n < keys.size(); ++n) order[start[keys[n]]++] = n;
  return order;
}

} // namespace

PointOrder order_points(uint64_t points, uint32_t cells,
                        const std::function<void(uint64_t begin, std::span<PointPlace>)>& place,
                        const Context& context) {
  PointOrder result;
  if (points == 0) return result;
  std::vector<PointPlace> at(points);
  std::vector<Summary> summaries((points + block - 1) / block);
  context.tasks.parallel_for(summaries.size(), [&](uint64_t b) {
    context.progress.check();
    const auto mine = std::span(at).subspan(b * block, std::min(block, points - b * block));
    place(b * block, mine);
    Summary s;
    uint32_t cell = mine[0].cell;
    for (const PointPlace& p : mine) {
      s.low = std::min(s.low, p.window), s.high = std::max(s.high, p.window);
      s.jumps += p.cell != cell;
      cell = p.cell;
    }
    summaries[b] = s;
  });
  Summary all;
  for (const Summary& s : summaries) {
    all.low = std::min(all.low, s.low), all.high = std::max(all.high, s.high);
    all.jumps += s.jumps;
  }
  const auto windows = static_cast<uint64_t>(int64_t{all.high} - all.low) + 1;
  // Fetching points out of order costs about as much as an eighth of the cache misses it saves.
  const bool gather = all.jumps > points / 8 && cells > 1 && points >= 64 && windows * cells < 4 * points;
  if (windows == 1 && !gather) {
    result.groups.push_back({all.low, 0, points});
    return result;
  }
  const auto window = [&](uint64_t n) { return static_cast<uint32_t>(int64_t{at[n].window} - all.low); };
  if (windows < 4 * points + 1024) {
    std::vector<uint32_t> keys(points);
    for (uint64_t n = 0; n < points; ++n) keys[n] = gather ? window(n) * cells + at[n].cell : window(n);
    result.order = counting_sort(keys, gather ? windows * cells : windows);
  } else {
    result.order.resize(points);
    std::iota(result.order.begin(), result.order.end(), uint64_t{0});
    std::stable_sort(result.order.begin(), result.order.end(),
                     [&](uint64_t a, uint64_t b) { return at[a].window < at[b].window; });
  }
  for (uint64_t n = 0; n < points; ++n) {
    const int32_t w = at[result.order[n]].window;
    if (result.groups.empty() || result.groups.back().window != w) result.groups.push_back({w, n, n});
    result.groups.back().end = n + 1;
  }
  return result;
}

} // namespace bccsplat
