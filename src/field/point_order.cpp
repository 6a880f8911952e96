// SPDX-License-Identifier: Apache-2.0
// Sorts the points of a batch by windows in time, and by cells of space where they jump about.
#include "field/point_order.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace bccsplat {
namespace {

constexpr uint64_t block = 2048; // points of one task
// Points are gathered by cells where more than one in this many jumps to another cell: points taken out of
// order cost about as much as an eighth of the cache misses they save (measured).
constexpr uint64_t jump_part = 8;
constexpr uint64_t fewest_gathered = 64; // fewer points share too little
// A counting sort is used up to this many keys per point; beyond, its table costs more than comparing would.
constexpr uint64_t keys_per_point = 4, spare_keys = 1024;

// Points that follow each other in one window and cell.
struct PlaceRun {
  PointPlace place;
  uint64_t begin, end; // points
};
constexpr uint64_t points_per_check = 65536;
constexpr size_t max_runs = block / 4; // worth moving as they are

struct Summary {
  int32_t low = INT32_MAX, high = INT32_MIN; // windows
  uint64_t jumps = 0;                        // from cell to cell
  std::vector<PlaceRun> runs;
  bool scattered = false; // there are more than max_runs, and not all in `runs`
};

// Stable: places of points by rising key, keys below `count`.
std::vector<uint64_t> counting_sort(std::span<const uint32_t> keys, uint64_t count, Progress& progress) {
  std::vector<uint64_t> start(count + 1);
  for (uint64_t n = 0; n < keys.size(); ++n) {
    if (n % points_per_check == 0) progress.check();
    ++start[keys[n] + 1];
  }
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<uint64_t> order(keys.size());
  for (uint64_t n = 0; n < keys.size(); ++n) {
    if (n % points_per_check == 0) progress.check();
    order[start[keys[n]]++] = n;
  }
  return order;
}

// The order of whole runs by rising windows, and within a window by cells where `gather` is set; stable.
PointOrder order_runs(std::span<const Summary> summaries, bool gather) {
  std::vector<PlaceRun> runs;
  const auto alike = [&](const PointPlace& a, const PointPlace& b) {
    return a.window == b.window && (!gather || a.cell == b.cell);
  };
  for (const Summary& s : summaries)
    for (const PlaceRun& r : s.runs) {
      if (!runs.empty() && alike(runs.back().place, r.place))
        runs.back().end = r.end;
      else
        runs.push_back(r);
    }
  std::stable_sort(runs.begin(), runs.end(), [&](const PlaceRun& a, const PlaceRun& b) {
    if (a.place.window != b.place.window) return a.place.window < b.place.window;
    return gather && a.place.cell < b.place.cell;
  });
  PointOrder result;
  uint64_t place = 0;
  for (const PlaceRun& r : runs) {
    if (result.groups.empty() || result.groups.back().window != r.place.window)
      result.groups.push_back({r.place.window, place, place});
    result.runs.push_back({place, r.begin});
    place += r.end - r.begin;
    result.groups.back().end = place;
  }
  return result;
}

} // namespace

bool PointOrder::points_at(uint64_t begin, std::span<uint64_t> points) const {
  if (!order.empty()) {
    std::copy_n(order.begin() + begin, points.size(), points.begin());
    return false;
  }
  if (runs.empty()) {
    std::iota(points.begin(), points.end(), begin);
    return true;
  }
  auto run = std::upper_bound(runs.begin(), runs.end(), begin,
                              [](uint64_t place, const Run& r) { return place < r.place; }) -
             1;
  for (size_t i = 0; i < points.size();) {
    const uint64_t place = begin + i, last = run + 1 == runs.end() ? UINT64_MAX : (run + 1)->place;
    const size_t count = std::min<uint64_t>(points.size() - i, last - place);
    std::iota(points.begin() + i, points.begin() + (i + count), run->point + (place - run->place));
    if (count == points.size()) return true;
    i += count, ++run;
  }
  return false;
}

PointOrder order_points(uint64_t points, uint32_t cells,
                        const std::function<void(uint64_t begin, std::span<PointPlace>)>& place,
                        const Context& context) {
  PointOrder result;
  if (points == 0) return result;
  // Places are kept only once it is known that they are needed: finding them is cheaper than memory for all.
  std::vector<Summary> summaries((points + block - 1) / block);
  context.tasks.parallel_for(summaries.size(), [&](uint64_t b) {
    context.progress.check();
    std::array<PointPlace, block> places;
    const auto mine = std::span(places).first(std::min(block, points - b * block));
    place(b * block, mine);
    Summary s;
    for (size_t i = 0; i < mine.size();) {
      const PointPlace& from = mine[i];
      size_t end = i + 1;
      while (end < mine.size() && mine[end].window == from.window && mine[end].cell == from.cell) ++end;
      s.low = std::min(s.low, from.window), s.high = std::max(s.high, from.window);
      s.jumps += i > 0 && from.cell != mine[i - 1].cell;
      s.scattered = s.scattered || s.runs.size() == max_runs;
      if (!s.scattered) s.runs.push_back({from, b * block + i, b * block + end});
      i = end;
    }
    summaries[b] = std::move(s);
  });
  Summary all;
  for (const Summary& s : summaries) {
    all.low = std::min(all.low, s.low), all.high = std::max(all.high, s.high);
    all.jumps += s.jumps;
  }
  const auto windows = static_cast<uint64_t>(int64_t{all.high} - all.low) + 1;
  const bool scattered =
      std::any_of(summaries.begin(), summaries.end(), [](const Summary& s) { return s.scattered; });
  const bool gather = all.jumps > points / jump_part && cells > 1 && points >= fewest_gathered &&
                      windows * cells < keys_per_point * points;
  if (windows == 1 && !gather) {
    result.groups.push_back({all.low, 0, points});
    return result;
  }
  if (!scattered) return order_runs(summaries, gather);
  std::vector<PointPlace> at(points);
  context.tasks.parallel_for(summaries.size(), [&](uint64_t b) {
    context.progress.check();
    place(b * block, std::span(at).subspan(b * block, std::min(block, points - b * block)));
  });
  const auto window = [&](uint64_t n) { return static_cast<uint32_t>(int64_t{at[n].window} - all.low); };
  if (windows < keys_per_point * points + spare_keys) {
    std::vector<uint32_t> keys(points);
    for (uint64_t n = 0; n < points; ++n) {
      if (n % points_per_check == 0) context.progress.check();
      keys[n] = gather ? window(n) * cells + at[n].cell : window(n);
    }
    result.order = counting_sort(keys, gather ? windows * cells : windows, context.progress);
  } else {
    result.order.resize(points);
    std::iota(result.order.begin(), result.order.end(), uint64_t{0});
    uint64_t compared = 0;
    std::stable_sort(result.order.begin(), result.order.end(), [&](uint64_t a, uint64_t b) {
      if (++compared % points_per_check == 0) context.progress.check();
      return at[a].window < at[b].window;
    });
  }
  for (uint64_t n = 0; n < points; ++n) {
    if (n % points_per_check == 0) context.progress.check();
    const int32_t w = at[result.order[n]].window;
    if (result.groups.empty() || result.groups.back().window != w) result.groups.push_back({w, n, n});
    result.groups.back().end = n + 1;
  }
  return result;
}

} // namespace bccsplat
