// SPDX-License-Identifier: Apache-2.0
// Writes a file in one pass: chunks slab by slab, each page of the index when it is full, and at the end
// directory, metadata and roots. Here calls are checked, and what may not change once samples are written.
#include <algorithm>
#include <array>
#include <utility>

#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/coding/mask_runs.h"
#include "formats/bcc4/metadata.h"
#include "formats/bcc4/same_coding.h"
#include "formats/bcc4/write/writer_state.h"

namespace bccsplat {
namespace {

// Returns where the first chunk goes.
uint64_t chunks_begin(const Bcc4WriterOptions& options) {
  return std::max(preamble_bytes, (options.data_offset + 7) / 8 * 8);
}

// Returns the checksum of what decides the bytes of chunks.
uint32_t journal_fingerprint(VolumeInfo info, const Bcc4WriterOptions& options) {
  tidy(info);
  const std::array<uint32_t, 3> parts{crc32_of(write_metadata(info)), options.fingerprint,
                                      static_cast<uint32_t>(options.level)};
  return crc32_of(std::as_bytes(std::span(parts)));
}

} // namespace

Bcc4Writer::State::State(std::unique_ptr<ByteSink> sink, const VolumeInfo& initial,
                         const Bcc4WriterOptions& o)
    : file(std::move(sink), chunks_begin(o)), options(o), info(initial),
      unused(chunks_begin(o) - preamble_bytes) {
  if (options.level < 0 || options.level > 9)
    fail(Code::invalid_argument, "writer: level ", options.level, " is not in 0 .. 9");
  check_fixed(info, Code::invalid_argument);
}

void Bcc4Writer::State::begin() {
  if (closed) fail(Code::wrong_state, "writer: finished, or failed before");
  if (!index)
    start();
  else if (!same_coding(info, fixed))
    fail(Code::wrong_state, "writer: lattice or coding of a channel changed after samples were written");
}

void Bcc4Writer::State::start() {
  check_fixed(info, Code::invalid_argument);
  fixed = info;
  index.emplace(info,
                [this](std::span<const std::byte> decoded) { return file.append(pack_block(decoded)); });
  frames.emplace(file, info.channels.size());
  if (options.journal) options.journal->start(journal_fingerprint(info, options));
}

void Bcc4Writer::State::check_layers(int32_t slab, const ChannelLevel& at,
                                     std::span<const SampleLayer> layers) const {
  const auto bad = [&](const auto&... why) {
    fail(Code::invalid_argument, "writer: slab ", slab, " of channel ", at.channel, ", level ", at.level,
         ": ", why...);
  };
  const StoredLattice& level = info.level(at.level);
  if (layers.empty() || layers.size() > static_cast<size_t>(level.slab_layers)) bad(layers.size(), " layers");
  for (size_t m = 0; m < layers.size(); ++m) {
    const int coset = level.lattice.coset(slab * level.slab_layers + static_cast<int32_t>(m));
    if (!(layers[m].lattice() == level.lattice.space) || layers[m].coset() != coset)
      bad("layer ", m, " is not of coset ", coset, " of the lattice");
  }
}

void Bcc4Writer::State::check_channel(int channel) const {
  if (channel < 0 || static_cast<size_t>(channel) >= frames->channels())
    fail(Code::invalid_argument, "writer: corrections or masks of channel ", channel, " of ",
         frames->channels());
}

Bcc4Writer::Bcc4Writer(std::unique_ptr<ByteSink> sink, const VolumeInfo& initial,
                       const Bcc4WriterOptions& options)
    : state_(std::make_unique<State>(std::move(sink), initial, options)) {}

Bcc4Writer::~Bcc4Writer() { state_->keep(); }

VolumeInfo& Bcc4Writer::info() { return state_->info; }

void Bcc4Writer::write_slab(int32_t slab, const ChannelLevel& at, std::span<const SampleLayer> layers,
                            const Context& context, double rounded) {
  State& s = *state_;
  s.begin();
  s.index->check_slab(slab, at, s.info);
  s.check_layers(slab, at, layers);
  s.whole([&] { s.write_slab(slab, at, layers, rounded, context); });
}

std::vector<SampleLayer> Bcc4Writer::as_read(int32_t slab, const ChannelLevel& at,
                                             std::span<const SampleLayer> layers, const Context& context,
                                             double rounded) {
  state_->begin();
  state_->check_layers(slab, at, layers);
  return state_->as_read(slab, at, layers, rounded, context);
}

void Bcc4Writer::write_slab(int32_t slab, const ChannelLevel& at, std::span<const BrickLayer> layers,
                            const Context& context) {
  write_slab(slab, at, std::vector<SampleLayer>(layers.begin(), layers.end()), context);
}

void Bcc4Writer::copy_slab(int32_t slab, const ChannelLevel& at, std::span<const Bcc4Reader* const> from) {
  State& s = *state_;
  s.begin();
  s.index->check_slab(slab, at, s.info);
  for (const Bcc4Reader* const file : from)
    if (!same_coding(file->info(), s.info))
      fail(Code::invalid_argument, "writer: slab ", slab, " comes from a file of another lattice or coding");
  s.whole([&] {
    static_cast<void>(s.copy_chunks(slab, at, from));
    s.index->enter_slab(slab, at, s.info.level(at.level).layers_of(slab), 0);
  });
}

void Bcc4Writer::write_residuals(int channel, uint32_t frame, const FrameResiduals& residuals,
                                 const Context& context) {
  if (residuals.empty()) return;
  State& s = *state_;
  s.begin();
  s.check_channel(channel);
  s.whole([&] { s.frames->write_corrections(s.info, channel, frame, residuals, context); });
}

void Bcc4Writer::copy_residuals(int channel, uint32_t frame, std::span<const Bcc4Reader* const> from,
                                const Context& context) {
  State& s = *state_;
  s.begin();
  s.check_channel(channel);
  s.whole([&] { s.frames->copy_corrections(s.info, channel, frame, from, context); });
}

void Bcc4Writer::State::add_mask(int channel, uint32_t frame, PackedBlock block, uint64_t missing) {
  begin();
  check_channel(channel);
  whole([&] { frames->add_mask(channel, frame, std::move(block), missing); });
}

void Bcc4Writer::write_mask(int channel, uint32_t frame, std::span<const std::byte> runs,
                            const Context& context) {
  if (runs.empty()) return;
  const auto& n = state_->info.lattice.dims;
  uint64_t missing = 0;
  read_mask_runs(runs, uint64_t{n[0]} * n[1] * n[2], 0,
                 [&](uint64_t begin, uint64_t end) { missing += end - begin; });
  state_->add_mask(channel, frame, pack_block(runs, &context.progress), missing);
}

void Bcc4Writer::copy_mask(int channel, uint32_t frame, const Bcc4Reader& from) {
  const auto& masks = from.info().channels.at(channel).masks;
  if (frame >= masks.size() || masks[frame].stored == 0) return;
  uint64_t missing = 0;
  from.mask_runs(channel, frame, [&](uint64_t begin, uint64_t end) { missing += end - begin; });
  state_->add_mask(channel, frame, {masks[frame], from.stored_block(masks[frame], "mask")}, missing);
}

void Bcc4Writer::copy_mask(int channel, uint32_t frame, std::span<const Bcc4Reader* const> from,
                           const Context& context) {
  if (from.size() == 1) return copy_mask(channel, frame, *from.front());
  SharedReservation memory(context.memory);
  std::vector<std::array<uint64_t, 2>> runs;
  for (const Bcc4Reader* const file : from) {
    const size_t before = runs.size();
    file->mask_runs(channel, frame, [&](uint64_t begin, uint64_t end) { runs.push_back({begin, end}); });
    memory.add((runs.size() - before) * sizeof(runs.front()), "missing data of blocks");
  }
  std::sort(runs.begin(), runs.end());
  MaskRunWriter out;
  for (const auto& [begin, end] : runs) out.add(begin, end);
  write_mask(channel, frame, out.finish(), context);
}

int32_t Bcc4Writer::common_slabs() const {
  const State& s = *state_;
  return s.index ? s.index->common_slabs(s.info) : 0;
}

void Bcc4Writer::show(VolumeInfo info, const Context& context) {
  State& s = *state_;
  s.begin();
  s.whole([&] { s.show(std::move(info), context); });
}

Bcc4Report Bcc4Writer::finish(const Context& context) {
  State& s = *state_;
  s.begin();
  s.closed = true;
  return s.finish(context);
}

} // namespace bccsplat
