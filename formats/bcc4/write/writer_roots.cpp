// SPDX-License-Identifier: Apache-2.0
// Makes a file of what is written so far, or of all of it: directory and metadata behind it, and the root
// that leads to them.
#include <utility>

#include "formats/bcc4/metadata.h"
#include "formats/bcc4/write/writer_state.h"

namespace bccsplat {
namespace {

// Packs a table that a reader with the usual limits takes.
PackedBlock pack_table(std::span<const std::byte> decoded, uint64_t limit, const char* what) {
  if (decoded.size() > limit)
    fail(Code::limit_exceeded, "writer: ", what, " of ", decoded.size(), " bytes, the limit of readers is ",
         limit);
  return pack_block(decoded);
}

} // namespace

Root Bcc4Writer::State::append_state(const VolumeInfo& of, std::span<const PageRef> pages, uint64_t beyond) {
  shown.replaced += std::exchange(shown.bytes, 0);
  Root root;
  const Bcc4Limits limits{};
  if (of.lattice.layers() > limits.planes)
    fail(Code::limit_exceeded, "writer: a series of ", of.lattice.layers(),
         " layers, the limit of readers is ", limits.planes);
  root.directory =
      file.append(pack_table(write_directory(pages), limits.directory_bytes, "an index directory"));
  root.metadata = file.append(pack_table(write_metadata(of), limits.metadata_bytes, "metadata"));
  root.file_bytes = file.position();
  root.chunks = index->chunks(), root.runs_bytes = index->runs_bytes();
  root.values_bytes = index->values_bytes();
  root.index_bytes = root.file_bytes - unused - shown.replaced - index->replaced_bytes() - beyond -
                     root.runs_bytes - root.values_bytes;
  return root;
}

void Bcc4Writer::State::write_head(Root root) {
  if (root.sequence > 1) { // there is a valid record at any moment
    root.file_bytes += root_bytes;
    shown.replaced += root_bytes;
    file.append(write_root(root));
  }
  file.sync();
  if (!(root.unfinished && options.journal && root.frames < options.journal->shown_frames()))
    file.overwrite(0, write_preamble(root));
}

void Bcc4Writer::State::show(VolumeInfo of, const Context& context) {
  Bcc4Report ignored;
  index->describe(of, ignored);
  frames->describe(of);
  tidy(of);
  check_info(of, Code::invalid_argument);
  context.progress.check();
  Root root = append_state(of, index->show_pages(), frames->masks_beyond(of.lattice.dims[3]));
  shown.bytes = root.directory.padded() + root.metadata.padded();
  root.unfinished = true, root.frames = of.lattice.dims[3];
  root.sequence = ++shown.times;
  write_head(root);
}

Bcc4Report Bcc4Writer::State::finish(const Context& context) {
  index->check_ends(info);
  Bcc4Report report;
  const std::vector<PageRef> pages = index->finish_pages();
  index->describe(info, report);
  frames->describe(info);
  info.unfinished = false, info.expected_frames = 0;
  tidy(info);
  check_info(info, Code::invalid_argument);
  context.progress.check();

  Root root = append_state(info, pages, 0);
  root.sequence = shown.times + 1;
  write_head(root);
  // It may have the name of this one, and not every system replaces a file that is open.
  options.earlier.reset();
  file.commit();
  if (options.journal) options.journal->remove();

  report.chunks = root.chunks;
  report.bytes_corrections = frames->correction_bytes();
  report.slabs_reused = slabs_reused;
  report.bytes = {file.position(), root.runs_bytes, root.values_bytes, root.index_bytes,
                  unused + shown.replaced + index->replaced_bytes()};
  return report;
}

} // namespace bccsplat
