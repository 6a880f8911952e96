// SPDX-License-Identifier: Apache-2.0
// Writes and reads the journal of an unfinished file (journal.h has its layout).
#include "formats/bcc4/write/journal.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "base/bytes.h"
#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/layout.h"

namespace bccsplat {
namespace {

constexpr std::array<char, 8> mark{'B', 'C', 'C', '4', 'J', 'R', 'N', 'L'};
constexpr uint32_t version = 2;
constexpr size_t head_bytes = 16;
constexpr uint64_t longest_text = uint64_t{1} << 20; // of an option
constexpr size_t journal_entry_bytes = 48;

std::vector<std::byte> payload_of(const WrittenSlab& s) {
  ByteWriter out;
  out.write(s.slab), out.write(packed(s.at)), out.write(s.layers);
  out.write(static_cast<uint32_t>(s.chunks.size()));
  out.write(s.clamped);
  for (const Bcc4Chunk& c : s.chunks) {
    out.write(c.slot), out.write(c.offset), out.write(c.values_bytes), out.write(c.runs_bytes);
    out.write(c.runs_decoded), out.write(c.kept), out.write(c.holes), out.write(c.min_code);
    out.write(c.max_code), out.write(c.crc), out.write(c.coding), out.write(c.predictor);
    out.write(uint16_t{0});
  }
  return out.release();
}

WrittenSlab slab_of(std::span<const std::byte> payload) {
  ByteReader in(payload, "journal");
  WrittenSlab s;
  s.slab = in.read<int32_t>(), s.at = unpacked(in.read<uint32_t>()), s.layers = in.read<int32_t>();
  const auto n = in.read<uint32_t>();
  s.clamped = in.read<uint64_t>();
  if (in.remaining() != n * journal_entry_bytes)
    fail(Code::corrupt, "journal: ", n, " chunks do not fit their record");
  s.chunks.resize(n);
  for (Bcc4Chunk& c : s.chunks) {
    c.slab = s.slab;
    c.slot = in.read<uint32_t>(), c.offset = in.read<uint64_t>(), c.values_bytes = in.read<uint32_t>();
    c.runs_bytes = in.read<uint32_t>(), c.runs_decoded = in.read<uint32_t>(), c.kept = in.read<uint32_t>();
    c.holes = in.read<uint32_t>(), c.min_code = in.read<uint32_t>(), c.max_code = in.read<uint32_t>();
    c.crc = in.read<uint32_t>(), c.coding = in.read<uint8_t>(), c.predictor = in.read<uint8_t>();
    static_cast<void>(in.read<uint16_t>());
  }
  return s;
}

std::vector<std::byte> payload_of(const JournalOptions& options) {
  ByteWriter out;
  out.write(static_cast<uint32_t>(options.size()));
  for (const auto& [name, value] : options) out.write_string(name), out.write_string(value);
  return out.release();
}

JournalOptions options_of(std::span<const std::byte> payload) {
  ByteReader in(payload, "journal");
  JournalOptions options;
  for (auto left = in.read<uint32_t>(); left > 0; --left) {
    std::string name = in.read_string(longest_text);
    options.emplace_back(std::move(name), in.read_string(longest_text));
  }
  return options;
}

void write_record(std::span<const std::byte> payload, ByteWriter& out) {
  out.write(static_cast<uint32_t>(payload.size()));
  out.write(crc32_of(payload));
  out.write_bytes(payload);
}

// A journal that is read from its beginning, a record at a time: it may be long.
class JournalFile {
 public:
  explicit JournalFile(const std::string& path) : file_(open_file_source(path)), size_(file_->size()) {}
  [[nodiscard]] uint64_t position() const { return position_; }

  // The next bytes; none where there are fewer.
  std::optional<std::vector<std::byte>> take(size_t count) {
    if (count > size_ - position_) return std::nullopt;
    std::vector<std::byte> bytes(count);
    file_->read_at(position_, bytes);
    position_ += count;
    return bytes;
  }
  // The payload of the next record; none where that is cut or damaged, or was the last. A system that crashed
  // may have left zeros, which are no record.
  std::optional<std::vector<std::byte>> take_record() {
    const auto head = take(8);
    if (!head) return std::nullopt;
    ByteReader in(*head, "journal");
    const auto size = in.read<uint32_t>(), crc = in.read<uint32_t>();
    if (size == 0) return std::nullopt;
    auto payload = take(size);
    if (payload && crc32_of(*payload) != crc) payload.reset();
    return payload;
  }

