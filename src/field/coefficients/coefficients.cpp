// SPDX-License-Identifier: Apache-2.0
// Makes coefficient layers stage by stage on demand, keeps them in a cache, and makes them in stretches where
// the cache is too small for a whole layer's dependencies.
#include "field/coefficients/coefficients.h"

#include <algorithm>
#include <limits>
#include <variant>

#include "base/error.h"
#include "field/coefficients/prefilter_steps.h"
#include "kernel/cc_kernel.h"
#include "points/rounded_brick.h"

namespace bccsplat {
namespace {

// Rows of bricks beside a stretch that its coefficients may depend on: no prefilter reaches 16 sites.
constexpr int stretch_margin = 1;
// Of a periodic axis the last row of bricks may have few sites.
constexpr int last_rows = 2;

// Reading samples is about this share of making coefficients, for reports of progress.
constexpr double read_share = 0.8;

// What stretches may take of the cache.
uint64_t stretch_bytes(uint64_t limit) { return limit - limit / 4; }

uint64_t next_number() {
  static std::atomic<uint64_t> last{0};
  return ++last;
}

} // namespace

// Some rows of bricks along z of layers of samples, which move on. Where z is periodic, the first rows depend
// on the last ones, and these on the first: they stay.
class Coefficients::SampleRows {
 public:
  SampleRows(const Coefficients& owner, const std::set<int32_t>& layers)
      : owner_(owner), numbers_(layers.begin(), layers.end()) {
    const Lattice4& lattice = owner.source_.lattice();
    for (const int32_t m : layers)
      pointers_[m] = &layers_.emplace(m, SampleLayer(lattice.space, lattice.coset(m))).first->second;
    if (!owner.stretches_go_round()) return;
    first_stay_ = stretch_margin;
    last_stay_ = layers_.begin()->second.brick_dims()[2] - last_rows;
  }
  [[nodiscard]] const std::map<int32_t, const SampleLayer*>& layers() const { return pointers_; }

  // Drops rows before `begin` and reads those before `end` that are not there. Neither ever falls.
  void move(int begin, int end, const Context& context) {
    for (auto& [m, layer] : layers_) {
      for (size_t s = 0; s < layer.brick_slots(); ++s)
        if (const int z = layer.slot_position(s)[2]; z >= first_stay_ && z < std::min(begin, last_stay_))
          layer.set(s, {});
      hold(m, layer, context);
    }
    if (end_ == 0 && last_stay_ < INT32_MAX) read(std::max(last_stay_, 0), INT32_MAX, context);
    read(std::max(begin, end_), std::min(end, last_stay_), context);
    end_ = end;
  }

 private:
  void read(int begin, int end, const Context& context) {
    BrickBox box = owner_.read_region_;
    box.begin[2] = std::max(box.begin[2], begin), box.end[2] = std::min(box.end[2], end);
    if (box.begin[2] >= box.end[2]) return;
    const auto take = [&](int32_t m, SampleLayer&& read) {
      SampleLayer& layer = layers_.at(m);
      for (size_t s = 0; s < layer.brick_slots(); ++s)
        if (const int z = layer.slot_position(s)[2]; z >= box.begin[2] && z < box.end[2])
          layer.set(s, read.share(s));
      hold(m, layer, context);
    };
    owner_.source().read_samples(owner_.channel_, numbers_, box, context, take);
  }
  void hold(int32_t m, const SampleLayer& layer, const Context& context) {
    held_[m] = {};
    held_[m] = Reservation(context.memory, layer.bytes(), "samples of a slab");
  }

