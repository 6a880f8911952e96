// SPDX-License-Identifier: Apache-2.0
// Sheets that hold fewer samples than the picture has pixels, and the filter that raises them to its pixels.
//
// A kernel leaves little above half a cycle per T, so that a magnified picture is drawn as well from 1.5 to 2
// samples per T and axis. Sample I of an axis lies at pixel offset + I * ratio of the picture, whatever the
// tile. A pixel is the weighted sum of the nearest `taps` samples along each axis; its weights are those that
// come closest, in the mean square over the band, to the wave that the samples describe (weights fall to
// nothing at the band's edge, where fields hold little), among those that reproduce constants.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace bccsplat {

inline constexpr int most_taps = 8;

// How finely sheets are sampled and how they are raised; taps 0: they are drawn at the picture's pixels.
struct RaiseFilter {
  int taps = 0;       // 4, 6 or 8
  double density = 0; // samples per T
  // Raising is cheaper from this many pixels per sample on, where the sheets are isotropic and elsewhere
  // (perspective, shear); at least 1.
  double from = 1, from_general = 1;
  // Samples per T along the sheets' normal, where sheets are closer than half of that and rays run side by
  // side: sheets are raised from fewer ones in the same way; 0: never.
  double depth = 0;
  // The same for the fan that perspective is raised from (raise_fan.h), halfway between first and last sheet.
  double from_fan = 1.12;
  bool operator==(const RaiseFilter&) const = default;
};

// Sets the weights of the samples -(taps / 2 - 1) .. taps / 2 for a pixel that lies `phase`, 0 .. 1, of a
// sample beyond sample 0. band is in cycles per sample.
void raise_weights(int taps, double band, double phase, double* weight);

// The pixels of one axis.
struct RaiseAxis {
  double ratio = 1;            // pixels per sample, at least 0.6
  double offset = 0;           // where sample 0 lies, pixels
  int first = 0;               // pixel that the tables start with
  size_t pitch = 0;            // entries per tap: the pixels and 16 more, as the last
  std::vector<int32_t> sample; // the first one of each pixel
  std::vector<float> weight;   // [tap][pixel]

  // The first sample of a pixel.
  [[nodiscard]] int32_t at(int pixel) const { return sample[pixel - first]; }
};
[[nodiscard]] RaiseAxis make_raise_axis(double ratio, double density, int taps, int first, int count,
                                        double offset = 0);

// A sheet's pixels columns [x0, x1), rows [y0, y1) of the tile's plane.
struct RaiseArgs {
  int taps = 0;
  const float* sheet = nullptr; // its sample at the start of the tile's ring
  int sheet_pitch = 0;          // 16 floats after every row may be read
  float* plane = nullptr;       // of pixel column 0, row 0
  int plane_pitch = 0;          // whole vectors are written
  int x0 = 0, x1 = 0, y0 = 0, y1 = 0;
  // First samples, relative to `origin`, and weights of plane column and row 0.
  const int32_t *sample_x = nullptr, *sample_y = nullptr;
  int origin_x = 0, origin_y = 0;
  const float *weight_x = nullptr, *weight_y = nullptr;
  size_t weight_pitch_x = 0, weight_pitch_y = 0; // from tap to tap
  float* scratch = nullptr;                      // raise_rows rows of scratch_pitch floats
  int scratch_pitch = 0;                         // at least the samples of a row and 32
};
inline constexpr int raise_rows = 16; // raised along y before they are along x

// The weighted sum of `taps` planes, rows of `pitch` floats: columns [x0, x1), rows [y0, y1). Whole vectors
// are read and written.
struct BlendArgs {
  int taps = 0;
  const float* plane[most_taps] = {};
  float weight[most_taps] = {};
  int pitch = 0;
  float* out = nullptr;
  int out_pitch = 0;
  int x0 = 0, x1 = 0, y0 = 0, y1 = 0;
};
void blend_reference(const BlendArgs& args);
void blend_planes(const BlendArgs& args); // best target of this machine

void raise_reference(const RaiseArgs& args);
void raise_sheet(const RaiseArgs& args); // best target of this machine

} // namespace bccsplat
