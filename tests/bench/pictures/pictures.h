// SPDX-License-Identifier: Apache-2.0
// Suite `pictures`: what the eye minds in pictures drawn by the defaults, where what is to be seen is known.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

//   pictures [--plateaus] [--light] [--background] [--data DIR]    all parts without an option; DIR: real
//   sets, too
int run_pictures_suite(std::span<const std::string> args, const Report& report);

// Glitter where the field is constant. folder: of real sets; empty: none.
void pictures_plateaus(const std::string& folder, const Report& report);
// The light of a smooth object far from the base, at all qualities and levels. No real sets.
void pictures_light(const std::string& folder, const Report& report);
// What is to be seen where nothing is.
void pictures_background(const std::string& folder, const Report& report);

} // namespace bccsplat::bench
