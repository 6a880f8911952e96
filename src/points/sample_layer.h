// SPDX-License-Identifier: Apache-2.0
// A layer in the form that takes least memory: samples as the codes that a file holds, coefficients as
// rounded numbers (rounded_brick.h), or values. What reads many layers makes values of codes where it needs
// them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "points/brick.h"

namespace bccsplat {

// Some sites of a plane of a brick: rows y .. y + height - 1, of each the sites x .. x + width - 1.
struct PlanePart {
  int plane = 0, x = 0, y = 0, width = brick_edge, height = brick_edge;
};

// Which sites of a brick are kept and which are holes, beside its codes.
struct BrickMasks {
  std::unique_ptr<const BrickMask> kept; // null: all sites
  std::unique_ptr<const BrickMask> hole; // null: no holes

  BrickMasks() = default;
  explicit BrickMasks(const Brick& brick);
  [[nodiscard]] uint64_t bytes() const { return (kept ? sizeof *kept : 0) + (hole ? sizeof *hole : 0); }
};

// A brick whose sites are held as codes.
class CodedBrick {
 public:
  virtual ~CodedBrick() = default;
  // Writes values as a Brick has them, rows `stride` apart; behind rows of fewer than 16 sites up to 15 more
  // are written.
  virtual void read(const PlanePart& part, float* to, std::ptrdiff_t stride) const = 0;
  [[nodiscard]] virtual const BrickMask* kept() const = 0; // null: all sites
  [[nodiscard]] virtual const BrickMask* hole() const = 0; // null: no holes
  [[nodiscard]] virtual uint64_t bytes() const = 0;
};

// Values or codes; air where it has neither.
struct SampleBrick {
  std::shared_ptr<const Brick> values;
  std::shared_ptr<const CodedBrick> codes;

  explicit operator bool() const { return values || codes; }
  [[nodiscard]] const BrickMask* hole() const {
    if (values) return values->hole.get();
    return codes ? codes->hole() : nullptr;
  }
  // Returns the sites kept of a brick that is not air; null: all sites.
  [[nodiscard]] const BrickMask* kept() const { return values ? &values->kept : codes->kept(); }
  [[nodiscard]] uint64_t bytes() const;
  // Returns all values of a brick that is not air; `room` is for those of codes.
  [[nodiscard]] const float* all(std::array<float, brick_sites>& room) const;
  // Returns a brick of values; null where all is air.
  [[nodiscard]] std::shared_ptr<const Brick> as_values() const;
};

class SampleLayer : public BrickSlots<SampleBrick> {
 public:
  using BrickSlots::BrickSlots;
  explicit SampleLayer(const BrickLayer& values);

  // The same layer of values.
  [[nodiscard]] BrickLayer as_values() const;
  [[nodiscard]] const SampleBrick& brick(size_t slot) const { return share(slot); }
  [[nodiscard]] const SampleBrick& brick(int bx, int by, int bz) const { return brick(slot(bx, by, bz)); }
  [[nodiscard]] uint64_t bytes() const; // memory held by the bricks
};

} // namespace bccsplat
