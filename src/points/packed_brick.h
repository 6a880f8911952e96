// SPDX-License-Identifier: Apache-2.0
// A brick of samples that no file holds, as whole numbers (whole_numbers.h): what coefficients are made of
// waits in this form until all in their reach is there.
#pragma once

#include <cstdint>
#include <memory>

#include "points/whole_numbers.h"

namespace bccsplat {

class PackedBrick final : public CodedBrick {
 public:
  // Returns null where the values fit no form. finest, coarsest: as of number_form.
  [[nodiscard]] static std::shared_ptr<const PackedBrick> pack(const Brick& brick, float finest,
                                                               float coarsest);

  void read(const PlanePart& part, float* to, std::ptrdiff_t stride) const override;
  [[nodiscard]] const BrickMask* kept() const override { return masks_.kept.get(); }
  [[nodiscard]] const BrickMask* hole() const override { return masks_.hole.get(); }
  [[nodiscard]] uint64_t bytes() const override;
  [[nodiscard]] const NumberForm& form() const { return form_; }

 private:
  NumberForm form_;
  std::unique_ptr<const uint8_t[]> numbers_;
  BrickMasks masks_;
};

} // namespace bccsplat
