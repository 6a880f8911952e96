// From the fit into the container.
#include "api/writer.h"
#include "formats/bcc4/journal.h"

using namespace bccsplat;
using namespace bccsplat::api;

void bccsplat_writer::make_container() {
  if (container) return;
  initial.lattice = fit->lattice();
  Bcc4WriterOptions o;
  if (continued) {
    check_continues(continued->old->info());
  } else if (partial == BCCSPLAT_PARTIAL_APPEND) {
    o = appended();
  } else if (partial != BCCSPLAT_PARTIAL_DEFAULT) {
    o.journal = std::make_shared<Bcc4Journal>(path + ".journal", partial == BCCSPLAT_PARTIAL_RESUME);
    o.fingerprint = fingerprint();
  }
  container = std::make_unique<Bcc4Writer>(std::move(sink), initial, o);
  if (continued) copy_continued();
}

// What the fit hands out.
void bccsplat_writer::take_layers(int32_t slab, int channel, std::span<const BrickLayer> layers) {
  if (!coefficients) return store_slab(slab, channel, layers);
  prefiltered.resize(channels.size());
  auto& p = prefiltered[static_cast<size_t>(channel)];
  if (!p) {
    const ChannelInfo& c = initial.channels[static_cast<size_t>(channel)];
    const Quantiser quantiser{c.type, c.scale, c.offset, c.air};
    p = std::make_unique<Prefiltered>(fit->lattice(), quantiser, c.threshold, initial.coefficient_kernel,
                                      part ? part->fit.first_layer : 0, part ? part->first_layer : 0,
                                      part ? part->end_layer : fit->lattice().layers());
    if (part) p->next_slab = part->first_layer / initial.slab_layers;
  }
  for (BrickLayer& layer : p->maker.add(layers, *context)) {
    p->slab.push_back(std::move(layer));
    const bool last =
        p->next_slab * initial.slab_layers + static_cast<int32_t>(p->slab.size()) == fit->lattice().layers();
    if (!last && static_cast<int32_t>(p->slab.size()) < initial.slab_layers) continue;
    store_slab(p->next_slab++, channel, p->slab);
    p->slab.clear();
  }
}

void bccsplat_writer::store_slab(int32_t slab, int channel, std::span<const BrickLayer> layers) {
  now.slab = slab, now.channel = static_cast<uint32_t>(channel);
  if (stores_slab(slab)) {
    make_container();
    container->write_slab(slab, channel, layers, *context);
    if (part) writes.push_back(now);
  }
  if (round_trip) measuring([&] { round_trip->add_layers(channel, layers); });
}

void bccsplat_writer::store_residuals(int channel, uint32_t frame, const FrameResiduals& residuals) {
  make_container();
  container->write_residuals(channel, frame, residuals);
  if (!part) return;
  writes.push_back(now);
  writes.back().frame = frame;
}
