// SPDX-License-Identifier: Apache-2.0
// How much less accurate a volume is near its faces, edges and corners than inside, and how far planes
// outside mend that.
#pragma once

#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

// Plane waves by distance from the faces: values and gradients, with faces mirrored and predicted; the air
// beside a cloud that touches a face; and what planes outside take.
void report_faces(const Report& report);
// Real sets: a box of them against the same box with more around it, whose field is the truth.
void report_faces(const std::string& folder, const Report& report);

} // namespace bccsplat::bench
