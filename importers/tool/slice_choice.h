// --time, --index and --plane: which hyperplane.
#pragma once

#include <optional>

#include "tool/cli.h"
#include "tool/handles.h"

namespace bcc4 {

struct SliceChoiceArguments {
  std::optional<double> time;
  bool index = false;
  std::optional<std::vector<double>> plane; // a, b, c, d, e
};
void add_slice_choice(CLI::App& app, SliceChoiceArguments& arguments);

struct Cut {
  double plane[5]{};
  bool is_time_slice = true;
  double index = 0; // of a time slice
  double time = 0;  // of a time slice, in the file's unit
};
// A file of one frame needs neither option.
[[nodiscard]] Cut resolve(const Volume& volume, const SliceChoiceArguments& arguments);
[[nodiscard]] Cut cut_at_index(const Volume& volume, double index);

} // namespace bcc4
