// What a writer under way has finished, beside its file: an interrupted import goes on from there.
//
// The journal is private to one version of the library: "BCC4JRNL", u32 version, u32 fingerprint of what the
// file is made of; then records: u32 bytes, u32 CRC-32, payload. A record is written when the chunks it lists
// are safe on disk; the first one that does not check out ends the journal.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/files.h"
#include "formats/bcc4/bcc4.h"

namespace bccsplat {

// One slab of one channel as it stands in the file; no chunks: all air.
struct WrittenSlab {
  int32_t slab = 0, channel = 0, layers = 0;
  uint64_t clamped = 0; // samples
  std::vector<Bcc4Chunk> chunks;
};

class Bcc4Journal {
 public:
  // Chunk bytes between two commits, or a second: what a crash loses at most, and what waiting for the disk
  // is spread over.
  static constexpr uint64_t default_interval = 1u << 18;
  // `take_over`: with the records of an earlier writer, when there is a journal.
  Bcc4Journal(std::string path, bool take_over, uint64_t interval = default_interval);

  // Before anything else: what the file is made of. A journal taken over must be of the same
  // (Code::wrong_state).
  void start(uint32_t fingerprint);
  // Of an earlier writer; null: to be written.
  [[nodiscard]] const WrittenSlab* find(int32_t slab, int32_t channel) const;
  void add(const WrittenSlab& slab); // written by commit
  [[nodiscard]] bool commit_is_due() const;
  // The chunks are safe on disk: now their records.
  void commit();
  // The file has its name.
  void remove();

 private:
  void read(std::span<const std::byte> bytes);
  std::string path_;
  std::unique_ptr<ByteSink> sink_;
  bool found_ = false;                                         // an earlier writer's
  uint32_t fingerprint_ = 0;                                   // its
  std::map<std::pair<int32_t, int32_t>, WrittenSlab> earlier_; // by slab, channel
  std::vector<std::byte> pending_;
  uint64_t end_ = 0, pending_bytes_ = 0, interval_;
  std::chrono::steady_clock::time_point committed_ = std::chrono::steady_clock::now();
};

} // namespace bccsplat
