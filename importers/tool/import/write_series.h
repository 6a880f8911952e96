// SPDX-License-Identifier: Apache-2.0
// A series, or a part of it, through the library's writer into a file.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "readers/frame_reader.h"
#include "tool/import/plan_file.h"
#include "tool/import/summary.h"
#include "tool/import/writer_settings.h"
#include "tool/options.h"

namespace bcc4 {

// What a run reads and writes.
struct ImportScope {
  std::string output;
  std::vector<PlannedSource> sources;
  std::vector<std::pair<std::string, std::string>> attributes; // how the input was read
  std::vector<std::pair<std::string, std::string>> kept;       // of a file that goes on
  std::optional<FrameSpan> part;                               // of the series; none: all of it
  std::optional<SampleBox> block; // of the part, or of the series; none: all of space
  uint64_t lead = 0;              // frames before the part, back to one that is there in every channel
};

// How frames become layers where it is not the usual way, as the attribute import.filtering of a file tells;
// nothing else in a file does.
[[nodiscard]] std::string filtering_text(const WriterSettings& settings);

// The attribute of a file whose samples outside faces and ends are not predicted by whole frames, as those of
// blocks are.
inline constexpr const char* kPredictions = "import.predictions";

// Gives a frame to a writer, as the reader's boxes, without a copy. name: of its file, for error texts.
void add_frame(const Writer& writer, uint32_t channel, double time, const Frame& frame,
               const std::string& name);

// Returns what write(settings) does. Where that misses the PSNR that a sample of the series has promised, it
// is called again, first with finer steps, in the end with corrections, as `attempts` say, whose first one
// then is that which did. resumes: so does it where what is to be resumed was begun with other options, as
// one of these tries may have begun it.
[[nodiscard]] ImportResult with_finer_steps(std::vector<WriterSettings>& attempts,
                                            const CommonOptions& common, bool resumes,
                                            const std::function<ImportResult(const WriterSettings&)>& write);
// Writes the series with these settings.
[[nodiscard]] ImportResult write_once(FrameReader& reader, const Device& device,
                                      const WriterSettings& settings, const ImportScope& scope,
                                      const CommonOptions& common);
// Does so with finer steps where a PSNR is missed, in the end with corrections.
[[nodiscard]] ImportResult write_series(FrameReader& reader, const Device& device,
                                        std::vector<WriterSettings>& attempts, const ImportScope& scope,
                                        const CommonOptions& common);
// Adds a part to the file that has the frames before it. A file that does not tell all that its continuation
// needs to know is made anew from all frames.
[[nodiscard]] ImportResult append_series(FrameReader& reader, const Device& device,
                                         const WriterSettings& settings, const ImportScope& scope,
                                         const CommonOptions& common);

} // namespace bcc4
