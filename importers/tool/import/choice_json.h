// SPDX-License-Identifier: Apache-2.0
// What was chosen for a series, and what it was chosen by, as JSON with stable keys.
#pragma once

#include "choose/lattice_choice.h"
#include "choose/search.h"
#include "choose/spectrum.h"
#include "tool/import/turn.h"
#include "tool/json_fwd.h"

namespace bcc4 {

[[nodiscard]] Json spectrum_json(const Spectrum& spectrum);
[[nodiscard]] Json choice_json(const LatticeChoice& choice, const SeriesDescription& series);
[[nodiscard]] Json search_json(const CodingSearch& search, const SeriesDescription& series);
[[nodiscard]] Json turn_json(const Turn& turn);

} // namespace bcc4
