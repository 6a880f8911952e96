// SPDX-License-Identifier: Apache-2.0
// Colours for blending: linear light, display sRGB, and the spaces ParaView's maps are blended in.
#pragma once

#include <array>

namespace bcc4 {

using Color = std::array<double, 3>;

[[nodiscard]] double srgb_to_linear(double v); // IEC 61966-2-1
[[nodiscard]] double linear_to_srgb(double v);

enum class BlendSpace { rgb, hsv, lab, diverging };
// Between two display colours, t in [0, 1]. diverging: K. Moreland, Diverging Color Maps for Scientific
// Visualization (2009), through white when the hues are far apart.
[[nodiscard]] Color blend(const Color& a, const Color& b, double t, BlendSpace space);

} // namespace bcc4
