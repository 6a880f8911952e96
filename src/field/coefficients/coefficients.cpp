// Makes coefficient layers stage by stage on demand, keeps them in a cache, and makes them in stretches where
// the cache is too small for a whole layer's dependencies.
#include "field/coefficients/coefficients.h"

#include <algorithm>
#include <limits>

#include "base/error.h"
#include "field/coefficients/prefilter.h"
#include "kernel/cc_kernel.h"

namespace bccsplat {
namespace {

// Rows of bricks beside a stretch that its coefficients may depend on: no prefilter reaches 16 sites.
constexpr int stretch_margin = 1;

} // namespace

// A cached layer and the memory it holds from the budget; kept alive by whoever uses the layer.
struct Coefficients::Entry {
  BrickLayer layer;
  uint64_t bytes = 0;
  Reservation reservation;
};

Coefficients::Coefficients(const SampleSource& source, int channel, Kernel kernel, float prune,
                           uint64_t cache_bytes, const BrickBox& region)
    : source_(source), channel_(channel), kernel_(std::move(kernel)), prune_(prune), region_(region),
      limit_(cache_bytes) {
  const Lattice4& lattice = source.lattice();
  const auto add = [&](const std::vector<PrefilterStage>& stages) {
    const int from = last_stage(); // what came before has made the samples of these
    for (const PrefilterStage& stage : stages) steps_.push_back({stage, from});
  };
  if (lattice.space.bcc) {
    add(lattice.is_static() ? kernel_.prefilter3 : kernel_.prefilter4);
  } else {
    CcKernel cc = make_cc_kernel(kernel_.name);
    kernel_ = std::move(cc.kernel);
    add(kernel_.prefilter3);
    if (!lattice.is_static()) add(cc.time);
  }
  const std::string& stored = source.coefficient_kernel();
  if (stored.empty()) return;
  const Kernel own = lattice.space.bcc ? make_kernel(stored) : make_cc_kernel(stored).kernel;
  sampled_ = std::make_unique<const SampledField>(source, own, prune);
  is_stored_ = stored == kernel_.name;
  if (is_stored_) steps_.clear();
}

std::shared_ptr<const BrickLayer> Coefficients::layer(int32_t layer, const Context& context) const {
  return layers(std::span(&layer, 1), context).front();
}

std::vector<std::shared_ptr<const BrickLayer>> Coefficients::layers(std::span<const int32_t> wanted,
                                                                    const Context& context) const {
  std::map<int32_t, std::shared_ptr<const BrickLayer>> found;
  std::vector<int32_t> missing;
  for (const int32_t m : wanted) {
    const int32_t at = source_.lattice().mirror_layer(m);
    if (!found.contains(at) && !(found[at] = find({last_stage(), at}))) missing.push_back(at);
  }
  if (missing.empty()) context.progress.advance(1, 1);
  Work all = work(missing, context);
  const double rows = stretch_rows(missing, all, context);
  if (rows < 1 && missing.size() > 1) // even one row of bricks of all layers at once would not fit
    for (size_t i = 0; i < missing.size(); ++i) {
      const auto n = static_cast<double>(missing.size()), at = static_cast<double>(i);
      Progress share(context.progress, at / n, (at + 1) / n);
      found[missing[i]] = layer(missing[i], context.with(share));
    }
  else if (rows < std::numeric_limits<double>::infinity())
    for (auto& [at, layer] : make_by_stretches(missing, std::max(1, static_cast<int>(rows)), context))
      found[at] = std::move(layer);
  else
    for (const int32_t at : missing) found[at] = stage(last_stage(), at, all, context);
  std::vector<std::shared_ptr<const BrickLayer>> result;
  for (const int32_t m : wanted) result.push_back(found[source_.lattice().mirror_layer(m)]);
  return result;
}

std::vector<std::set<int32_t>> Coefficients::needed(std::span<const int32_t> layers, bool missing) const {
  const Lattice4& lattice = source_.lattice();
  std::vector<std::set<int32_t>> needed(steps_.size() + 1);
  needed.back().insert(layers.begin(), layers.end());
  for (size_t s = steps_.size() + 1; s-- > 0;) {
    if (missing) std::erase_if(needed[s], [&](int32_t m) { return holds({static_cast<int>(s), m}); });
    if (s == 0) break;
    const auto& [filter, source] = steps_[s - 1];
    const auto reach = [&](size_t stage, int32_t distance) {
      for (const int32_t m : std::set<int32_t>(needed[s]))
        for (const int32_t d : {-distance, distance}) needed[stage].insert(lattice.mirror_layer(m + d));
    };
    const auto samples = static_cast<size_t>(source);
    reach(s - 1, 0);
    reach(samples, 0);
    if (filter.cross != 0 && lattice.space.bcc) reach(s - 1, 1);
    if (filter.temporal != 0 || filter.mixed != 0) reach(s - 1, filter.stride * lattice.layer_period());
    if (filter.source_temporal != 0 || filter.source_mixed != 0) reach(samples, lattice.layer_period());
  }
  return needed;
}

std::vector<int32_t> Coefficients::reach_of_stages() const {
  const int32_t period = source_.lattice().layer_period();
  std::vector<int32_t> reach(steps_.size() + 1);
  for (size_t s = steps_.size(); s-- > 0;) {
    const auto& [filter, source] = steps_[s];
    const int32_t cross = filter.cross != 0 && source_.lattice().space.bcc ? 1 : 0;
    const int32_t before = filter.temporal != 0 || filter.mixed != 0 ? period : cross;
    const int32_t samples = filter.source_temporal != 0 || filter.source_mixed != 0 ? period : 0;
    reach[s] = std::max(reach[s], reach[s + 1] + before);
    int32_t& of_samples = reach[static_cast<size_t>(source)];
    of_samples = std::max(of_samples, reach[s + 1] + samples);
  }
  return reach;
}

void Coefficients::forget(int32_t first, int32_t next) const {
  const std::vector<int32_t> reach = reach_of_stages();
  const std::scoped_lock lock(mutex_);
  std::erase_if(recent_, [&](const Key& key) {
    const auto [stage, layer] = key;
    // Beyond the ends are mirror images, of layers as far inside.
    if (layer >= (stage == last_stage() ? first : next - reach[static_cast<size_t>(stage)])) return false;
    const auto it = entries_.find(key);
    held_ -= it->second->bytes;
    entries_.erase(it);
    return true;
  });
}

Coefficients::Work Coefficients::work(std::span<const int32_t> layers, const Context& context) const {
  Work work{context.progress};
  work.total = 0;
  for (const auto& stage : needed(layers, true)) work.total += stage.size();
  return work;
}

double Coefficients::stretch_rows(const std::vector<int32_t>& layers, Work& work,
                                  const Context& context) const {
  constexpr double unlimited = std::numeric_limits<double>::infinity();
  if (layers.empty() || steps_.empty() || source_.lattice().is_static()) return unlimited;
  size_t total = 0;
  for (const auto& stage : needed(layers, false)) total += stage.size();
  // Coefficients spread a few sites beyond the samples: half as many bricks again, at most all.
  const auto one = stage(0, layers.front(), work, context);
  const uint64_t dense = one->brick_slots() * sizeof(Brick);
  const uint64_t bytes = std::min(dense, one->bytes() + one->bytes() / 2) * total;
  if (bytes <= limit_) return unlimited;
  const int height = one->brick_dims()[2];
  const double per_brick = static_cast<double>(bytes) / height;
  return std::min<double>(static_cast<double>(limit_ / 2) / per_brick - 2 * stretch_margin, height);
}

std::map<int32_t, std::shared_ptr<const BrickLayer>>
Coefficients::make_by_stretches(const std::vector<int32_t>& layers, int rows, const Context& context) const {
  const Lattice4& lattice = source_.lattice();
  std::map<int32_t, BrickLayer> made;
  int height = 0;
  for (const int32_t m : layers) {
    const auto& layer = made[m] = BrickLayer(lattice.space, lattice.coset(m));
    height = std::max(height, layer.brick_dims()[2]);
  }
  {
    const std::scoped_lock lock(mutex_);
    evict_locked(limit_ / 2);
  }
  std::vector<Reservation> parts; // of the bricks that stay when a stretch's own store goes
  for (int z = region_.begin[2]; z < std::min(height, region_.end[2]); z += rows) {
    BrickBox stretch = region_;
    stretch.begin[2] = std::max(stretch.begin[2], z - stretch_margin);
    stretch.end[2] = std::min(stretch.end[2], z + rows + stretch_margin);
    const Coefficients local(source_, channel_, kernel_, prune_, UINT64_MAX, stretch);
    uint64_t bytes = 0;
    Progress share(context.progress, 1.0 * z / height, std::min(1.0, 1.0 * (z + rows) / height));
    Work all = local.work(layers, context.with(share));
    for (auto& [m, layer] : made) {
      const auto part = local.stage(last_stage(), m, all, context);
      for (size_t s = 0; s < layer.brick_slots(); ++s) {
        const int at = layer.slot_position(s)[2];
        if (at < z || at >= z + rows || !part->brick(s)) continue;
        layer.set(s, part->share(s));
        bytes += sizeof(Brick);
      }
    }
    parts.emplace_back(context.memory, bytes, "coefficients of a slab");
  }
  parts.clear();
  std::map<int32_t, std::shared_ptr<const BrickLayer>> result;
  for (auto& [m, layer] : made) result[m] = insert({last_stage(), m}, std::move(layer), context);
  return result;
}

// layer is inside the lattice.
std::shared_ptr<const BrickLayer> Coefficients::stage(int stage_number, int32_t m, Work& work,
                                                      const Context& context) const {
  const Key key{stage_number, m};
  if (auto found = find(key)) return found;
  // What was evicted and is made again is counted once.
  const auto next = [&] { return std::min(++work.done, work.total); };
  work.progress.check();
  if (stage_number == 0) {
    auto samples = insert(key, source().read_layer(channel_, m, region_, context), context);
    work.progress.advance(next(), work.total);
    return samples;
  }
  const Step& step = steps_[static_cast<size_t>(stage_number) - 1];
  const PrefilterStage& filter = step.filter;
  const Lattice4& lattice = source_.lattice();
  std::vector<std::shared_ptr<const BrickLayer>> held;
  const auto get = [&](int from_stage, int32_t at) {
    held.push_back(stage(from_stage, lattice.mirror_layer(at), work, context));
    return held.back().get();
  };
  const auto layers = [&](int from_stage, bool in_time) {
    StageLayers l{.own = get(from_stage, m)};
    const int32_t period = filter.stride * lattice.layer_period();
    if (in_time && !lattice.is_static())
      l.before = get(from_stage, m - period), l.after = get(from_stage, m + period);
    return l;
  };
  StageInput input;
  input.previous = layers(stage_number - 1, filter.temporal != 0 || filter.mixed != 0);
  if (filter.uses_source())
    input.samples = layers(step.source, filter.source_temporal != 0 || filter.source_mixed != 0);
  if (filter.cross != 0 && !lattice.space.bcc) {
    input.cross_after = get(step.source, m);
  } else if (filter.cross != 0) {
    input.cross_after = get(stage_number - 1, m + 1);
    if (!lattice.is_static()) input.cross_before = get(stage_number - 1, m - 1);
  }
  const bool last = stage_number == last_stage();
  const StageFinish finish{last ? get(0, m) : nullptr, prune_};
  BrickLayer made = [&] {
    // This is about what it will hold, so that the budget is kept while it is made; insert() reserves what it
    // holds.
    const Reservation making(context.memory, input.previous.own->bytes(), "coefficients of one layer");
    const auto total = static_cast<double>(work.total), before = static_cast<double>(work.done);
    Progress share(work.progress, std::min(before / total, 1.0), static_cast<double>(next()) / total);
    return apply_stage(filter, input, last ? &finish : nullptr, region_, context.with(share));
  }();
  return insert(key, std::move(made), context);
}

std::shared_ptr<const BrickLayer> Coefficients::find(const Key& key) const {
  const std::scoped_lock lock(mutex_);
  const auto it = entries_.find(key);
  if (it == entries_.end()) return nullptr;
  recent_.splice(recent_.end(), recent_, std::find(recent_.begin(), recent_.end(), key));
  return {it->second, &it->second->layer};
}

bool Coefficients::holds(const Key& key) const {
  const std::scoped_lock lock(mutex_);
  return entries_.contains(key);
}

std::shared_ptr<const BrickLayer> Coefficients::insert(const Key& key, BrickLayer layer,
                                                       const Context& context) const {
  const std::scoped_lock lock(mutex_);
  // Two threads may have made the same layer; the results are equal and the first one stays.
  if (const auto it = entries_.find(key); it != entries_.end()) return {it->second, &it->second->layer};
  auto entry = std::make_shared<Entry>();
  entry->bytes = layer.bytes();
  evict_locked(entry->bytes);
  while (!context.memory.try_reserve(entry->bytes)) {
    if (recent_.empty()) { // the exception says what the budget lacks
      [[maybe_unused]] const Reservation failed(context.memory, entry->bytes, "coefficients of one layer");
      break;
    }
    evict_locked(UINT64_MAX);
  }
  entry->reservation = Reservation::adopt(context.memory, entry->bytes);
  entry->layer = std::move(layer);
  entries_.emplace(key, entry);
  recent_.push_back(key);
  held_ += entry->bytes;
  return {entry, &entry->layer};
}

void Coefficients::evict_locked(uint64_t room) const {
  while (!recent_.empty() && (room > limit_ || held_ > limit_ - room)) {
    const auto it = entries_.find(recent_.front());
    held_ -= it->second->bytes;
    entries_.erase(it);
    recent_.pop_front();
  }
}

} // namespace bccsplat
