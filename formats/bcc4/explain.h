#pragma once

#include <span>
#include <string>

#include "formats/bcc4/bcc4.h"

namespace bccsplat {

// "; lost: channel density, samples x 0 to 31 ... of frames 3 to 9", or nothing where no sample is.
[[nodiscard]] std::string describe_loss(const VolumeInfo& info, const Bcc4Damage& damage);
// The frames that read as if nothing had happened, with the file's kernel: no lost layer in its reach.
[[nodiscard]] std::string describe_survivors(const VolumeInfo& info, std::span<const Bcc4Damage> damage);

} // namespace bccsplat