 private:
  std::unique_ptr<ByteSource> file_;
  uint64_t size_, position_ = 0;
};

// What a journal begins with; none where nothing of it counts.
struct Head {
  uint32_t fingerprint;
  JournalOptions options;
};
std::optional<Head> take_head(JournalFile& journal) {
  const auto bytes = journal.take(head_bytes);
  if (!bytes) return std::nullopt;
  ByteReader in(*bytes, "journal");
  if (std::memcmp(in.take(mark.size()).data(), mark.data(), mark.size()) != 0) return std::nullopt;
  if (in.read<uint32_t>() != version) return std::nullopt;
  const auto fingerprint = in.read<uint32_t>();
  const auto options = journal.take_record();
  if (!options) return std::nullopt;
  return Head{fingerprint, options_of(*options)};
}

bool all_there(const WrittenSlab& slab, const ByteSource& file) {
  std::vector<std::byte> bytes;
  for (const Bcc4Chunk& c : slab.chunks) {
    if (c.offset > file.size() || c.stored() > file.size() - c.offset) return false;
    bytes.resize(c.stored());
    file.read_at(c.offset, bytes);
    if (crc32_of(bytes) != c.crc) return false;
  }
  return true;
}

// Returns what the root of an unfinished file shows; 0: nothing.
uint32_t frames_shown(const ByteSource& unfinished) {
  if (unfinished.size() < preamble_bytes) return 0;
  std::vector<std::byte> head(preamble_bytes);
  unfinished.read_at(0, head);
  try {
    const Preamble preamble = read_preamble(head, "unfinished");
    return preamble.root ? preamble.root->frames : 0;
  } catch (const Error&) {
    return 0; // nothing was shown yet
  }
}

} // namespace

void Bcc4Journal::require_options(const std::string& path, const JournalOptions& options) {
  const std::string journal = path + ".journal";
  if (!file_exists(journal)) return;
  JournalFile file(journal);
  const std::optional<Head> head = take_head(file);
  if (!head) return;
  for (const auto& [name, value] : options) {
    const auto it = std::find_if(head->options.begin(), head->options.end(),
                                 [&name = name](const auto& was) { return was.first == name; });
    if (it == head->options.end() || value.empty() || it->second.empty() || it->second == value) continue;
    fail(Code::wrong_state, journal, ": the unfinished file was made with other options (", name, ": ",
         it->second, ", not ", value, "); give the same ones, or start anew without resuming");
  }
}

Bcc4Journal::Bcc4Journal(const std::string& path, bool take_over, uint64_t interval, JournalOptions options)
    : path_(path + ".journal"), unfinished_path_(path + ".partial"), options_(std::move(options)),
      interval_(interval) {
  if (take_over && file_exists(path_))
    read(file_exists(unfinished_path_) ? open_unfinished().get() : nullptr);
  sink_ = create_journal_sink(path_, end_);
}

void Bcc4Journal::read(const ByteSource* unfinished) {
  JournalFile file(path_);
  const std::optional<Head> head = take_head(file);
  if (!head) return;
  fingerprint_ = head->fingerprint;
  found_ = true;
  end_ = file.position();
  if (unfinished) shown_frames_ = frames_shown(*unfinished);
  while (const auto payload = file.take_record()) {
    WrittenSlab s = slab_of(*payload);
    if (!unfinished || !all_there(s, *unfinished)) return;
    end_ = file.position();
    earlier_[{s.slab, s.at}] = std::move(s);
  }
}

void Bcc4Journal::start(uint32_t fingerprint) {
  if (found_) {
    if (fingerprint != fingerprint_)
      fail(Code::wrong_state, path_,
           ": the unfinished file was made from other input, with other options or by a version that "
           "resamples or codes otherwise; give the same, or start anew without resuming");
    return;
  }
  ByteWriter out;
  out.write_bytes(std::as_bytes(std::span(mark)));
  out.write(version);
  out.write(fingerprint);
  write_record(payload_of(options_), out);
  sink_->write_at(0, out.bytes());
  end_ = out.size();
}

const WrittenSlab* Bcc4Journal::find(int32_t slab, const ChannelLevel& at) const {
  const auto it = earlier_.find({slab, at});
  return it == earlier_.end() ? nullptr : &it->second;
}

std::unique_ptr<ByteSource> Bcc4Journal::open_unfinished() const {
  return open_file_source(unfinished_path_);
}

void Bcc4Journal::add(const WrittenSlab& slab) {
  ByteWriter out;
  write_record(payload_of(slab), out);
  pending_.insert(pending_.end(), out.bytes().begin(), out.bytes().end());
  for (const Bcc4Chunk& c : slab.chunks) pending_bytes_ += c.stored();
}

bool Bcc4Journal::commit_is_due() const {
  return pending_bytes_ >= interval_ ||
         (!pending_.empty() && std::chrono::steady_clock::now() - committed_ >= std::chrono::seconds(1));
}

void Bcc4Journal::commit() {
  if (pending_.empty()) return;
  sink_->write_at(end_, pending_);
  sink_->flush();
  end_ += pending_.size();
  pending_.clear();
  pending_bytes_ = 0;
  committed_ = std::chrono::steady_clock::now();
}

void Bcc4Journal::remove() { sink_->commit(); }

} // namespace bccsplat
