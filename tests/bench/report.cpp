// SPDX-License-Identifier: Apache-2.0
// Writes tables as Markdown or JSON lines, has gnuplot draw plots, and takes processor times, of which the
// median counts.
#include "tests/bench/report.h"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <memory>

#include <hwy/targets.h>

#include "base/error.h"
#include "base/files.h"

namespace bccsplat::bench {

std::string number(double value, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

Field word(std::string name, std::string text) { return {std::move(name), std::move(text), true}; }
Field figure(std::string name, double value, int digits) { return {std::move(name), number(value, digits)}; }

void Report::table(const std::string& title, const std::vector<Row>& rows) const {
  if (rows.empty()) return;
  if (json) {
    for (const Row& row : rows) {
      out << R"({"suite": ")" << suite << R"(", "table": ")" << title << '"';
      for (const Field& f : row) {
        const bool text = f.quoted || f.text.find_first_of("ni") != std::string::npos; // nan, inf
        out << ", \"" << f.name << "\": " << (text ? "\"" : "") << f.text << (text ? "\"" : "");
      }
      out << "}\n";
    }
    out.flush();
    return;
  }
  out << "\n" << title << "\n\n|";
  for (const Field& f : rows.front()) out << ' ' << f.name << " |";
  out << "\n|";
  for (size_t i = 0; i < rows.front().size(); ++i) out << "---|";
  out << "\n";
  for (const Row& row : rows) {
    out << '|';
    for (const Field& f : row) out << ' ' << f.text << " |";
    out << "\n";
  }
  out.flush();
}

namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

} // namespace

void Report::plot(const std::string& name, const Plot& plot) const {
  if (plots.empty()) return;
  std::filesystem::create_directories(plots);
  const std::string file = (plots / (suite + "-" + name + ".png")).string();
  const std::unique_ptr<FILE, int (*)(FILE*)> gnuplot(::popen("gnuplot", "w"), ::pclose);
  if (!gnuplot) fail(Code::unsupported, "plots need gnuplot (Debian: gnuplot-nox)");
  // gnuplot has eight colours of its own.
  std::string text =
      "set terminal pngcairo size 1200,560 noenhanced font 'Sans,12' background '#ffffff'\n"
      "set key at screen 0.665, screen 0.75 left top Left reverse\nset lmargin at screen 0.07\n"
      "set rmargin at screen 0.65\nset grid\nset linetype cycle 12\n"
      "set linetype 9 lc rgb '#8c564b'\nset linetype 10 lc rgb '#7f7f7f'\n"
      "set linetype 11 lc rgb '#bcbd22'\nset linetype 12 lc rgb '#17becf'\n";
  text += "set output " + quoted(file) + "\nset title " + quoted(plot.title) + " font ',11'\nset xlabel " +
          quoted(plot.x_label) + "\nset ylabel " + quoted(plot.y_label) + "\n";
  if (plot.log_x) text += "set logscale x\n";
  if (plot.log_y) text += "set logscale y\n";
  std::string commands;
  for (size_t i = 0; i < plot.series.size(); ++i) {
    const Series& s = plot.series[i];
    text += "$data" + std::to_string(i) + " << EOD\n";
    for (size_t k = 0; k < s.points.size(); ++k)
      text += concat(s.points[k][0], ' ', s.points[k][1], ' ', quoted(k < s.labels.size() ? s.labels[k] : ""),
                     '\n');
    text += "EOD\n";
    const std::string data = (commands.empty() ? "plot $data" : ", $data") + std::to_string(i);
    commands += data + " using 1:2 with " + (s.line ? "linespoints" : "points") + " lt " +
                std::to_string(i % 12 + 1) + " pt " + std::to_string(i % 12 + 4) + " lw 2 ps 1.4 title " +
                quoted(s.title);
    if (!s.labels.empty())
      commands +=
          ", $data" + std::to_string(i) + " using 1:2:3 with labels offset 0.5,0.7 left font ',9' notitle";
  }
  text += commands + "\n";
  const bool written = std::fwrite(text.data(), 1, text.size(), gnuplot.get()) == text.size();
  if (!written || std::fflush(gnuplot.get()) != 0)
    fail(Code::io_error, file, ": gnuplot did not take the plot");
}

double cpu_seconds(const std::function<void()>& body) {
  const std::clock_t begin = std::clock();
  body();
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

double median_cpu_seconds(const std::function<void()>& body, int repeats) {
  return paired_cpu_seconds(
      body, [] {}, repeats)[0];
}

std::array<double, 2> paired_cpu_seconds(const std::function<void()>& first,
                                         const std::function<void()>& second, int repeats) {
  std::array<std::vector<double>, 2> times;
  for (int i = 0; i < repeats; ++i) {
    times[0].push_back(cpu_seconds(first));
    times[1].push_back(cpu_seconds(second));
  }
  for (std::vector<double>& t : times) std::sort(t.begin(), t.end());
  return {times[0][times[0].size() / 2], times[1][times[1].size() / 2]};
}

std::string machine_facts() {
  std::string processor = "unknown processor";
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) {
      processor = line.substr(line.find(':') + 2);
      break;
    }
  const int64_t best = hwy::SupportedTargets() & -hwy::SupportedTargets();
  return concat(processor, ", ", hwy::TargetName(best), ", compiler ", __VERSION__);
}

} // namespace bccsplat::bench
