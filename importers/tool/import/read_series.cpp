// SPDX-License-Identifier: Apache-2.0
#include "tool/import/read_series.h"

#include "readers/read_ahead.h"
#include "readers/text.h"
#include "tool/interrupt.h"
#include "tool/progress.h"

namespace bcc4 {

void read_series(FrameReader& reader, const FrameSpan& span, const char* label, bool shown,
                 const TakeFrame& take) {
  const SeriesDescription& s = reader.description();
  Progress progress(label, source_bytes(s) / s.dims[3] * (span.end - span.first), true, !shown);
  ReadAhead frames(reader, span.first, span.end);
  uint64_t done = 0;
  for (uint64_t f = span.first; f < span.end; ++f)
    for (uint32_t c = 0; c < s.channels.size(); ++c) {
      stop_if_interrupted();
      take(f, c, frames.next());
      progress.update(done += frame_bytes(s, c), concat("frame ", f + 1, "/", s.dims[3]));
    }
}

} // namespace bcc4
