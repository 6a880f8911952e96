// SPDX-License-Identifier: Apache-2.0
// A slice cut out of an open volume: what it was cut with, its field, and what can be read from it.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "field/evaluate.h"
#include "field/sample_grid.h"
#include "field/slice.h"
#include "slice/extraction.h"
#include "slice/hyperslice.h"
#include "volume/open_volume.h"

namespace bccsplat {

// A cut that is asked for.
struct SliceRequest {
  uint32_t channel = 0, level = 0;
  Hyperplane plane;
  HypersliceOptions cut;
  std::shared_ptr<const Coefficients> coefficients;
};

// Fails with not_found where there is no such channel, level or kernel. Labels are cut at level 0, always.
// kernel: null or "" for the volume's.
// keep: as of OpenVolume::coefficients.
[[nodiscard]] SliceRequest request_slice(const OpenVolume& volume, uint32_t channel, const char* kernel,
                                         uint32_t level, const Hyperplane& plane,
                                         const HypersliceOptions& cut, bool keep = true);

// Returns the plan of a cut as it is made (as_cut, labels.h), and those of the frames that it follows.
[[nodiscard]] std::vector<CutPlan> plans_of(const OpenVolume& volume, const SliceRequest& made);

struct OpenSlice {
  uint32_t channel = 0, level = 0;
  Slice slice;           // its field is that of the points where these are extracted
  HypersliceOptions cut; // what it was cut with
  std::shared_ptr<const Extraction> extraction;
  Reservation memory;

  // Returns the extent in slice space: the bounding box of the domain; a box as it was asked for.
  [[nodiscard]] std::array<std::array<double, 2>, 3> extent() const;
  [[nodiscard]] std::array<double, 2> bounds() const {
    return extraction ? extraction->bounds() : slice.bounds;
  }
  [[nodiscard]] uint64_t points() const {
    return extraction ? extraction->points() : static_cast<uint64_t>(slice.points());
  }
  // Returns the samples that cover the extent, one lattice unit apart.
  [[nodiscard]] Grid own_grid() const;
  // Fills values, and gradients unless there are none; NaN where nothing is.
  EvaluateMisses evaluate(std::span<const Vec3> points, std::span<float> values,
                          std::span<std::array<float, 3>> gradients, const Context& context) const;
  void sample(const Grid& grid, float* values, const Context& context) const;
  // Lists up to `capacity` points; returns how many there are.
  uint64_t list(uint64_t capacity, float* uvw, float* coefficients, Progress& progress) const;
};

[[nodiscard]] OpenSlice cut_slice(const OpenVolume& volume, const SliceRequest& request,
                                  const Context& context);

// Reads and prepares what the cut needs.
void prefetch_slice(const OpenVolume& volume, const SliceRequest& request, const Context& context);

} // namespace bccsplat
