// SPDX-License-Identifier: Apache-2.0
// Opens a file: its root, the metadata and the directory of index pages that it leads to.
#include "base/would_block.h"
#include "formats/bcc4/counts.h"
#include "formats/bcc4/field_base.h"
#include "formats/bcc4/metadata.h"
#include "formats/bcc4/read/reader_state.h"

namespace bccsplat {

// The series as far as an unfinished file can be looked at: of fewer frames, on the layers that are there.
VolumeInfo Bcc4Reader::State::shown_part() const {
  const std::string& name = source->name();
  const uint32_t frames = root.frames;
  if (frames > info.lattice.dims[3])
    fail(Code::corrupt, name, ": the root says that ", frames, " frames can be looked at, the series has ",
         info.lattice.dims[3]);
  VolumeInfo part = info;
  part.unfinished = true;
  part.lattice.dims[3] = frames;
  for (LevelInfo& level : part.levels) level.lattice.dims[3] = frames;
  const auto cut = [&](auto& list) {
    if (!list.empty()) list.resize(frames);
  };
  cut(part.time.times);
  for (ChannelInfo& c : part.channels) {
    cut(c.frames), cut(c.residuals.frames), cut(c.residuals.tables), cut(c.masks);
    if (frames < info.lattice.dims[3]) c.sums.reset(); // they are of all frames
  }
  return part;
}

// A root that is not valid is being replaced by a writer that goes on, which left a copy of the new one
// behind the state; or the record was read while it was written, and is valid the next time.
void Bcc4Reader::State::read_head() {
  std::vector<std::byte> head(std::min(source->size(), preamble_bytes));
  read(0, head);
  Preamble preamble = read_preamble(head, source->name());
  if (!preamble.root) {
    read(0, head);
    preamble = read_preamble(head, source->name());
  }
  if (!preamble.root && source->size() >= preamble_bytes + root_bytes) {
    std::vector<std::byte> last(root_bytes);
    read(source->size() - root_bytes, last);
    preamble.root = read_root_copy(last, source->size());
    root_damaged = preamble.root.has_value();
  }
  if (!preamble.root)
    fail(Code::checksum_mismatch, source->name(), ": no valid root record (", preamble.problem, ")");
  root = *preamble.root;
}

void Bcc4Reader::State::open() {
  read_head();
  check_root();
  read_description();
  prepare_coders();
  bytes.file = root.file_bytes;
  bytes.runs = root.runs_bytes, bytes.values = root.values_bytes, bytes.index = root.index_bytes;
  bytes.unused = root.file_bytes - root.runs_bytes - root.values_bytes - root.index_bytes;
}

void Bcc4Reader::State::check_root() const {
  const std::string& name = source->name();
  if (root.file_bytes > source->size() && !limits.salvage)
    fail(Code::truncated, name, ": ", source->size(), " bytes of ", root.file_bytes, "; it was cut short");
  if (root.metadata.decoded > limits.metadata_bytes)
    fail(Code::limit_exceeded, name, ": metadata of ", root.metadata.decoded, " bytes, the limit is ",
         limits.metadata_bytes);
  if (root.directory.decoded > limits.directory_bytes)
    fail(Code::limit_exceeded, name, ": index directory of ", root.directory.decoded, " bytes, the limit is ",
         limits.directory_bytes);
  check_index_counts(root);
}

void Bcc4Reader::State::read_description() {
  std::vector<std::byte> metadata, directory;
  Attempts attempts; // both before an opening that has to wait gives up
  attempts.attempt([&] { metadata = read_block(root.metadata, "metadata"); });
  if (attempts.waits()) attempts.attempt([&] { directory = read_block(root.directory, "index directory"); });
  attempts.throw_if_waiting();
  info = read_metadata(metadata, root.metadata.offset, limits);
  if (root.unfinished) shown = shown_part();
  directory = read_block(root.directory, "index directory");
  pages = read_directory(directory, info, root, root.directory.offset);
}

void Bcc4Reader::State::prepare_coders() {
  for (const ChannelInfo& c : info.channels) {
    const float zero = bases.emplace_back(field_base(info, c)).value;
    coders.emplace_back(c);
    from_base.push_back(zero == c.air ? coders.back() : SampleCoder(c, zero));
  }
  for (int level = 0; level < info.level_count(); ++level) slots.push_back(slot_dims(info.level(level)));
}

std::shared_ptr<Bcc4Reader> Bcc4Reader::open(std::unique_ptr<ByteSource> source, const Bcc4Limits& limits) {
  auto state = std::make_unique<State>(std::move(source), limits);
  state->in_file([&] { state->open(); });
  return std::shared_ptr<Bcc4Reader>(new Bcc4Reader(std::move(state)));
}

} // namespace bccsplat
