// SPDX-License-Identifier: Apache-2.0
// Several deep pictures of one view as one flat picture, right in depth: where samples overlap their
// extinctions add, and their colours mix by them.
#pragma once

#include <span>

#include "base/context.h"
#include "draw/deep.h"
#include "draw/image.h"

namespace bccsplat {

// Fills the planes rgba and depth, where a pixel becomes so opaque, of an image of the same size. Throws
// cancelled.
void merge_deep(std::span<const DeepImage* const> pictures, double depth_opacity, const Context& context,
                Image& image);

} // namespace bccsplat
