#include "slice/coefficients.h"

#include <algorithm>

#include "base/error.h"
#include "slice/prefilter.h"

namespace bccsplat {

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
  if (source.coefficient_kernel().empty())
    stages_ = source.lattice().is_static() ? kernel_.prefilter3 : kernel_.prefilter4;
  if (!source.lattice().space.bcc)
    fail(Code::unsupported, "coefficients: kernels of this library reconstruct on BCC and D4*, not on CC");
  const std::string& stored = source.coefficient_kernel();
  if (!stored.empty() && stored != kernel_.name)
    fail(Code::unsupported, "the file holds coefficients of kernel ", stored, " and cannot be read with ",
         kernel_.name, "; leave the kernel to the file");
}

std::shared_ptr<const BrickLayer> Coefficients::layer(int32_t layer, const Context& context) const {
  return stage(static_cast<int>(stages_.size()), source_.lattice().mirror_layer(layer), context);
}

// layer is inside the lattice.
std::shared_ptr<const BrickLayer> Coefficients::stage(int stage_number, int32_t m,
                                                      const Context& context) const {
  const Key key{stage_number, m};
  if (auto found = find(key)) return found;
  context.progress.check();
  if (stage_number == 0) return insert(key, source_.read_layer(channel_, m, region_, context), context);
  const PrefilterStage& filter = stages_[static_cast<size_t>(stage_number) - 1];
  const Lattice4& lattice = source_.lattice();
  std::vector<std::shared_ptr<const BrickLayer>> held;
  const auto get = [&](int from_stage, int32_t at) {
    held.push_back(stage(from_stage, lattice.mirror_layer(at), context));
    return held.back().get();
  };
  const auto layers = [&](int from_stage) {
    StageLayers l{.own = get(from_stage, m)};
    if (!lattice.is_static()) l.before = get(from_stage, m - 2), l.after = get(from_stage, m + 2);
    return l;
  };
  StageInput input;
  input.previous = layers(stage_number - 1);
  if (filter.uses_source()) input.samples = layers(0);
  if (filter.cross != 0) {
    input.cross_after = get(stage_number - 1, m + 1);
    if (!lattice.is_static()) input.cross_before = get(stage_number - 1, m - 1);
  }
  BrickLayer result = apply_stage(filter, input, region_, context);
  if (stage_number == static_cast<int>(stages_.size()))
    result = finish_coefficients(result, *stage(0, m, context), prune_, context);
  return insert(key, std::move(result), context);
}

std::shared_ptr<const BrickLayer> Coefficients::find(const Key& key) const {
  const std::scoped_lock lock(mutex_);
  const auto it = entries_.find(key);
  if (it == entries_.end()) return nullptr;
  recent_.splice(recent_.end(), recent_, std::find(recent_.begin(), recent_.end(), key));
  return {it->second, &it->second->layer};
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
