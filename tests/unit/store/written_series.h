// SPDX-License-Identifier: Apache-2.0
// A series written into memory, and all that looks at such a file.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "field/coefficients/coefficients.h"
#include "field/corrections.h"
#include "field/evaluate.h"
#include "field/masks.h"
#include "formats/bcc4/read/frame_sources.h"
#include "formats/bcc4/read/reader.h"
#include "formats/bcc4/read/samples.h"
#include "store/volume_writer.h"
#include "tests/unit/fit/fit_series.h"

namespace bccsplat::test {

inline WriteReport write(const WriterSettings& settings, const Series& series,
                         std::vector<std::byte>& bytes) {
  Bench bench(2);
  VolumeWriter writer(settings, create_memory_sink(bytes), bench.context);
  for (uint32_t t = 0; t < settings.dims[3]; ++t) {
    const FrameBox box = series.box(t);
    writer.add_frame(0, t, {&box, 1});
  }
  return writer.finish();
}

// A file and all that looks at it.
struct Opened {
  explicit Opened(std::vector<std::byte> file, int level = 0)
      : bytes(std::move(file)), reader(Bcc4Reader::open(open_memory_source(bytes))),
        samples(reader, bench.memory, 64 << 20, RelativeTo::base, level) {
    const VolumeInfo& info = reader->info();
    coefficients =
        std::make_unique<Coefficients>(samples, 0, make_kernel(info.recommended_kernel), 0.0f, 256 << 20);
    if (info.channels[0].residuals.any())
      corrections =
          std::make_unique<Corrections>(std::make_unique<Bcc4Corrections>(reader, 0), bench.memory, 16 << 20);
    if (!info.channels[0].masks.empty())
      masks = std::make_unique<Masks>(std::make_unique<Bcc4Masks>(reader, 0), bench.memory, 16 << 20);
    coefficients->set_corrections(corrections.get());
    coefficients->set_masks(masks.get());
  }
  [[nodiscard]] const Lattice4& lattice() const { return samples.lattice(); }
  [[nodiscard]] std::vector<float> at(std::span<const Vec4> points) {
    std::vector<float> values(points.size());
    (void)evaluate4(*coefficients, points, values, {}, bench.context);
    return values;
  }

  std::vector<std::byte> bytes;
  Bench bench{2};
  std::shared_ptr<Bcc4Reader> reader;
  Bcc4Samples samples;
  std::unique_ptr<Corrections> corrections;
  std::unique_ptr<Masks> masks;
  std::unique_ptr<Coefficients> coefficients;
};

inline void expect_sound(const Opened& file) {
  Bench bench(2);
  for (const Bcc4Damage& d : file.reader->verify_all(bench.context).damage) ADD_FAILURE() << d.message;
}

} // namespace bccsplat::test
