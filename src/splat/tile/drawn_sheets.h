// SPDX-License-Identifier: Apache-2.0
// The sheets of a tile that a field is classified from: those of one object, or the weighted sums of several.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "splat/sheet/matter.h"
#include "splat/tile/finished_sheets.h"
#include "splat/tile/sheet_source.h"

namespace bccsplat {

// Planes of a mixed gradient, which serve one sheet at a time.
inline constexpr size_t gradient_planes = 3;

// What all sheets of a tile have in common.
struct DrawnSources {
  std::span<const SheetSource> object; // their sheets are alike
  const MatterLoops* loops = nullptr;
  int64_t first_sheet = 0; // of the view
  int height = 0;          // of the tile
  int border = 0, plane_pitch = 0;
  int halfway = 0;        // sheets on either side that segments look at where there are integrals
  bool gradients = false; // by the kernel's own
  [[nodiscard]] std::ptrdiff_t border_floats() const { return border * plane_pitch + border; }
  // Floats that one who mixes needs, in planes that start out as numbers: whole vectors are read, also
  // between the planes.
  [[nodiscard]] size_t mixed_floats() const {
    return (finished_sheets + (gradients ? gradient_planes : 0)) * object.front().plane_floats();
  }
};

class DrawnSheets {
 public:
  // base: of the field; base_seen: whether samples that no point reaches are looked at. `mixed` has room for
  // mixed_floats() where there are several shares, and is not looked at else. Everything passed by reference
  // or pointer must outlive the sheets.
  DrawnSheets(const DrawnSources& sources, std::span<const SheetShare> shares, const ClassTable& table,
              float base, bool base_seen, float* mixed);

  // The object that the lattice, the rays and the view are of.
  [[nodiscard]] size_t object() const { return shares_.front().source; }

  // Makes the weighted sums of the values of sheets first .. last, which the objects have completed. It does
  // nothing where the sheets are an object's own, and so does the next.
  void mix(int64_t first, int64_t last);
  // Makes those of the gradient's sums of sheet k, of which there is one set of planes.
  void mix_gradients(int64_t k);

  // Returns a plane as SheetSource::plane does.
  [[nodiscard]] const float* plane(int64_t k, size_t quantity) const;
  // Returns the pixels of the tile outside of which the segments of sheet k are nothing but the base of the
  // field.
  [[nodiscard]] PixelRect touched(int64_t k) const;
  [[nodiscard]] bool sees_base() const { return base_seen_; }
  // Returns whether anything may be seen on sheet k.
  [[nodiscard]] bool seen(int64_t k) const;

 private:
  [[nodiscard]] const SheetSource& own() const { return sources_.object[object()]; }
  [[nodiscard]] float* mixed_plane(int64_t k, size_t quantity) const;
  [[nodiscard]] std::array<int64_t, 2> looked_at(int64_t k) const;
  std::array<float, 2> mix_plane(int64_t k, size_t quantity, const PixelRect& before);
  void mix_values(int64_t k);

  const DrawnSources& sources_;
  std::span<const SheetShare> shares_;
  const ClassTable& table_;
  float base_;
  bool base_seen_;
  float* mixed_; // null: the sheets are an object's own
  // The smallest and largest value of each mixed sheet, relative to the base; where it is not zero, in pixels
  // of the whole plane; and whether anything is on it.
  FinishedSheets<std::array<float, 2>> range_{};
  FinishedSheets<PixelRect> touched_{};
  FinishedSheets<bool> filled_{};
  PixelRect gradients_touched_{}; // of the planes of gradients
  std::vector<const float*> from_;
  std::vector<float> weights_;
};

} // namespace bccsplat