  const Coefficients& owner_;
  std::vector<int32_t> numbers_;
  std::map<int32_t, SampleLayer> layers_;
  std::map<int32_t, const SampleLayer*> pointers_;
  std::map<int32_t, Reservation> held_;
  int first_stay_ = 0, last_stay_ = INT32_MAX; // rows before the one and from the other on stay
  int end_ = 0;
};

// A cached layer and the memory it holds from the budget; kept alive by whoever uses the layer.
struct Coefficients::Entry {
  std::variant<BrickLayer, SampleLayer> layer;
  uint64_t bytes = 0;
  Reservation reservation;
};

Coefficients::Coefficients(const SampleSource& source, int channel, Kernel kernel, float prune,
                           uint64_t cache_bytes, const BrickBox& region)
    : source_(source), channel_(channel), kernel_(std::move(kernel)), prune_(prune), region_(region),
      read_region_(region.widened()), limit_(cache_bytes), number_(next_number()) {
  const Lattice4& lattice = source.lattice();
  PrefilterOfKernel filter = prefilter_of(lattice, std::move(kernel_));
  kernel_ = std::move(filter.kernel);
  if (const std::string& stored = source.coefficient_kernel(); !stored.empty()) {
    const Kernel own = lattice.space.bcc ? make_kernel(stored) : make_cc_kernel(stored).kernel;
    sampled_ = std::make_unique<const SampledField>(source, own, prune);
    is_stored_ = stored == kernel_.name;
    if (is_stored_) filter.steps.clear();
  }
  if (!sampled_ && !lattice.space.bcc && !filter.steps.empty() && source.adds_layers(channel)) {
    const std::span<const PrefilterStep> steps = filter.steps;
    const std::vector<double> in_time = weights_in_time(steps.subspan(filter.in_space));
    in_time_.assign(in_time.begin(), in_time.end());
    const auto in_space = steps.first(filter.in_space);
    in_space_ = std::make_unique<const Prefilter>(lattice, std::vector(in_space.begin(), in_space.end()));
  }
  prefilter_ = std::make_unique<const Prefilter>(lattice, std::move(filter.steps));
  // On Cartesian lattices samples come back as they are, which labels need.
  const double step = lattice.space.bcc ? samples().sample_step(channel) : 0;
  if (step > 0) coarsest_ = coarsest_step(step);
}

std::shared_ptr<const BrickLayer> Coefficients::layer(int32_t layer, const Context& context) const {
  return layers(std::span(&layer, 1), context).front();
}

std::vector<std::shared_ptr<const BrickLayer>> Coefficients::layers(std::span<const int32_t> wanted,
                                                                    const Context& context) const {
  std::map<const SampleLayer*, std::shared_ptr<const BrickLayer>> known; // mirror images
  std::vector<std::shared_ptr<const BrickLayer>> result;
  std::vector<CoefficientLayer> found = compact_layers(wanted, context);
  for (size_t i = 0; i < found.size(); ++i) {
    auto& values = found[i].values ? found[i].values : known[found[i].compact.get()];
    if (!values) values = as_values(source_.lattice().mirror_layer(wanted[i]), *found[i].compact, context);
    result.push_back(values);
  }
  return result;
}

std::vector<CoefficientLayer> Coefficients::compact_layers(std::span<const int32_t> wanted,
                                                           const Context& context) const {
  Layers found;
  std::vector<int32_t> missing;
  std::vector<int32_t> inside;
  for (const int32_t m : wanted) {
    const int32_t at = inside.emplace_back(source_.lattice().mirror_layer(m));
    if (found.contains(at)) continue;
    CoefficientLayer& layer = found[at];
    layer.values = find<BrickLayer>({Kind::values, at});
    if (!layer) layer.compact = find<SampleLayer>({Kind::compact, at});
    if (!layer) missing.push_back(at);
  }
  note_use(wanted, inside);
  if (missing.empty())
    context.progress.advance(1, 1);
  else
    for (auto& [at, layer] : make(missing, context)) found[at] = std::move(layer);
  std::vector<CoefficientLayer> result;
  for (const int32_t at : inside) result.push_back(found[at]);
  return result;
}

std::array<float, 2> Coefficients::range(int32_t layer, const CoefficientLayer& of,
                                         const Context& context) const {
  {
    const std::scoped_lock lock(mutex_);
    if (const auto found = ranges_.find(layer); found != ranges_.end()) return found->second;
  }
  std::mutex mutex;
  std::array<float, 2> range{};
  context.tasks.parallel_for(of.brick_slots(), [&](uint64_t slot) {
    std::array<float, brick_sites> room;
    const float* const values = of.brick(slot, room);
    if (!values) return;
    const auto [low, high] = std::minmax_element(values, values + brick_sites);
    const std::scoped_lock lock(mutex);
    range = {std::min(range[0], *low), std::max(range[1], *high)};
  });
  const std::scoped_lock lock(mutex_);
  return ranges_[layer] = range;
}

void Coefficients::note_use(std::span<const int32_t> wanted, std::span<const int32_t> inside) const {
  if (wanted.empty()) return;
  const auto [first, last] = std::minmax_element(wanted.begin(), wanted.end());
  const std::scoped_lock lock(mutex_);
  const int32_t next = *first >= asked_first_ ? *last + 1 : *first - 1;
  asked_first_ = *first;
  in_use_ = {inside.begin(), inside.end()};
  spared_ = prefilter_->empty() ? std::set<int32_t>() : reads(source_.lattice().mirror_layer(next));
}

std::shared_ptr<const BrickLayer> Coefficients::as_values(int32_t at, const SampleLayer& compact,
                                                          const Context& context) const {
  BrickLayer values(compact.lattice(), compact.coset());
  context.tasks.parallel_for(compact.rows(), [&](uint64_t row) {
    if (compact.row_empty(row)) return;
    for (size_t slot = row * compact.row_slots(); slot < (row + 1) * compact.row_slots(); ++slot)
      if (const SampleBrick& brick = compact.brick(slot)) values.set(slot, brick.as_values());
  });
  {
    const std::scoped_lock lock(mutex_);
    erase_locked({Kind::compact, at});
  }
  return insert(Key{Kind::values, at}, std::move(values), context);
}

Coefficients::Layers Coefficients::make(std::span<const int32_t> layers, const Context& context) const {
  if (prefilter_->empty()) {
    Layers made;
    for (auto& [m, layer] : read(Kind::compact, layers, context)) made[m].compact = std::move(layer);
    return made;
  }
  if (in_space_) return make_of_sums(layers, context);
  const double rows = stretch_rows(layers, context);
  if (rows < 1 && layers.size() > 1) { // even one row of bricks of all layers at once would not fit
    Layers made;
    for (size_t i = 0; i < layers.size(); ++i) {
      const auto n = static_cast<double>(layers.size()), at = static_cast<double>(i);
      Progress share(context.progress, at / n, (at + 1) / n);
      made.merge(make(layers.subspan(i, 1), context.with(share)));
    }
    return made;
  }
  if (rows < std::numeric_limits<double>::infinity())
    return make_by_stretches(layers, std::max(1, static_cast<int>(rows)), context);
  return make_at_once(layers, context);
}

std::set<int32_t> Coefficients::reads(int32_t layer) const {
  return prefilter_->empty() ? std::set<int32_t>{layer} : prefilter_->reads(std::span(&layer, 1));
}

// Reads layers through the cache.
Coefficients::Compact Coefficients::read(Kind kind, std::span<const int32_t> layers,
                                         const Context& context) const {
  Compact result;
  std::vector<int32_t> missing;
  for (const int32_t m : layers)
    if (!(result[m] = find<SampleLayer>({kind, m}))) missing.push_back(m);
  size_t done = layers.size() - missing.size();
  const SampleSource::TakeLayer<SampleLayer> take = [&](int32_t m, SampleLayer&& layer) {
    result[m] = insert(Key{kind, m}, std::move(layer), context);
    context.progress.advance(++done, layers.size());
  };
  source().read_samples(channel_, missing, kind == Kind::samples ? read_region_ : region_, context, take);
  count_repeats(kind, missing);
  return result;
}

Coefficients::Layers Coefficients::make_at_once(std::span<const int32_t> layers,
                                                const Context& context) const {
  const std::set<int32_t> reads = prefilter_->reads(layers);
  std::vector<SampleLayer> made = [&] {
    Progress reading(context.progress, 0, read_share), making(context.progress, read_share, 1);
    const auto samples = read(Kind::samples, std::vector(reads.begin(), reads.end()), context.with(reading));
    std::map<int32_t, const SampleLayer*> all;
    for (const auto& [m, layer] : samples) all[m] = layer.get();
    // This is about what they will hold, so that the budget is kept while they are made; insert() reserves
    // what they hold.
    uint64_t bytes = 0;
    for (const int32_t m : layers)
      bytes += all[m]->bricks() * (coarsest_ > 0 ? sizeof(RoundedBrick) : sizeof(Brick));
    {
      const std::scoped_lock lock(mutex_);
      evict_useless_locked(bytes);
    }
    const Reservation room = reserve(bytes, "coefficients of some layers", context);
    return prefilter_->apply(layers, all, {prune_, coarsest_}, region_, context.with(making));
  }();
  return insert_all(layers, std::move(made), context);
}

Coefficients::Layers Coefficients::make_of_sums(std::span<const int32_t> layers,
                                                const Context& context) const {
  constexpr uint64_t beside = 1; // what a layer is made of; the prefilter reserves its own
  const Lattice4& lattice = source_.lattice();
  const auto reach = static_cast<int32_t>(in_time_.size() / 2);
  std::vector<LayerSum> sums;
  std::vector<SampleLayer> made;
  uint64_t bricks = 1; // of a layer
  for (const int32_t m : layers) {
    LayerSum& sum = sums.emplace_back(LayerSum{m, {}});
    for (int32_t d = -reach; d <= reach; ++d)
      sum.terms.push_back({lattice.mirror_layer(m + d), in_time_[d + reach]});
    made.emplace_back(lattice.space, lattice.coset(m));
    bricks = std::max(bricks, source_.bricks_at_most(channel_, m, read_region_));
  }
  const int first = region_.begin[2], last = std::min(made.front().brick_dims()[2], region_.end[2]);
  const uint64_t bytes = (layers.size() + beside) * bricks * sizeof(Brick);
  int rows = std::max(last - first, 1); // of bricks along z, at a time
  if (bytes > limit_) {
    const double fit = static_cast<double>(stretch_bytes(limit_)) / static_cast<double>(bytes);
    rows = std::max(1, static_cast<int>(fit * rows) - 2 * stretch_margin);
  }
  {
    const std::scoped_lock lock(mutex_);
    evict_useless_locked(std::min(bytes, limit_));
  }
  std::vector<Reservation> parts; // of the bricks that stay
  for (int z = first; z < last; z += rows) {
    BrickBox stretch = region_;
    stretch.begin[2] = z, stretch.end[2] = std::min(last, z + rows);
    const BrickBox around = go_round(stretch.widened(), lattice.space);
    const double all = last - first, share_first = (z - first) / all,
                 share_end = (stretch.end[2] - first) / all;
    Progress share(context.progress, share_first, share_end);
    const Reservation room =
        reserve(static_cast<uint64_t>(static_cast<double>(bytes) *
                                      std::min(1.0, (rows + 2.0 * stretch_margin) / all)),
                "sums of layers", context);
    uint64_t stays = 0;
    for (size_t i = 0; i < layers.size(); ++i) {
      const SampleLayer of(
          source_.add_layers(channel_, std::span(sums).subspan(i, 1), around, context.with(share)).front());
      const std::map<int32_t, const SampleLayer*> samples{{layers[i], &of}};
      const std::vector<SampleLayer> part =
          in_space_->apply(layers.subspan(i, 1), samples, {prune_, coarsest_}, stretch, context.with(share));
      for (size_t s = 0; s < made[i].brick_slots(); ++s) {
        if (!part[0].brick(s)) continue;
        made[i].set(s, part[0].share(s));
        stays += part[0].brick(s).bytes();
      }
    }
    if (stretch.end[2] < last) parts.emplace_back(context.memory, stays, "coefficients of a slab");
  }
  parts.clear();
  return insert_all(layers, std::move(made), context);
}

void Coefficients::count_repeats(Kind kind, std::span<const int32_t> layers) const {
  const std::scoped_lock lock(mutex_);
  for (const int32_t m : layers)
    if (!ever_had_.insert({kind, m}).second) repeated_.fetch_add(1, std::memory_order_relaxed);
}

Coefficients::Layers Coefficients::insert_all(std::span<const int32_t> layers, std::vector<SampleLayer> made,
                                              const Context& context) const {
  made_.fetch_add(layers.size(), std::memory_order_relaxed);
  count_repeats(Kind::compact, layers);
  Layers result;
  for (size_t i = 0; i < layers.size(); ++i)
    result[layers[i]].compact = insert(Key{Kind::compact, layers[i]}, std::move(made[i]), context);
  return result;
}

void Coefficients::forget(int32_t first, int32_t next) const {
  const int32_t reach = prefilter_->reach();
  const std::scoped_lock lock(mutex_);
  std::erase_if(recent_, [&](const Key& key) {
    const auto [kind, layer] = key;
    // Beyond the ends are mirror images, of layers as far inside.
    if (layer >= (kind == Kind::samples ? next - reach : first)) return false;
    const auto it = entries_.find(key);
    held_ -= it->second->bytes;
    entries_.erase(it);
    return true;
  });
}

void Coefficients::list_reads(std::span<const int32_t> layers, bool missing, LayerReads& out) const {
  const std::scoped_lock lock(mutex_);
  const auto held = [&](Kind kind, int32_t m) { return missing && entries_.contains({kind, m}); };
  std::vector<int32_t> made, read;
  for (const int32_t m : layers)
    if (const int32_t at = source_.lattice().mirror_layer(m);
        !held(Kind::values, at) && !held(Kind::compact, at))
      made.push_back(at);
  if (prefilter_->empty()) return source().list_reads(made, region_, out);
  for (const int32_t m : prefilter_->reads(made))
    if (!held(Kind::samples, m)) read.push_back(m);
  source().list_reads(read, read_region_, out);
}

bool Coefficients::same_as_in(const Coefficients& older, const Key& key,
                              const std::function<bool(int32_t layer)>& unchanged) const {
  const auto& [kind, layer] = key;
  if (kind == Kind::samples) return unchanged(layer);
  // What lies beyond an end is mirrored: a layer that reaches there depends on more of a longer series.
  const std::set<int32_t> here = reads(layer);
  return here == older.reads(layer) && std::all_of(here.begin(), here.end(), unchanged);
}

void Coefficients::take_over(const Coefficients& older,
                             const std::function<bool(int32_t layer)>& unchanged) const {
  // Samples that are made of coefficients may reach beyond the old end, too.
  if (sampled_ && !is_stored_) return;
  if (prune_ != older.prune_ || coarsest_ != older.coarsest_ || !(region_ == older.region_)) return;
  if (source_.lattice().periodic && !(source_.lattice() == older.source_.lattice())) return;
  const std::scoped_lock lock(mutex_, older.mutex_);
  for (auto key = older.recent_.rbegin(); key != older.recent_.rend(); ++key) {
    const std::shared_ptr<const Entry>& entry = older.entries_.at(*key);
    if (entry->bytes > limit_ - held_ || entries_.contains(*key) || !same_as_in(older, *key, unchanged))
      continue;
    entries_.emplace(*key, entry);
    recent_.push_front(*key);
    ever_had_.insert(*key);
    held_ += entry->bytes;
  }
}

double Coefficients::stretch_rows(std::span<const int32_t> layers, const Context& context) const {
  constexpr double unlimited = std::numeric_limits<double>::infinity();
  if (source_.lattice().is_static()) return unlimited;
  const size_t samples = prefilter_->reads(layers).size();
  // Coefficients spread a few sites beyond the samples: half as many bricks again, at most all.
  Progress unheard(context.progress, 0, 0);
  const auto one = read(Kind::samples, layers.first(1), context.with(unheard)).begin()->second;
  const double stand = std::max<double>(1, static_cast<double>(one->bricks())),
               share = std::min(1.5, static_cast<double>(one->brick_slots()) / stand);
  const double all = share * static_cast<double>(one->bytes() * samples);
  if (all <= static_cast<double>(limit_)) return unlimited;
  const int height = one->brick_dims()[2];
  const int beside = 2 * stretch_margin + (stretches_go_round() ? stretch_margin + last_rows : 0);
  return std::min<double>(static_cast<double>(stretch_bytes(limit_)) * height / all - beside, height);
}

// A box that reaches an end of a periodic axis goes all the way (go_round).
bool Coefficients::stretches_go_round() const {
  return source_.lattice().space.periodic[2] && region_.begin[2] == 0;
}

Coefficients::Layers Coefficients::make_by_stretches(std::span<const int32_t> layers, int rows,
                                                     const Context& context) const {
  const Lattice4& lattice = source_.lattice();
  std::vector<SampleLayer> made;
  int height = 0;
  for (const int32_t m : layers)
    height = std::max(height, made.emplace_back(lattice.space, lattice.coset(m)).brick_dims()[2]);
  {
    const std::scoped_lock lock(mutex_);
    spared_.clear();
    evict_locked(stretch_bytes(limit_));
  }
  const std::set<int32_t> reads = prefilter_->reads(layers);
  count_repeats(Kind::samples, std::vector(reads.begin(), reads.end()));
  SampleRows samples(*this, reads);
  std::vector<Reservation> parts; // of the bricks that stay when a stretch's own store goes
  const int end = std::min(height, region_.end[2]);
  for (int z = region_.begin[2]; z < end; z += rows) {
    BrickBox stretch = region_;
    stretch.begin[2] = z, stretch.end[2] = std::min(end, z + rows);
    Progress share(context.progress, 1.0 * z / height, 1.0 * stretch.end[2] / height);
    samples.move(z - stretch_margin, stretch.end[2] + stretch_margin, context.with(share));
    const auto part =
        prefilter_->apply(layers, samples.layers(), {prune_, coarsest_}, stretch, context.with(share));
    uint64_t bytes = 0;
    for (size_t i = 0; i < made.size(); ++i)
      for (size_t s = 0; s < made[i].brick_slots(); ++s) {
        if (!part[i].brick(s)) continue;
        made[i].set(s, part[i].share(s));
        bytes += part[i].brick(s).bytes();
      }
    parts.emplace_back(context.memory, bytes, "coefficients of a slab");
  }
  parts.clear();
  return insert_all(layers, std::move(made), context);
}

template<class Layer> std::shared_ptr<const Layer> Coefficients::find(const Key& key) const {
  const std::scoped_lock lock(mutex_);
  const auto it = entries_.find(key);
  if (it == entries_.end()) return nullptr;
  recent_.splice(recent_.end(), recent_, std::find(recent_.begin(), recent_.end(), key));
  return {it->second, &std::get<Layer>(it->second->layer)};
}

template<class Layer>
std::shared_ptr<const Layer> Coefficients::insert(const Key& key, Layer layer, const Context& context) const {
  const std::scoped_lock lock(mutex_);
  // Two threads may have made the same layer; the results are equal and the first one stays.
  if (const auto it = entries_.find(key); it != entries_.end())
    return {it->second, &std::get<Layer>(it->second->layer)};
  auto entry = std::make_shared<Entry>();
  entry->bytes = layer.bytes();
  evict_locked(entry->bytes, key.first != Kind::samples);
  while (!context.memory.try_reserve(entry->bytes)) {
    if (recent_.empty()) { // the exception says what the budget lacks
      [[maybe_unused]] const Reservation failed(context.memory, entry->bytes, "coefficients of one layer");
      break;
    }
    evict_locked(UINT64_MAX);
  }
  entry->reservation = Reservation::adopt(context.memory, entry->bytes);
  entry->layer = std::move(layer);
  // What does not fit beside samples that are spared is its user's alone.
  if (recent_.empty() || (entry->bytes <= limit_ && held_ <= limit_ - entry->bytes)) {
    entries_.emplace(key, entry);
    recent_.push_back(key);
    held_ += entry->bytes;
  }
  return {entry, &std::get<Layer>(entry->layer)};
}

bool Coefficients::is_useful_locked(const Key& key) const {
  return (key.first == Kind::samples ? spared_ : in_use_).contains(key.second);
}

template<class Stays> void Coefficients::evict_others_locked(uint64_t room, const Stays& stays) const {
  for (auto key = recent_.begin(); key != recent_.end() && (room > limit_ || held_ > limit_ - room);) {
    if (stays(*key)) {
      ++key;
      continue;
    }
    const auto it = entries_.find(*key);
    held_ -= it->second->bytes;
    entries_.erase(it);
    key = recent_.erase(key);
  }
}

void Coefficients::evict_useless_locked(uint64_t room) const {
  evict_others_locked(room, [&](const Key& key) { return is_useful_locked(key); });
}

void Coefficients::evict_locked(uint64_t room, bool spare_samples) const {
  evict_useless_locked(room);
  evict_others_locked(room, [&](const Key& key) {
    return spare_samples && key.first == Kind::samples && is_useful_locked(key);
  });
}

void Coefficients::erase_locked(const Key& key) const {
  const auto it = entries_.find(key);
  if (it == entries_.end()) return;
  held_ -= it->second->bytes;
  entries_.erase(it);
  recent_.erase(std::find(recent_.begin(), recent_.end(), key));
}

Reservation Coefficients::reserve(uint64_t bytes, std::string_view what, const Context& context) const {
  if (!context.memory.try_reserve(bytes)) {
    const std::scoped_lock lock(mutex_);
    evict_locked(UINT64_MAX);
    return {context.memory, bytes, what};
  }
  return Reservation::adopt(context.memory, bytes);
}

} // namespace bccsplat
