// SPDX-License-Identifier: Apache-2.0
// Suite `fit`: import onto the lattice - speed against a memory copy, accuracy, samples kept.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

//   fit [--speed] [--accuracy] [--kept] [--round-trip] [--rate] [--lowpass] [--ends] [--held-out] [--real]
//       [--data DIR]
//     all tables but --real without a choice; DIR has the real sets of --ends (theirs beside known fields),
//     --held-out and --real (its generated ones beside them)
//   fit --ends --axis x|y|z|t
//     waves that go round along it: mirrored, predicted and periodic ends
//   fit --raw FILE --dims X,Y,Z,T --dtype u8|u16|f32
//     the same on a raw series, x fastest: error against bytes (--rate: this alone), its ends (--ends), round
//     trip with the ringing kept and dropped, samples kept, speed
// Returns the exit status; throws Error on wrong arguments.
int run_fit_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
