// SPDX-License-Identifier: Apache-2.0
// Stands in for the samples of a file and notes which of them are asked for: a rehearsal with it tells which
// bytes the work will take.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "formats/bcc4/bcc4.h"

namespace bccsplat {

class RecordedReads final : public SampleSource {
 public:
  // The samples must outlive this.
  explicit RecordedReads(const Bcc4Samples& samples) : samples_(samples) {}

  const Lattice4& lattice() const override { return samples_.lattice(); }
  int channels() const override { return samples_.channels(); }
  float air(int channel) const override { return samples_.air(channel); }
  float base(int channel) const override { return samples_.base(channel); }
  const std::string& coefficient_kernel() const override { return samples_.coefficient_kernel(); }
  // Returns a layer without bricks.
  BrickLayer read_layer(int channel, int32_t layer, const BrickBox& region,
                        const Context& context) const override;

  // Appends where the bytes are that these samples take, unmerged; missing: as in Bcc4Samples::list_reads.
  void list(bool missing, std::vector<ByteRange>& out) const;

 private:
  struct Read {
    int channel;
    int32_t layer;
    Int3 begin, end;
    bool operator<(const Read& other) const {
      return std::tie(channel, layer, begin, end) <
             std::tie(other.channel, other.layer, other.begin, other.end);
    }
  };
  const Bcc4Samples& samples_;
  mutable std::mutex mutex_;
  mutable std::set<Read> reads_;
};

} // namespace bccsplat
