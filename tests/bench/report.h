// SPDX-License-Identifier: Apache-2.0
// What every suite of the benchmark prints with: tables as Markdown or JSON lines, plots as PNG.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

namespace bccsplat::bench {

// One cell of a table, kept as text.
struct Field {
  std::string name, text;
  bool quoted = false; // a string in JSON
};
using Row = std::vector<Field>; // the same names in every row of a table

[[nodiscard]] std::string number(double value, int digits);
[[nodiscard]] Field word(std::string name, std::string text);
[[nodiscard]] Field figure(std::string name, double value, int digits);

struct Series {
  std::string title;
  std::vector<std::array<double, 2>> points;
  bool line = true;                // else marks alone
  std::vector<std::string> labels; // beside the points; empty, or one each
};

struct Plot {
  std::string title, x_label, y_label;
  bool log_x = false, log_y = false;
  std::vector<Series> series;
};

struct Report {
  std::ostream& out;
  std::string suite;
  bool json = false;
  bool quick = false;          // small inputs: the suite works, its times mean little
  std::filesystem::path plots; // folder of the PNGs; empty: none

  void table(const std::string& title, const std::vector<Row>& rows) const;
  // DIR/SUITE-NAME.png, 1000 x 700, through gnuplot; nothing without a folder. Throws Error when gnuplot is
  // missing.
  void plot(const std::string& name, const Plot& plot) const;
};

// CPU time of the process, in seconds: other programs on the machine do not count.
[[nodiscard]] double cpu_seconds(const std::function<void()>& body);
[[nodiscard]] double median_cpu_seconds(const std::function<void()>& body, int repeats = 5);
// Times two bodies in turn, so that both see the same machine; median of each.
[[nodiscard]] std::array<double, 2> paired_cpu_seconds(const std::function<void()>& first,
                                                       const std::function<void()>& second, int repeats = 5);

// Compiler, vector instructions, processor: the line above every report.
[[nodiscard]] std::string machine_facts();

} // namespace bccsplat::bench
