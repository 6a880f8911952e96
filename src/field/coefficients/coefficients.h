// Kernel coefficients of a 4D volume, layer by layer: made from the samples on first use and kept while
// memory allows.
//
// A coefficient is a fixed linear function of the samples in its reach: stage j of layer m reads stage j-1
// and the samples of layers m-2 .. m+2. So it does not depend on what is cached, in which order layers are
// asked for, or how the file is chunked; and while time advances each stage of each layer is computed once.
// Where the cache is too small for all that a layer depends on, layers are made in stretches, some rows of
// bricks along z at a time: up to three times the work, but never the same stage again and again.
#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "base/context.h"
#include "field/coefficients/sampled_field.h"
#include "kernel/kernel.h"
#include "points/sample_source.h"

namespace bccsplat {

class Corrections; // field/corrections.h

class Coefficients {
 public:
  // prune: coefficients up to this magnitude (value units) are dropped; 0 keeps all that are not zero.
  // region: only its bricks are read and made; near its faces, as far as prefilter and kernel reach, they
  // lack their neighbours and must not be used. The source must outlive the object. On a Cartesian lattice
  // the kernel's form for it takes its place (kernel/cc_kernel.h). Where the source stores coefficients of
  // another kernel, the samples they give are prefiltered.
  Coefficients(const SampleSource& source, int channel, Kernel kernel, float prune, uint64_t cache_bytes,
               const BrickBox& region = {});

  // What coefficients are made of: samples, or stored coefficients of this kernel.
  [[nodiscard]] const SampleSource& source() const { return is_stored_ ? source_ : samples(); }
  // The samples, also where the source stores coefficients.
  [[nodiscard]] const SampleSource& samples() const {
    if (sampled_) return *sampled_;
    return source_;
  }
  [[nodiscard]] int channel() const { return channel_; }
  [[nodiscard]] const Kernel& kernel() const { return kernel_; }
  [[nodiscard]] float prune() const { return prune_; }
  [[nodiscard]] uint64_t cache_bytes() const { return limit_; }
  [[nodiscard]] float air() const { return source_.air(channel_); }
  // Corrections of the field that these coefficients give; null: none. They outlive it.
  [[nodiscard]] const Corrections* corrections() const { return corrections_; }
  void set_corrections(const Corrections* corrections) { corrections_ = corrections; }

  // Coefficients relative to air of a layer; any integer, mirrored at the ends. Concurrent calls are allowed.
  [[nodiscard]] std::shared_ptr<const BrickLayer> layer(int32_t layer, const Context& context) const;
  // Several at once: cheaper than one by one where memory is short.
  [[nodiscard]] std::vector<std::shared_ptr<const BrickLayer>> layers(std::span<const int32_t> layers,
                                                                      const Context& context) const;

  // For those who go through a series once: layers before `first` are not asked for again, those before
  // `next` have been made, and what only these depend on need not stay in the cache.
  void forget(int32_t first, int32_t next) const;

 private:
  using Key = std::pair<int, int32_t>; // stage (0: samples), layer
  struct Entry;
  // Makes stage j + 1 of stage j; its samples are those of stage `source`.
  struct Step {
    PrefilterStage filter;
    int source = 0;
  };

  [[nodiscard]] int last_stage() const { return static_cast<int>(steps_.size()); }

  // Returns which layers of each stage the last one's depend on. missing: only what is not in the cache, and
  // what that depends on.
  std::vector<std::set<int32_t>> needed(std::span<const int32_t> layers, bool missing) const;
  // Counts how much of that has been made.
  struct Work {
    Progress& progress;
    uint64_t done = 0, total = 1; // layers of stages
  };
  Work work(std::span<const int32_t> layers, const Context& context) const;
  std::shared_ptr<const BrickLayer> stage(int stage, int32_t layer, Work& work, const Context& context) const;
  // Returns how many rows of bricks along z a stretch may have for the layers to fit the cache; infinite
  // where the layers need not be cut.
  double stretch_rows(const std::vector<int32_t>& layers, Work& work, const Context& context) const;
  std::map<int32_t, std::shared_ptr<const BrickLayer>>
  make_by_stretches(const std::vector<int32_t>& layers, int rows, const Context& context) const;
  std::shared_ptr<const BrickLayer> find(const Key& key) const;
  bool holds(const Key& key) const;
  std::shared_ptr<const BrickLayer> insert(const Key& key, BrickLayer layer, const Context& context) const;
  void evict_locked(uint64_t room) const; // until `room` bytes fit under the cache's limit
  // How many layers of a stage on either side one of the last stage depends on.
  [[nodiscard]] std::vector<int32_t> reach_of_stages() const;

  const SampleSource& source_;
  std::unique_ptr<const SampledField> sampled_; // of stored coefficients
  bool is_stored_ = false;                      // the source stores this kernel's coefficients
  int channel_;
  Kernel kernel_;
  std::vector<Step> steps_; // those this source needs: none when it stores coefficients
  float prune_;
  BrickBox region_;
  uint64_t limit_;
  const Corrections* corrections_ = nullptr;

  mutable std::mutex mutex_;
  mutable std::map<Key, std::shared_ptr<const Entry>> entries_;
  mutable std::list<Key> recent_; // least recently used first
  mutable uint64_t held_ = 0;
};

} // namespace bccsplat
