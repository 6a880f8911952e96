// SPDX-License-Identifier: Apache-2.0
#include "tool/import/resume.h"

#include <bccsplat.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "readers/error.h"
#include "readers/system.h"
#include "tool/cli.h"

namespace bcc4 {
namespace fs = std::filesystem;

namespace {

// Whether the journal of `output` lists a slab. Behind 16 bytes that say what it is of come records: u32
// bytes, u32 checksum, payload; the first has the options, each other one a slab
// (formats/bcc4/write/journal.h).
bool has_slab(const std::string& output) {
  constexpr std::streamoff options = 16;
  std::ifstream journal(to_path(output + ".journal"), std::ios::binary);
  std::array<char, 4> bytes{};
  if (!journal.seekg(options) || !journal.read(bytes.data(), bytes.size())) return false;
  std::streamoff length = 0;
  for (size_t i = bytes.size(); i-- > 0;) length = 256 * length + static_cast<unsigned char>(bytes[i]);
  return journal.seekg(0, std::ios::end) && journal.tellg() > options + 8 + length;
}

} // namespace

void add_resume_options(const Command& import, ResumeArguments& arguments) {
  import.add_flag("--resume", arguments.resume,
                  "Go on with an import that was interrupted. Needs the same input and options");
  import.add_flag(
      "--append", arguments.append,
      "Add the frames that the existing output lacks. Its frames must be the first ones of the input");
}

void add_live_option(const Command& import, ResumeArguments& arguments) {
  import
      .add_option("--live", arguments.live,
                  "Let info, slice and render read OUT.partial while it grows, every N slabs of layers")
      .type_name("N");
}

int32_t partial_mode(const ResumeArguments& arguments) {
  if (arguments.resume && arguments.append)
    fail_usage(
        "--resume and --append exclude each other: an interrupted --append leaves the old file as it was");
  if (arguments.append) return BCCSPLAT_PARTIAL_APPEND;
  return arguments.resume ? BCCSPLAT_PARTIAL_RESUME : BCCSPLAT_PARTIAL_KEEP;
}

std::string unfinished_work(const Device& device, const std::string& output) {
  if (!has_slab(output)) return "";
  std::error_code error;
  const std::string partial = output + ".partial";
  const uintmax_t bytes = fs::file_size(to_path(partial), error);
  if (error) return "";
  std::string how_far = byte_text(static_cast<double>(bytes));
  bccsplat_volume* opened = nullptr; // with --live
  if (bccsplat_volume_open_file(device.get(), partial.c_str(), nullptr, &opened) == BCCSPLAT_OK) {
    const Volume volume(opened);
    const bccsplat_volume_info v = volume_info(volume);
    how_far += concat(", ", v.dims[3], " of ", v.frames_expected, " frames");
  }
  return concat(partial, " of an import that did not end (", how_far, ")");
}

UnfinishedImport::~UnfinishedImport() {
  if (!begun_ || finished_) return;
  std::error_code error;
  const fs::path journal = to_path(output_ + ".journal"), partial = to_path(output_ + ".partial");
  if (worthless_ || !has_slab(output_)) { // nothing to go on from
    fs::remove(journal, error);
    fs::remove(partial, error);
  } else if (!quiet_) {
    std::fprintf(stderr,
                 "bcc4: what is done stays in %s; the same command with --resume goes on from there\n",
                 to_text(partial).c_str());
  }
}

} // namespace bcc4
