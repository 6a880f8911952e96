// SPDX-License-Identifier: Apache-2.0
// Kernel coefficients of a 4D volume, layer by layer: made from the samples on first use and kept while
// memory allows.
//
// A coefficient is a fixed linear function of the samples in its reach. So it does not depend on what is
// cached, in which order layers are asked for, or how the file is chunked; and while time advances each layer
// of samples is read once and each of coefficients made once. Samples are kept as the codes they are stored
// as, where they take less, and before coefficients: decoding a layer again costs more a byte than making it.
// Coefficients of samples that come in steps are rounded when they are made, always, and kept so until
// somebody asks for them as values (points/rounded_brick.h). Where the cache is too small for all samples
// that layers depend on, they are made in stretches, some rows of bricks along z at a time, for which each
// row of samples is read once as well. A source that adds layers gives at once what the prefilter makes of
// them in time; no samples are held then. The field at the instant of one of its layers is that layer,
// prefiltered in space alone, where the kernel goes through the samples: one layer is then read and made, in
// place of those that surround it.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "base/context.h"
#include "field/coefficients/coefficient_layer.h"
#include "field/coefficients/prefilter.h"
#include "kernel/kernel.h"
#include "points/sample_source.h"

namespace bccsplat {

class Corrections; // field/corrections.h
class Masks;       // field/masks.h

class Coefficients {
 public:
  // prune: coefficients up to this magnitude (value units) are dropped; 0 keeps all that are not zero.
  // region: only its bricks are made, as they are without one, of samples up to a brick around it. The source
  // must outlive the object. On a Cartesian lattice the kernel's form for it takes its place
  // (kernel/cc_kernel.h).
  Coefficients(const SampleSource& source, int channel, Kernel kernel, float prune, uint64_t cache_bytes,
               const BrickBox& region = {});

  // Returns the samples.
  [[nodiscard]] const SampleSource& source() const { return source_; }
  [[nodiscard]] int channel() const { return channel_; }
  [[nodiscard]] const Kernel& kernel() const { return kernel_; }
  [[nodiscard]] float prune() const { return prune_; }
  [[nodiscard]] uint64_t cache_bytes() const { return limit_; }
  [[nodiscard]] float air() const { return source_.air(channel_); }
  // The field is this plus what the coefficients add up to.
  [[nodiscard]] float base() const { return source_.base(channel_); }
  // Corrections of the field that these coefficients give; null: none. They outlive it.
  [[nodiscard]] const Corrections* corrections() const { return corrections_; }
  void set_corrections(const Corrections* corrections) { corrections_ = corrections; }
  // Returns what is missing of the field; null: no masks tell. They outlive it.
  [[nodiscard]] const Masks* masks() const { return masks_; }
  void set_masks(const Masks* masks) { masks_ = masks; }

  // Coefficients relative to the base of a layer; any integer, mirrored at the ends. Concurrent calls are
  // allowed.
  [[nodiscard]] std::shared_ptr<const BrickLayer> layer(int32_t layer, const Context& context) const;
  // Several at once: cheaper than one by one where memory is short.
  [[nodiscard]] std::vector<std::shared_ptr<const BrickLayer>> layers(std::span<const int32_t> layers,
                                                                      const Context& context) const;
  // The same in the form that is at hand, or takes least memory. stills: of a source that adds layers; what
  // the field at the instant of each layer is made of, in space, where the kernel goes through the samples.
  [[nodiscard]] std::vector<CoefficientLayer>
  compact_layers(std::span<const int32_t> layers, const Context& context, bool stills = false) const;
  // Returns the sum of layers with their weights as one layer, of which nothing is kept: where a source adds
  // layers, in about the time and memory of one. None where it does not, or where one of them is held.
  [[nodiscard]] std::optional<BrickLayer> sum_at_once(std::span<const LayerSum::Term> layers, bool stills,
                                                      const Context& context) const;

  // A number that no other coefficients of this process have; stills have another one.
  [[nodiscard]] uint64_t number(bool stills = false) const { return stills ? number_ + 1 : number_; }
  // The least and the largest coefficient of a layer inside the lattice, as compact_layers() gave it, and 0;
  // looked for once.
  [[nodiscard]] std::array<float, 2> range(int32_t layer, bool still, const CoefficientLayer& of,
                                           const Context& context) const;

  // The layers of the source that the coefficients of a layer in it depend on.
  [[nodiscard]] std::set<int32_t> reads(int32_t layer) const;
  // The number of layers that the prefilter has made so far.
  [[nodiscard]] uint64_t layers_made() const { return made_.load(std::memory_order_relaxed); }
  // Returns how many layers, of coefficients or of samples that these are made of, were made or read before
  // and let go.
  [[nodiscard]] uint64_t layers_repeated() const { return repeated_.load(std::memory_order_relaxed); }

