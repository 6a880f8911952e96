// SPDX-License-Identifier: Apache-2.0
// A record of what an unfinished writer has written, in a file beside its own: an interrupted import goes on
// from there.
//
// The journal is private to one version of the library: "BCC4JRNL", u32 version, u32 fingerprint of what the
// file is made of; then records: u32 bytes, u32 CRC-32, payload. The first one has the options of the writer,
// and without it nothing of the journal counts. The others are written when the chunks they list
// are safe on disk; the first one that fails its checks ends the journal, and so does one whose chunks are
// not in the unfinished file as it says: that may have been cut, damaged, or written by another since.
// bcc4 looks whether any record follows the options (importers/tool/import/resume.cpp).
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/files.h"
#include "formats/bcc4/coding/chunk_entry.h"
#include "formats/bcc4/info.h"

namespace bccsplat {

// One slab of one channel at a level as the file holds it; without chunks all of it is air.
struct WrittenSlab {
  int32_t slab = 0;
  ChannelLevel at = 0;
  int32_t layers = 0;
  uint64_t clamped = 0; // samples
  std::vector<Bcc4Chunk> chunks;
};

// What a writer was asked for: names and values, in an order of its own. The data settle what is empty.
using JournalOptions = std::vector<std::pair<std::string, std::string>>;

class Bcc4Journal {
 public:
  // Throws wrong_state, and tells the first that differs, where the journal of `path` has other options.
  // Where there is none, or nothing of it counts, nothing is taken over, and nothing has to agree. It only
  // reads.
  static void require_options(const std::string& path, const JournalOptions& options);

  // A commit is due after so many bytes of chunks, or after a second: a crash loses no more than that, and
  // the cost of waiting for the disk is spread over as much.
  static constexpr uint64_t default_interval = 1u << 18;
  // The journal of the file that is to be `path`. With `take_over` it reads the records of an earlier writer,
  // if there is a journal, and their chunks in the unfinished file.
  Bcc4Journal(const std::string& path, bool take_over, uint64_t interval = default_interval,
              JournalOptions options = {});

  // Frames that the unfinished file shows to readers; 0: none, or nothing is taken over.
  [[nodiscard]] uint32_t shown_frames() const { return shown_frames_; }
  // Says before anything else what the file is made of. A journal that is taken over must agree
  // (Code::wrong_state).
  void start(uint32_t fingerprint);
  // The slab as an earlier writer left it; null where it is still to be written.
  [[nodiscard]] const WrittenSlab* find(int32_t slab, const ChannelLevel& at) const;
  // Opens the file that has the chunks of such slabs.
  [[nodiscard]] std::unique_ptr<ByteSource> open_unfinished() const;
  void add(const WrittenSlab& slab); // written by commit
  [[nodiscard]] bool commit_is_due() const;
  // Writes the records of all slabs added; their chunks must be safe on disk.
  void commit();
  // Removes the journal; the file has its final name.
  void remove();

 private:
  void read(const ByteSource* unfinished); // the journal
  std::string path_, unfinished_path_;
  JournalOptions options_;
  std::unique_ptr<ByteSink> sink_;
  bool found_ = false;       // there was a journal to take over
  uint32_t fingerprint_ = 0; // of that journal
  uint32_t shown_frames_ = 0;
  std::map<std::pair<int32_t, ChannelLevel>, WrittenSlab> earlier_;
  std::vector<std::byte> pending_;
  uint64_t end_ = 0, pending_bytes_ = 0, interval_;
  std::chrono::steady_clock::time_point committed_ = std::chrono::steady_clock::now();
};

} // namespace bccsplat
