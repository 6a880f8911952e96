// SPDX-License-Identifier: Apache-2.0
// An open file: its index, its caches, and what its fields are made of, by channel, kernel and level. The
// reading twin of store.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "base/context.h"
#include "base/files.h"
#include "field/coefficients/coefficients.h"
#include "field/corrections.h"
#include "field/masks.h"
#include "formats/bcc4/file_limits.h"
#include "formats/bcc4/level_error.h"
#include "formats/bcc4/read/reader.h"
#include "formats/bcc4/read/samples.h"
#include "points/time_axis.h"
#include "points/uneven_axes.h"

namespace bccsplat {

namespace motion {
class MovingSeries;
}

struct VolumeOptions {
  std::string kernel;       // "": the file's
  uint64_t cache_bytes = 0; // 0: chosen by what playing needs and the memory there is
  uint64_t max_sites = UINT64_MAX;
  Bcc4Limits limits;
  Vec3 shape{1, 1, 1}; // factors on the axes of the world
};

// Any thread may call. The budget outlives it.
class OpenVolume {
 public:
  // Reads the index. Throws what reading does, and limit_exceeded where the lattice has more than max_sites.
  OpenVolume(std::unique_ptr<ByteSource> source, const VolumeOptions& options, MemoryBudget& memory);

  // Shares what another one's caches hold and what is the same here: of the file before it grew. Before
  // others use this one.
  void take_over(const OpenVolume& older);

  [[nodiscard]] const VolumeInfo& info() const { return reader_->info(); }
  [[nodiscard]] const std::shared_ptr<Bcc4Reader>& reader() const { return reader_; }
  [[nodiscard]] const TimeAxis& times() const { return times_; }
  // Which axes of space are unevenly spaced, and how: the volume's affine takes even positions to the world.
  [[nodiscard]] const std::shared_ptr<const UnevenAxes>& axes() const { return axes_; }
  // Takes index space, of even positions, to the world: the file's, in the shape that was asked for.
  [[nodiscard]] const Affine3& affine() const { return affine_; }
  [[nodiscard]] const Kernel& kernel() const { return kernel_; }
  [[nodiscard]] const std::string& recommended_kernel() const { return recommended_kernel_; }
  // These fail with not_found where there is no such channel or level.
  [[nodiscard]] const ChannelInfo& channel(uint32_t index) const;
  [[nodiscard]] const Lattice4& lattice(uint32_t level) const;
  [[nodiscard]] const Bcc4Samples& samples(uint32_t level) const { return *samples_[level]; }
  // Null without.
  [[nodiscard]] const Corrections* corrections(uint32_t channel) const { return corrections_[channel].get(); }
  [[nodiscard]] const Masks* masks(uint32_t channel) const { return masks_[channel].get(); }

  // Returns a kernel by its name; null or "": the volume's.
  [[nodiscard]] Kernel kernel_of(const char* name) const;
  // Coefficients of a channel under a kernel at a level; null or "": the volume's. Made once, kept with the
  // volume. They come with the file's masks, and at level 0 under the file's own kernel with its corrections.
  [[nodiscard]] const Coefficients& coefficients(uint32_t channel, const char* kernel_name,
                                                 uint32_t level = 0) const;
  // Returns the coefficients of some bricks alone, or all. They are kept until others are asked for, so that
  // a series plays in a box as it does in all of it; not longer than the volume. keep: new ones of a box take
  // the place of those that are kept.
  [[nodiscard]] std::shared_ptr<const Coefficients> coefficients(uint32_t channel, const char* kernel_name,
                                                                 uint32_t level, const BrickBox& region,
                                                                 bool keep = true) const;
  // What follows the motion of a channel at a level, of its coefficients as above; kept with the volume.
  [[nodiscard]] const motion::MovingSeries& motion(const Coefficients& coefficients) const;
  // Returns the coefficients that values at these points (index units) are made of at level 0: those of the
  // bricks around them while they are few, and kept until others are asked for; of all once that many have
  // been made.
  [[nodiscard]] std::shared_ptr<const Coefficients> coefficients_at(uint32_t channel,
                                                                    std::span<const Vec4> points) const;
  // Returns the part of all bricks that values at these points are made of, if they are looked up together.
  [[nodiscard]] double share_around(std::span<const Vec4> points) const;
  // Whether a channel is of labels, once somebody has found out (labels.h). Any number of threads may ask and
  // tell.
  [[nodiscard]] std::optional<bool> known_labels(uint32_t channel) const;
  void note_labels(uint32_t channel, bool labels) const;

  // Says how large the caches are.
  [[nodiscard]] std::string describe_caches() const;
  // Says, once, that the cache is too small and how large it should be, after layers had to be read or made
  // again.
  [[nodiscard]] std::optional<std::string> note_repeats(const Coefficients& coefficients) const;

 private:
  using Key = std::tuple<uint32_t, std::string, uint32_t>; // channel, canonical kernel name, level
  struct Part {
    BrickBox region;
    std::shared_ptr<const Coefficients> coefficients;
  };
  void take_over_coefficients(const OpenVolume& older, const UnchangedSlabs& unchanged);
  [[nodiscard]] std::unique_ptr<Coefficients> make_coefficients(uint32_t channel, Kernel kernel,
                                                                uint32_t level, const BrickBox& region,
                                                                uint64_t cache) const;

  std::shared_ptr<Bcc4Reader> reader_;
  std::vector<std::unique_ptr<Bcc4Samples>> samples_; // by level
  TimeAxis times_;
  Affine3 affine_;
  std::shared_ptr<const UnevenAxes> axes_; // never null
  Kernel kernel_;
  std::string recommended_kernel_;
  uint64_t cache_bytes_;                                  // for coefficients, per channel and kernel
  uint64_t whole_cache_bytes_;                            // with that of chunks
  uint64_t playing_cache_bytes_;                          // that playing forward needs
  std::vector<std::unique_ptr<Corrections>> corrections_; // of channels; null without
  std::vector<std::unique_ptr<Masks>> masks_;             // likewise

  mutable std::mutex mutex_;
  mutable std::map<Key, std::unique_ptr<Coefficients>> coefficients_;
  mutable std::map<const Coefficients*, std::shared_ptr<const motion::MovingSeries>> motion_;
  mutable std::map<Key, Part> parts_;
  // What coefficients_at() gave last of a channel, and the part of all bricks that it has made so far.
  struct Probed {
    Part part;
    double made = 0;
  };
  mutable std::map<uint32_t, Probed> probed_;
  mutable std::atomic<bool> repeats_told_{false};
  enum class Labels : uint8_t { unknown, no, yes };
  mutable std::unique_ptr<std::atomic<Labels>[]> labels_; // of channels
};

} // namespace bccsplat