  // Tells what of its file compact_layers() asks for; missing: beside what is held.
  void list_reads(std::span<const int32_t> layers, bool missing, LayerReads& out, bool stills = false) const;

  // Shares the layers that another one holds and that are the same here: those of the series before it got
  // more layers. unchanged(m): whether layer m of the source is what it was.
  void take_over(const Coefficients& older, const std::function<bool(int32_t layer)>& unchanged) const;

  // Forgets what a single walk through a series no longer needs: layers before `first` are not asked for
  // again, those before `next` have been made, and what only these depend on need not stay in the cache.
  void forget(int32_t first, int32_t next) const;

 private:
  enum class Kind : uint8_t { samples, compact, values, still }; // the latter three of coefficients
  using Key = std::pair<Kind, int32_t>;                          // and layer
  using Compact = std::map<int32_t, std::shared_ptr<const SampleLayer>>;
  using Layers = std::map<int32_t, CoefficientLayer>;
  struct Entry;
  class SampleRows;

  // All of these are inside the lattice.
  Layers make(std::span<const int32_t> layers, const Context& context) const;
  Layers make_at_once(std::span<const int32_t> layers, const Context& context) const;
  Layers make_by_stretches(std::span<const int32_t> layers, int rows, const Context& context) const;
  // Has the source add layers, and prefilters the sums in space alone. coarsest: as of CoefficientForm.
  std::vector<SampleLayer> make_of_sums(std::span<const LayerSum> sums, float coarsest,
                                        const Context& context) const;
  // Samples, under a kernel without a prefilter as coefficients.
  Compact read(Kind kind, std::span<const int32_t> layers, const Context& context) const;
  // Makes a layer of values of one that is compact, and keeps it in place of that.
  std::shared_ptr<const BrickLayer> as_values(int32_t layer, const SampleLayer& compact,
                                              const Context& context) const;
  // Returns how many rows of bricks along z a stretch may have for the layers to fit the cache; infinite
  // where the layers need not be cut.
  double stretch_rows(std::span<const int32_t> layers, const Context& context) const;
  // Null where the cache does not hold it.
  template<class Layer> std::shared_ptr<const Layer> find(const Key& key) const;
  template<class Layer>
  std::shared_ptr<const Layer> insert(const Key& key, Layer layer, const Context& context) const;
  void erase_locked(const Key& key) const;
  // Whether a layer depends on the same layers as in a shorter series, none of which has changed.
  [[nodiscard]] bool same_as_in(const Coefficients& older, const Key& key,
                                const std::function<bool(int32_t layer)>& unchanged) const;
  void count_repeats(Kind kind, std::span<const int32_t> layers) const;
  Layers insert_all(Kind kind, std::span<const int32_t> layers, std::vector<SampleLayer> made,
                    const Context& context) const;
  // Notes what is asked for, and what the next layer will be made of in the direction that a series is gone
  // through.
  void note_use(std::span<const int32_t> wanted, std::span<const int32_t> inside) const;
  // Until `room` bytes fit under the cache's limit, or all has gone but samples that are spared. What is of
  // no use goes first.
  void evict_locked(uint64_t room, bool spare_samples = false) const;
  // The same of no more than what is of no use.
  void evict_useless_locked(uint64_t room) const;
  template<class Stays> void evict_others_locked(uint64_t room, const Stays& stays) const;
  [[nodiscard]] bool is_useful_locked(const Key& key) const;
  // Gives bytes that a call needs for itself; what is cached makes room.
  Reservation reserve(uint64_t bytes, std::string_view what, const Context& context) const;

  const SampleSource& source_;
  int channel_;
  Kernel kernel_;
  std::unique_ptr<const Prefilter> prefilter_;
  // The prefilter's part in space, and the weights of its part in time, where the source adds layers.
  std::unique_ptr<const Prefilter> in_space_;
  std::vector<float> in_time_;
  float prune_;
  float coarsest_ = 0;   // CoefficientForm
  BrickBox region_;      // of coefficients
  BrickBox read_region_; // of samples: no prefilter reaches further than a brick
  uint64_t limit_;
  const Corrections* corrections_ = nullptr;
  const Masks* masks_ = nullptr;

  uint64_t number_;

  mutable std::mutex mutex_;
  mutable std::map<std::pair<bool, int32_t>, std::array<float, 2>> ranges_; // of a still, by layer
  mutable std::map<Key, std::shared_ptr<const Entry>> entries_;
  mutable std::list<Key> recent_; // least recently used first
  mutable uint64_t held_ = 0;
  mutable std::set<int32_t> spared_; // samples that the next layer depends on
  mutable std::set<int32_t> in_use_; // coefficients asked for last
  mutable int32_t asked_first_ = 0;  // the first of these, which may lie beyond the ends
  mutable std::atomic<uint64_t> made_{0}, repeated_{0};
  mutable std::set<Key> ever_had_;
};

} // namespace bccsplat
