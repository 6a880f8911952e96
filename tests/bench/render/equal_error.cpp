// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/render/equal_error.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/text.h"

namespace bccsplat::bench {
namespace {

constexpr std::array goals{20.0, 32.0, 36.0, 40.0, 48.0, 56.0}; // dB

} // namespace

RenderOptions options_at(double step) {
  RenderOptions o;
  o.sheet_step = step, o.quality = step >= 1 ? Quality::draft : step >= 0.5 ? Quality::normal : Quality::fine;
  return o;
}

void measure_ways(std::vector<Way>& ways, int size, int rounds, const Image& truth, int stride) {
  std::vector<Method> all;
  for (const Way& w : ways) all.insert(all.end(), w.methods.begin(), w.methods.end());
  const std::vector<double> ms = least_ms(all, size, rounds);
  size_t next = 0;
  for (Way& w : ways)
    for (const Method& m : w.methods) {
      w.ms.push_back(w.before_ms + ms[next++]);
      w.psnr.push_back(method_error(m, size, truth, stride).psnr());
    }
}

std::optional<double> time_to_reach(const Way& way, double psnr) {
  std::optional<double> least;
  const auto offer = [&](double ms) { least = std::min(least.value_or(ms), ms); };
  for (size_t i = 0; i < way.ms.size(); ++i) {
    if (way.psnr[i] >= psnr) offer(way.ms[i]);
    if (i == 0 || !way.at_any_step || (way.psnr[i - 1] < psnr) == (way.psnr[i] < psnr)) continue;
    const double part = (psnr - way.psnr[i - 1]) / (way.psnr[i] - way.psnr[i - 1]);
    offer(way.ms[i - 1] * std::pow(way.ms[i] / way.ms[i - 1], part));
  }
  return least;
}

std::optional<double> psnr_within(const Way& way, double ms) {
  std::optional<double> most;
  const auto offer = [&](double psnr) { most = std::max(most.value_or(psnr), psnr); };
  for (size_t i = 0; i < way.ms.size(); ++i) {
    if (way.ms[i] <= ms) offer(way.psnr[i]);
    if (i == 0 || !way.at_any_step || (way.ms[i - 1] <= ms) == (way.ms[i] <= ms)) continue;
    const double part = std::log(ms / way.ms[i - 1]) / std::log(way.ms[i] / way.ms[i - 1]);
    offer(way.psnr[i - 1] + part * (way.psnr[i] - way.psnr[i - 1]));
  }
  return most;
}

void report_ways(const Report& report, const std::string& scene, const std::string& how,
                 const std::string& name, const std::vector<Way>& ways) {
  std::vector<Row> rows;
  Plot plot;
  plot.title = scene, plot.x_label = "CPU time of a picture, ms", plot.y_label = "PSNR, dB",
  plot.log_x = true;
  for (const Way& w : ways) {
    Series series{w.name, {}, true, {}};
    for (size_t i = 0; i < w.methods.size(); ++i) {
      rows.push_back({word("way", w.name), word("what", w.methods[i].name),
                      figure("step", w.methods[i].step, 3), figure("ms", w.ms[i], 1),
                      figure("PSNR dB", w.psnr[i], 1)});
      series.points.push_back({w.ms[i], w.psnr[i]});
    }
    plot.series.push_back(std::move(series));
  }
  report.table(scene + how, rows);
  report.plot(concat("equal-", name), plot);
}

std::vector<Row> equal_rows(const std::string& scene, const std::vector<Way>& ways, double draft_ms,
                            double normal_ms) {
  std::vector<Row> rows;
  const auto or_none = [](const std::string& name, std::optional<double> value, int digits) {
    return word(name, value ? number(*value, digits) : "");
  };
  for (const Way& w : ways) {
    Row row{word("scene", scene), word("way", w.name)};
    for (const double goal : goals)
      row.push_back(or_none(concat("ms to ", goal, " dB"), time_to_reach(w, goal), 1));
    row.push_back(figure("best dB", *std::max_element(w.psnr.begin(), w.psnr.end()), 1));
    row.push_back(or_none(concat("dB in draft's time"), psnr_within(w, draft_ms), 1));
    row.push_back(or_none(concat("dB in normal's time"), psnr_within(w, normal_ms), 1));
    rows.push_back(std::move(row));
  }
  return rows;
}

Row ratio_row(const std::string& scene, const std::vector<Way>& ways) {
  Row row{word("scene", scene)};
  for (const double goal : goals) {
    std::optional<double> splatter;
    for (const Way& w : ways)
      if (const auto ms = time_to_reach(w, goal); !w.rays && ms)
        splatter = std::min(splatter.value_or(*ms), *ms);
    for (const Way& w : ways) {
      if (!w.rays) continue;
      const auto ms = time_to_reach(w, goal);
      row.push_back(word(concat(w.name.substr(w.name.find(' ') + 1), ", ", goal, " dB"),
                         splatter && ms ? number(*ms / *splatter, 2)
                         : splatter     ? "never"
                         : ms           ? "only rays"
                                        : ""));
    }
  }
  return row;
}

} // namespace bccsplat::bench
