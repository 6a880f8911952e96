// SPDX-License-Identifier: Apache-2.0
// Makes coefficient layers stage by stage on demand, and keeps them in a cache.
#include "field/coefficients/coefficients.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <variant>

#include "base/error.h"
#include "field/coefficients/prefilter_steps.h"
#include "points/rounded_brick.h"

namespace bccsplat {
namespace {

// Reading samples is about this share of making coefficients, for reports of progress.
constexpr double read_share = 0.8;

// The number behind it is taken as well (Coefficients::number).
uint64_t next_number() {
  static std::atomic<uint64_t> last{0};
  return last.fetch_add(2, std::memory_order_relaxed) + 1;
}

// The weights in time of a layer that stands for itself.
constexpr std::array<float, 1> itself{1};

// What the prefilter makes in time of layers of coefficients with their weights, as a sum of layers of
// samples.
LayerSum sum_in_time(const Lattice4& lattice, std::span<const LayerSum::Term> layers,
                     std::span<const float> in_time) {
  const auto reach = static_cast<int32_t>(in_time.size() / 2);
  LayerSum sum;
  float most = 0;
  for (const auto& [layer, weight] : layers) {
    // The layer that weighs most decides what is a hole.
    if (std::fabs(weight) > most) most = std::fabs(weight), sum.layer = lattice.mirror_layer(layer);
    for (int32_t d = -reach; d <= reach; ++d)
      sum.terms.push_back({lattice.mirror_layer(layer + d), weight * in_time[d + reach]});
  }
  return sum;
}

// The same of each layer alone.
std::vector<LayerSum> sums_in_time(const Lattice4& lattice, std::span<const int32_t> layers,
                                   std::span<const float> in_time) {
  std::vector<LayerSum> sums;
  for (const int32_t m : layers)
    sums.push_back(sum_in_time(lattice, std::array{LayerSum::Term{m, 1}}, in_time));
  return sums;
}

} // namespace

// A cached layer and the memory it holds from the budget; kept alive by whoever uses the layer.
struct Coefficients::Entry {
  std::variant<BrickLayer, SampleLayer> layer;
  uint64_t bytes = 0;
  Reservation reservation;
};

Coefficients::Coefficients(const SampleSource& source, int channel, Kernel kernel, float prune,
                           uint64_t cache_bytes, const BrickBox& region)
    : source_(source), channel_(channel), kernel_(std::move(kernel)), prune_(prune), region_(region),
      read_region_(go_round(region.widened(), source.lattice().space)), limit_(cache_bytes),
      number_(next_number()) {
  const Lattice4& lattice = source.lattice();
  PrefilterOfKernel filter = prefilter_of(lattice, std::move(kernel_));
  kernel_ = std::move(filter.kernel);
  if (!lattice.space.bcc && !filter.steps.empty() && source.adds_layers(channel)) {
    const std::span<const PrefilterStep> steps = filter.steps;
    const std::vector<double> in_time = weights_in_time(steps.subspan(filter.in_space));
    in_time_.assign(in_time.begin(), in_time.end());
    const auto in_space = steps.first(filter.in_space);
    in_space_ = std::make_unique<const Prefilter>(lattice, std::vector(in_space.begin(), in_space.end()));
  }
  prefilter_ = std::make_unique<const Prefilter>(lattice, std::move(filter.steps));
  // On Cartesian lattices samples that are stored as codes come back as they are, which labels need.
  const double step = lattice.space.bcc || in_space_ ? source.sample_step(channel) : 0;
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
                                                           const Context& context, bool stills) const {
  Layers found;
  std::vector<int32_t> missing;
  std::vector<int32_t> inside;
  for (const int32_t m : wanted) {
    const int32_t at = inside.emplace_back(source_.lattice().mirror_layer(m));
    if (found.contains(at)) continue;
    CoefficientLayer& layer = found[at];
    if (!stills) layer.values = find<BrickLayer>({Kind::values, at});
    if (!layer) layer.compact = find<SampleLayer>({stills ? Kind::still : Kind::compact, at});
    if (!layer) missing.push_back(at);
  }
  if (!stills) note_use(wanted, inside);
  if (missing.empty()) {
    context.progress.advance(1, 1);
  } else {
    Layers made =
        stills
            ? insert_all(Kind::still, missing,
                         make_of_sums(sums_in_time(source_.lattice(), missing, itself), coarsest_, context),
                         context)
            : make(missing, context);
    for (auto& [at, layer] : made) found[at] = std::move(layer);
  }
  std::vector<CoefficientLayer> result;
  for (const int32_t at : inside) result.push_back(found[at]);
  return result;
}

std::optional<BrickLayer> Coefficients::sum_at_once(std::span<const LayerSum::Term> layers, bool stills,
                                                    const Context& context) const {
  const auto is_held = [&](const LayerSum::Term& term) {
    const int32_t at = source_.lattice().mirror_layer(term.layer);
    if (stills) return entries_.contains({Kind::still, at});
    return entries_.contains({Kind::values, at}) || entries_.contains({Kind::compact, at});
  };
  if (!in_space_ || layers.empty()) return std::nullopt;
  {
    const std::scoped_lock lock(mutex_);
    if (std::any_of(layers.begin(), layers.end(), is_held)) return std::nullopt;
  }
  const LayerSum sum =
      sum_in_time(source_.lattice(), layers, stills ? std::span<const float>(itself) : in_time_);
  auto made = make_of_sums({&sum, 1}, 0, context);
  made_.fetch_add(1, std::memory_order_relaxed);
  return made.front().as_values();
}

std::array<float, 2> Coefficients::range(int32_t layer, bool still, const CoefficientLayer& of,
                                         const Context& context) const {
  {
    const std::scoped_lock lock(mutex_);
    if (const auto found = ranges_.find({still, layer}); found != ranges_.end()) return found->second;
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
  return ranges_[{still, layer}] = range;
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
  if (in_space_) {
    const auto sums = sums_in_time(source_.lattice(), layers, in_time_);
    return insert_all(Kind::compact, layers, make_of_sums(sums, coarsest_, context), context);
  }
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
  source_.read_samples(channel_, missing, kind == Kind::samples ? read_region_ : region_, context, take);
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
  return insert_all(Kind::compact, layers, std::move(made), context);
}

void Coefficients::count_repeats(Kind kind, std::span<const int32_t> layers) const {
  const std::scoped_lock lock(mutex_);
  for (const int32_t m : layers)
    if (!ever_had_.insert({kind, m}).second) repeated_.fetch_add(1, std::memory_order_relaxed);
}

Coefficients::Layers Coefficients::insert_all(Kind kind, std::span<const int32_t> layers,
                                              std::vector<SampleLayer> made, const Context& context) const {
  made_.fetch_add(layers.size(), std::memory_order_relaxed);
  count_repeats(kind, layers);
  Layers result;
  for (size_t i = 0; i < layers.size(); ++i)
    result[layers[i]].compact = insert(Key{kind, layers[i]}, std::move(made[i]), context);
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

void Coefficients::list_reads(std::span<const int32_t> layers, bool missing, LayerReads& out,
                              bool stills) const {
  const std::scoped_lock lock(mutex_);
  const auto held = [&](Kind kind, int32_t m) { return missing && entries_.contains({kind, m}); };
  std::vector<int32_t> made, read;
  for (const int32_t m : layers)
    if (const int32_t at = source_.lattice().mirror_layer(m);
        stills ? !held(Kind::still, at) : !held(Kind::values, at) && !held(Kind::compact, at))
      made.push_back(at);
  if (stills) return source_.list_reads(made, read_region_, out);
  if (prefilter_->empty()) return source_.list_reads(made, region_, out);
  for (const int32_t m : prefilter_->reads(made))
    if (!held(Kind::samples, m)) read.push_back(m);
  source_.list_reads(read, read_region_, out);
}

bool Coefficients::same_as_in(const Coefficients& older, const Key& key,
                              const std::function<bool(int32_t layer)>& unchanged) const {
  const auto& [kind, layer] = key;
  if (kind == Kind::samples || kind == Kind::still) return unchanged(layer);
  // What lies beyond an end is mirrored: a layer that reaches there depends on more of a longer series.
  const std::set<int32_t> here = reads(layer);
  return here == older.reads(layer) && std::all_of(here.begin(), here.end(), unchanged);
}

void Coefficients::take_over(const Coefficients& older,
                             const std::function<bool(int32_t layer)>& unchanged) const {
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

// A still is no part of the moments around it.
bool Coefficients::is_useful_locked(const Key& key) const {
  if (key.first == Kind::still) return false;
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
