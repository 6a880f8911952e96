// SPDX-License-Identifier: Apache-2.0
#include "series/read_series.h"

#include "series/read_ahead.h"
#include "series/text.h"

namespace bccsplat::series {

void read_series(FrameReader& reader, const FrameSpan& span, const char* label, Watch& watch,
                 const TakeFrame& take, const SampleBox* wanted) {
  const SeriesDescription& s = reader.description();
  const uint64_t total = source_bytes(s) / s.dims[3] * (span.end - span.first);
  const SampleBox all{{}, {s.dims[0], s.dims[1], s.dims[2]}};
  ReadAhead frames = wanted && *wanted != all ? ReadAhead(reader, span.first, span.end, *wanted)
                                              : ReadAhead(reader, span.first, span.end);
  uint64_t done = 0;
  for (uint64_t f = span.first; f < span.end; ++f)
    for (uint32_t c = 0; c < s.channels.size(); ++c) {
      watch.go_on();
      take(f, c, frames.next());
      done += frame_bytes(s, c);
      watch.show({label, done, total, concat("frame ", f + 1, "/", s.dims[3])});
    }
}

} // namespace bccsplat::series
