// SPDX-License-Identifier: Apache-2.0
// Forms of a radial kernel that are cheaper to draw and reproduce constants like it.
#pragma once

#include <cstdint>
#include <optional>

#include "kernel/kernel.h"

namespace bccsplat {

// phi itself, short_kernel() or flat_kernel().
enum class KernelForm : uint8_t { exact, short_form, flat_form };

// Returns whether the kernel is a_2 u^2 + ... + a_7 u^7, the form that the shorter ones are made of.
[[nodiscard]] bool is_square_8(const RadialKernel& phi);

// Returns the kernel a_2 u^2 + a_4 u^4 + a_5 u^5 nearest to phi: least mean square difference over the ball
// among those with the same integral. It takes 4 multiplications where radial kernels take 7. None where it
// would differ from phi by more than 0.002 phi(0); radial20 has one.
[[nodiscard]] std::optional<RadialKernel> short_kernel(const RadialKernel& phi);

// Returns the kernel a_2 u^2 + a_4 u^4 with the integral of phi whose spectrum is 0 at the lattice's first
// images (both lattices: 1 per unit): constants, and with them gradients of smooth data, come out without
// ripple, which shading shows before anything else. It takes 3 multiplications, and waves of more than a
// third of the Nyquist rate come out up to 4 % weaker. None where it is not about as high as phi; radial20
// has one.
[[nodiscard]] std::optional<RadialKernel> flat_kernel(const RadialKernel& phi);

// Returns the kernel in a form as it is drawn, with coefficients rounded to floats; phi in this way where it
// has no such form.
[[nodiscard]] RadialKernel drawn_kernel(const RadialKernel& phi, KernelForm form);

} // namespace bccsplat
