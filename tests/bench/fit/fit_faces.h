// SPDX-License-Identifier: Apache-2.0
// How much less accurate a volume is near its faces, edges and corners than inside, and what could be done.
#pragma once

#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

// Plane waves, and a blob that a face cuts, by distance from the face: values and gradients, as the field is
// continued today (mirrored) and as candidates would.
void report_faces(const Report& report);
// Real sets: a box of them against the same box with more around it, whose field is the truth.
void report_faces(const std::string& folder, const Report& report);

} // namespace bccsplat::bench
