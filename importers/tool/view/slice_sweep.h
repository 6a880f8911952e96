// SPDX-License-Identifier: Apache-2.0
// --sweep A:B,N: a hyperplane moved along its normal, one slice after the other.
#pragma once

#include <string>
#include <vector>

#include "tool/view/slice_choice.h"

namespace bcc4 {

// "A:B,N"; "A,B,N" will do.
void add_sweep(const Command& command, SliceChoiceArguments& arguments);
// The hyperplane alone, as one cut of all, without --sweep; else N of them, offset along the unit normal by A
// to B, both included.
[[nodiscard]] std::vector<Cut> sweep(const Volume& volume, const SliceChoiceArguments& arguments);
// The output alone for one; else its pattern (such as slice.%03d.nrrd) numbered from 0.
[[nodiscard]] std::vector<std::string> sweep_names(const std::string& output, size_t count);

} // namespace bcc4
