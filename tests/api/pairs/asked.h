// SPDX-License-Identifier: Apache-2.0
// What a case of pairs_test.cpp asks for: a series, how its file is written, and a picture of it.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "../support.h"

namespace host::pairs {

// What a call answered that did not do what it was asked.
struct Refusal {
  bccsplat_status status;
  std::string text;
};
// What came out is not the truth.
struct Wrong {
  std::string text;
};

inline void check(bccsplat_status status) {
  if (status != BCCSPLAT_OK) throw Refusal{status, bccsplat_last_error()};
}
template<class... T> void demand(bool holds, const T&... text) {
  if (holds) return;
  std::ostringstream out;
  (out << ... << text);
  throw Wrong{out.str()};
}

enum class Data { blob, far_from_air, labels };
enum class Way { whole, parts, blocks, appended, resumed, live, layers, field };
enum class Cut { time, mean, box, oblique, axis };
enum class Drawn { renderer, scene, budget, two, masked, painted };

struct Asked {
  // The series: channel 0, and where there are two a channel of labels.
  std::array<uint32_t, 4> dims{16, 14, 13, 8};
  Data data = Data::blob;
  bccsplat_type type = BCCSPLAT_TYPE_F32;
  bool missing = false, uneven = false, unknown_length = false;
  // The file; dims, channels and axes are set when it is written.
  bccsplat_writer_options file = sized<bccsplat_writer_options>();
  bccsplat_channel_options channel = sized<bccsplat_channel_options>();
  uint32_t channels = 2;
  Way way = Way::whole;
  // The picture.
  Cut cut = Cut::time;
  Drawn drawn = Drawn::renderer;
  bccsplat_slice_options slice = sized<bccsplat_slice_options>();
  bccsplat_render_options render = sized<bccsplat_render_options>();
  std::vector<bccsplat_iso_surface> surfaces;
  bccsplat_trail trail = sized<bccsplat_trail>();
  bccsplat_lights lights = sized<bccsplat_lights>();
  bool has_trail = false, clipped = false, behind_things = false, perspective = false, in_parts = false;
  bool bricks = false;
  uint32_t planes = 0; // of the frame
  // Of errors where nothing is promised, as a share of the values' range.
  double usual_error = .12;

  [[nodiscard]] bool still() const { return dims[3] == 1; }
  [[nodiscard]] bool whole_time() const { return file.ends == BCCSPLAT_ENDS_PERIODIC; }
};

inline double label_of(double blob) { return std::floor(blob / 26); }

// A blob that goes round in x once in the series, and comes to nothing before the faces.
inline double blob_at(const Asked& a, double x, double y, double z, double t) {
  const double turn = a.still() ? 0 : 2 * M_PI * t / a.dims[3];
  const double dx = x - 7.5 - 1.2 * std::cos(turn), dy = y - 6.5 - 1.2 * std::sin(turn),
               dz = a.dims[2] == 1 ? 0 : z - 6;
  return 100 * std::exp(-(dx * dx + dy * dy + dz * dz) / 9);
}

inline bool is_missing(const Asked& a, double x, double y, double z, double t) {
  if (!a.missing) return false;
  const auto nearest = [](double v, uint32_t n) {
    return static_cast<int>(std::min(std::floor(v + .5), n - 1.0));
  };
  const int i = nearest(x, a.dims[0]), j = nearest(y, a.dims[1]), k = nearest(z, a.dims[2]),
            f = nearest(t, a.dims[3]);
  return (i > 10 && j > 9) || (7 * i + 5 * j + 3 * k + 11 * f) % 37 == 0;
}

// The truth, as the type of the source holds it.
inline double value_at(const Asked& a, uint32_t channel, double x, double y, double z, double t) {
  const double blob = blob_at(a, x, y, z, t);
  if (channel == 1) return x < a.dims[0] / 2. ? 1 : 2;
  if (is_missing(a, x, y, z, t)) return std::numeric_limits<double>::quiet_NaN();
  double v = blob;
  if (a.data == Data::labels) v = label_of(blob);
  if (a.data == Data::far_from_air) v = 1000 + blob;
  return a.type == BCCSPLAT_TYPE_F32 ? static_cast<float>(v) : std::floor(v + .5);
}

} // namespace host::pairs
