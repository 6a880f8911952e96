// SPDX-License-Identifier: Apache-2.0
// The masks and the corrections of a channel of a file, as the field asks for them.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "formats/bcc4/read/reader.h"
#include "points/correction_source.h"
#include "points/mask_source.h"

namespace bccsplat {

class Bcc4Masks final : public MaskSource {
 public:
  Bcc4Masks(std::shared_ptr<const Bcc4Reader> reader, int channel)
      : reader_(std::move(reader)), channel_(channel) {}
  const Lattice4& lattice() const override { return reader_->info().lattice; }
  std::optional<ByteRange> place(int64_t frame) const override;
  std::optional<uint64_t> told_count() const override;
  void read_runs(int64_t frame, const MaskRunBody& body) const override;
  bool goes_without(const Error& failure) const override { return reader_->goes_without(failure); }

 private:
  std::shared_ptr<const Bcc4Reader> reader_;
  int channel_;
};

class Bcc4Corrections final : public CorrectionSource {
 public:
  Bcc4Corrections(std::shared_ptr<const Bcc4Reader> reader, int channel)
      : reader_(std::move(reader)), channel_(channel) {}
  const Lattice4& lattice() const override { return reader_->info().lattice; }
  bool any() const override { return info().any(); }
  CorrectionShape shape() const override { return info().shape; }
  double step() const override { return info().step; }
  std::optional<uint64_t> told_count() const override;
  Frame read_frame(int64_t frame) const override;
  std::vector<GridValue> read_brick(const CorrectionBrick& brick) const override;
  std::vector<ByteRange> places(int64_t frame) const override;
  bool goes_without(const Error& failure) const override { return reader_->goes_without(failure); }

 private:
  [[nodiscard]] const ResidualInfo& info() const { return reader_->info().channels[channel_].residuals; }
  // Returns the values of a list: of voxels x + nx (y + ny z), air or 0 added.
  [[nodiscard]] std::vector<GridValue> values(const ResidualList& list, int64_t nx, int64_t ny,
                                              float from) const;

  std::shared_ptr<const Bcc4Reader> reader_;
  int channel_;
};

} // namespace bccsplat
