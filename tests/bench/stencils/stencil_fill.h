// SPDX-License-Identifier: Apache-2.0
// Sheets of samples as stencils of the coefficients.
//
// Samples of one phase stand alike to the sites around them, so that each is the same weighted sum of the
// sites at the same places: rows of samples are sums of rows of sites. The weights of a phase sum to 1.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/loop/loops.h"
#include "tests/bench/stencils/site_array.h"
#include "tests/bench/stencils/stencil_view.h"

namespace bccsplat::bench {

struct StencilTap {
  std::ptrdiff_t site; // of the first sample of the row, floats into the array
  float weight[2];     // for the samples of even and of odd number
};

// The taps of the samples of both phases along u: those that both have, then those of either.
struct RowStencil {
  std::vector<StencilTap> taps;
  size_t both = 0, even = 0;   // the rest is of odd samples
  std::array<double, 2> sum{}; // of the kernel at the taps of either phase, before it is made 1
};

// One row of samples: sums of rows that begin at `sites` + StencilTap::site.
struct RowArgs {
  const float* sites = nullptr;
  const RowStencil* stencil = nullptr;
  float* row = nullptr; // 32 samples at a time are written
  int count = 0;
};
void fill_row_reference(const RowArgs& args);
void fill_row(const RowArgs& args); // best target of this machine

// Samples [first_u, first_u + width) x [first_v, first_v + height) of one sheet.
struct SampleSheet {
  int64_t k = 0;
  int first_u = 0, first_v = 0;
  float* samples = nullptr;
};

class SampleSheets {
 public:
  // Sheets first .. last of the view, `margin` planes beyond the domain included.
  void begin(const Slice& slice, const StencilView& view, const SiteArray& sites, KernelForm form,
             int64_t first, int64_t last, double margin);
  // Makes the samples of all of them; the memory is kept.
  void fill(bool reference = false);
  // Makes samples of sheet k in a window, rows of `pitch` floats, as far as the sheet reaches; whole vectors
  // are written. Moves the window's first sample by less than a coset pitch, to one that a stencil begins at.
  void fill_window(int64_t k, int width, int height, int pitch, SampleSheet& window) const;

  // Sheets that are not there are as their nearest.
  [[nodiscard]] const SampleSheet& sheet(int64_t k) const { return sheets_[place(k)]; }
  [[nodiscard]] const std::vector<SampleSheet>& all() const { return sheets_; }
  // Of one of all(): what the weights of sample (x, y) came to before they were made to sum to 1.
  [[nodiscard]] double sum(const SampleSheet& sheet, int x, int y) const;
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] int pitch() const { return pitch_; }
  [[nodiscard]] uint64_t samples() const;
  [[nodiscard]] uint64_t bytes() const { return floats_ * sizeof(float); }
  [[nodiscard]] double taps_per_sample() const { return taps_; } // in the mean

  // Floats before the first row and behind the last one that raising may read, and which are numbers.
  static constexpr int spare = 96;

 private:
  [[nodiscard]] size_t place(int64_t k) const;
  void fill_rows(size_t sheet, int u, int v, int width, int height, float* to, int pitch,
                 bool reference) const;

  const float* sites_ = nullptr;
  std::ptrdiff_t site_row_ = 0;
  int phases_ = 2;
  std::vector<SampleSheet> sheets_;
  std::vector<RowStencil> stencils_; // for each sheet one per phase along v
  int width_ = 0, height_ = 0, pitch_ = 0;
  AlignedArray<float> memory_;
  size_t floats_ = 0;
  double taps_ = 0;
};

} // namespace bccsplat::bench
