#include "tool/slice_choice.h"

#include <algorithm>

#include "tool/time_slice.h"

namespace bcc4 {

void add_slice_choice(CLI::App& app, SliceChoiceArguments& a) {
  add_number(app, "--time", a.time, "Time of the slice, in the file's unit");
  app.add_flag("--index", a.index, "--time is a frame number, fractions allowed");
  app.add_option_function<std::string>(
         "--plane", [&a](const std::string& text) { a.plane = option_numbers("--plane", text, 5); },
         "Hyperplane a x + b y + c z + d t + e = 0, in samples and frames")
      ->type_name("a,b,c,d,e");
}

Cut cut_at_index(const Volume& volume, double index) {
  Cut cut;
  cut.plane[3] = 1;
  cut.plane[4] = -index;
  cut.index = index;
  check(bccsplat_volume_index_to_time(volume.get(), index, &cut.time), "");
  return cut;
}

Cut resolve(const Volume& volume, const SliceChoiceArguments& a) {
  if (a.plane) {
    if (a.time || a.index) fail_usage("--plane and --time exclude each other");
    Cut cut;
    cut.is_time_slice = (*a.plane)[0] == 0 && (*a.plane)[1] == 0 && (*a.plane)[2] == 0;
    std::copy(a.plane->begin(), a.plane->end(), cut.plane);
    if (cut.is_time_slice && (*a.plane)[3] == 0) fail_usage("--plane: a, b, c and d must not all be 0");
    if (cut.is_time_slice)
      return cut_at_index(volume, frame_index(volume, -(*a.plane)[4] / (*a.plane)[3], true));
    return cut;
  }
  if (!a.time) {
    if (volume_info(volume).dims[3] == 1) return cut_at_index(volume, 0);
    fail_usage("--time T or --plane a,b,c,d,e is missing");
  }
  return cut_at_index(volume, frame_index(volume, *a.time, a.index));
}

} // namespace bcc4
