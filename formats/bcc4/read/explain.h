// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "formats/bcc4/read/reader.h"

namespace bccsplat {

// Returns "; lost: channel density, samples x 0 to 31 ... of frames 3 to 9", or nothing when no sample is
// lost.
[[nodiscard]] std::string describe_loss(const VolumeInfo& info, const Bcc4Damage& damage);
// Returns the frames that read, at level 0, as if nothing had happened: those with no lost layer within reach
// of the file's kernel.
[[nodiscard]] std::string describe_survivors(const VolumeInfo& info, std::span<const Bcc4Damage> damage);

} // namespace bccsplat
