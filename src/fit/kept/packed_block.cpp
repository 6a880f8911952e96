// SPDX-License-Identifier: Apache-2.0
#include "fit/kept/packed_block.h"

#include <cmath>

#include "points/brick.h"

namespace bccsplat {
namespace {

template<class Block>
SiteBlockPtr packed_as(const NumberForm& form, const FloatSites& from, BlockPool<Block>& pool) {
  auto made = pool.take();
  made->source = from.source, made->near = from.near;
  made->largest = from.largest;
  made->form = form;
  made->number = made->room.data();
  write_numbers(form, from.value.data(), made->number);
  return made;
}

} // namespace

float packing_unit(const Quantiser& quantiser) {
  if (is_float(quantiser.type)) return 0;
  const double unit = std::exp2(std::floor(std::log2(quantiser.scale / 64)));
  return unit > 1e-30 && unit < 1e30 ? static_cast<float>(unit) : 0;
}

SiteBlockPtr pack(FloatSitesPtr block, const Int3& size, float unit, SiteBlockPool& pool) {
  if (unit == 0) return block;
  const NumberForm form = number_form(block->value.data(), size, unit, coarsest_unit(unit));
  if (form.bits == 0) return block;
  return form.bits == 12 ? packed_as(form, *block, pool.shorter) : packed_as(form, *block, pool.longer);
}

const float* plane_of(const SiteBlock& block, int z, float* room) {
  if (!block.packed) return static_cast<const FloatSites&>(block).value.data() + z * brick_rows;
  const auto& packed = static_cast<const PackedSites&>(block);
  read_numbers(packed.form, packed.number, {.plane = z}, room, brick_edge);
  return room;
}

float value_of(const SiteBlock& block, int site) {
  if (!block.packed) return static_cast<const FloatSites&>(block).value[site];
  const auto& packed = static_cast<const PackedSites&>(block);
  const int row = site / brick_edge;
  std::array<float, brick_edge> values;
  read_numbers(
      packed.form, packed.number,
      {.plane = row / brick_edge, .x = site % brick_edge, .y = row % brick_edge, .width = 1, .height = 1},
      values.data(), brick_edge);
  return values[0];
}

} // namespace bccsplat
