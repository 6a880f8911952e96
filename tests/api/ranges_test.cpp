// SPDX-License-Identifier: Apache-2.0
// What a slice is said to read and what it reads, of each kind of file and slice; and reads that are merged.
#include "host_streams.h"

namespace host {
namespace {

struct Cut {
  const char* name;
  bccsplat_hyperplane plane;
  bccsplat_slice_options options = sized<bccsplat_slice_options>();
  bool tight = true; // no more is told than read, but for a twentieth
};

[[nodiscard]] Volume open_far(const Device& device, FarFile& file, uint64_t gap = 0, bool salvage = false) {
  const bccsplat_read_stream stream = file.stream(gap);
  auto o = sized<bccsplat_volume_options>();
  o.salvage = salvage;
  bccsplat_volume* v = nullptr;
  EXPECT_OK(bccsplat_volume_open_stream(device.get(), &stream, &o, &v));
  return Volume(v);
}

[[nodiscard]] std::vector<Range> ranges_of(const Volume& volume, const Cut& cut, uint32_t flags = 0) {
  uint64_t count = 0;
  EXPECT_OK(bccsplat_volume_get_ranges(volume.get(), &cut.plane, &cut.options, flags, nullptr, 0, &count));
  std::vector<uint64_t> pairs(2 * count);
  EXPECT_OK(bccsplat_volume_get_ranges(volume.get(), &cut.plane, &cut.options, flags, pairs.data(), count,
                                       nullptr));
  std::vector<Range> ranges;
  for (size_t i = 0; i < count; ++i) ranges.emplace_back(pairs[2 * i], pairs[2 * i + 1]);
  return ranges;
}

[[nodiscard]] Slice make(const Volume& volume, const Cut& cut) {
  bccsplat_slice* s = nullptr;
  EXPECT_OK(bccsplat_slice_create(volume.get(), &cut.plane, &cut.options, &s));
  return Slice(s);
}

// Cuts a slice of a fresh volume and reads all of its values; the reads are in the file.
void cut_anew(const Device& device, FarFile& file, const Cut& cut, bool salvage) {
  const Volume volume = open_far(device, file, 0, salvage);
  file.forget();
  const Slice slice = make(volume, cut);
  auto info = sized<bccsplat_slice_info>();
  ASSERT_OK(bccsplat_slice_get_info(slice.get(), &info));
  std::vector<float> values(info.dims[0] * info.dims[1] * info.dims[2]);
  ASSERT_OK(bccsplat_slice_sample_grid(slice.get(), nullptr, values.data()));
}

void expect_told(const Device& device, FarFile& file, const Cut& cut, bool salvage = false) {
  SCOPED_TRACE(cut.name);
  const Volume asked = open_far(device, file, 0, salvage);
  const std::vector<Range> told = ranges_of(asked, cut);
  ASSERT_FALSE(told.empty());
  for (size_t i = 1; i < told.size(); ++i)
    EXPECT_GT(told[i].first, told[i - 1].first + told[i - 1].second + 4096) << "sorted and merged";
  cut_anew(device, file, cut, salvage);
  ASSERT_FALSE(file.reads.empty());
  EXPECT_TRUE(covers(told, file.reads));
  const uint64_t read = bytes_of(file.reads);
  if (cut.tight) {
    EXPECT_LE(bytes_of(told), read + read / 10) << bytes_of(told) << " told, " << read << " read";
  }
}

// What the caches hold is not missing; what is missing is all that is read.
void expect_missing(const Device& device, FarFile& file, const Cut& cut, const Cut& next) {
  const Volume volume = open_far(device, file);
  (void)make(volume, cut);
  EXPECT_TRUE(ranges_of(volume, cut, BCCSPLAT_RANGES_MISSING).empty());
  EXPECT_FALSE(ranges_of(volume, cut).empty());
  const std::vector<Range> missing = ranges_of(volume, next, BCCSPLAT_RANGES_MISSING);
  EXPECT_LT(bytes_of(missing), bytes_of(ranges_of(volume, next)));
  file.forget();
  (void)make(volume, next);
  EXPECT_TRUE(covers(missing, file.reads));
  EXPECT_LE(bytes_of(missing), bytes_of(file.reads) * 21 / 20);
}

constexpr double box[6] = {4, 4, 4, 16, 20, 20};

std::vector<Cut> cuts(bool extracted, bool corrections) {
  std::vector<Cut> list{{"instant", plane_of(0, 0, 0, 1, -6.3)},
                        {"frame", plane_of(0, 0, 0, 2, -8)},
                        {"interval", plane_of(0, 0, 0, 1, -6)},
                        {"first", plane_of(0, 0, 0, 1, 0)},
                        {"box", plane_of(0, 0, 0, 1, -6.3)},
                        {"maximum", plane_of(0, 0, 0, 1, -6)},
                        {"kernel", plane_of(0, 0, 0, 1, -6.3)},
                        {"resampled", plane_of(0, 0, 0, 1, -6.3)},
                        {"axis", plane_of(1, 0, 0, 0, -30)},
                        {"oblique", plane_of(0.3, 0.2, -0.1, 1, -8)},
                        {"oblique through all", plane_of(1, 0.5, 0.2, 0.6, -60)}};
  list[2].options.interval[0] = -1.5, list[2].options.interval[1] = 2;
  list[4].options.box = box;
  list[5].options.thickness = 3, list[5].options.slab = BCCSPLAT_SLAB_MAXIMUM;
  list[6].options.kernel = "fine";
  list[7].options.method = BCCSPLAT_METHOD_RESAMPLED;
  for (size_t i = 7; i < list.size(); ++i) list[i].tight = !corrections; // whole frames of them are told
  if (!extracted) return list;
  list.push_back({"extracted", plane_of(0.3, 0.2, -0.1, 1, -8)});
  list.back().options.method = BCCSPLAT_METHOD_EXTRACTED;
  return list;
}

TEST(Ranges, HoldWhatSlicesOfSamplesRead) {
  const Device device = make_device();
  const NoiseSeries series;
  FarFile file(written(device, series, series.options()));
  EXPECT_GT(file.bytes.size(), 900'000u);
  const std::vector<Cut> all = cuts(true, false);
  for (const Cut& cut : all) expect_told(device, file, cut);
  for (const size_t i : {0u, 4u, 9u}) expect_told(device, file, all[i], true); // and what lies beside them
  expect_missing(device, file, {"", plane_of(0, 0, 0, 1, -6.3)}, {"", plane_of(0, 0, 0, 1, -9)});
  // A part of a frame is a part of the bytes.
  const Volume volume = open_far(device, file);
  EXPECT_LT(bytes_of(ranges_of(volume, all[4])), bytes_of(ranges_of(volume, all[0])) * 3 / 4);
}

TEST(Ranges, HoldWhatCoarserLevelsRead) {
  const Device device = make_device();
  const NoiseSeries series;
  auto o = series.options();
  o.levels = 1;
  FarFile file(written(device, series, o));
  const Volume volume = open_far(device, file);
  for (Cut cut : {cuts(false, false)[0], cuts(false, false)[4], cuts(false, false)[9]}) {
    const uint64_t fine = bytes_of(ranges_of(volume, cut));
    cut.options.level = 1;
    expect_told(device, file, cut);
    EXPECT_LT(bytes_of(ranges_of(volume, cut)), fine / 2) << cut.name;
  }
}

// Labels are cut through the samples nearest to where they are asked for, half a frame or a column away.
TEST(Ranges, HoldWhatLabelsRead) {
  const Device device = make_device();
  NoiseSeries series;
  series.nt = 40;
  auto channel = sized<bccsplat_channel_options>();
  channel.set_mask = BCCSPLAT_CHANNEL_LABELS;
  auto o = series.options();
  o.lattice = BCCSPLAT_LATTICE_CC, o.channels = &channel, o.channel_count = 1;
  FarFile file(written(device, series, o));
  const Volume volume = open_far(device, file);
  for (double t = 0.5; t < 39; ++t) {
    const Cut asked{"half", plane_of(0, 0, 0, 1, -t)}, made{"whole", plane_of(0, 0, 0, 1, -t - .5)};
    EXPECT_EQ(ranges_of(volume, asked), ranges_of(volume, made)) << t;
  }
  const Cut moment{"moment", plane_of(0, 0, 0, 1, -7.5)};
  expect_told(device, file, moment);
  expect_told(device, file, {"column", plane_of(1, 0, 0, 0, -15.5)});
  const Volume fetched = open_far(device, file);
  EXPECT_OK(bccsplat_volume_prefetch(fetched.get(), &moment.plane, &moment.options));
  file.forget();
  (void)make(fetched, moment);
  EXPECT_TRUE(file.reads.empty());
}

TEST(Ranges, HoldMasksAndCorrections) {
  const Device device = make_device();
  NoiseSeries series;
  series.nx = 40, series.holes = true;
  auto o = series.options();
  o.abs_error = 3;
  FarFile file(written(device, series, o));
  for (const Cut& cut : cuts(true, true)) expect_told(device, file, cut);
  expect_missing(device, file, {"", plane_of(0, 0, 0, 1, -6.3)}, {"", plane_of(0, 0, 0, 1, -9)});
}

// Boxes of a slice that are far from each other have no brick of corrections in common, but the table of the
// frame.
TEST(Ranges, OfABoxLeaveOutCorrectionsElsewhere) {
  const Device device = make_device();
  NoiseSeries series;
  series.nx = 128, series.ny = 20, series.nz = 20, series.nt = 4;
  auto o = series.options();
  o.abs_error = 3, o.store = BCCSPLAT_STORE_WAVELETS, o.lattice = BCCSPLAT_LATTICE_CC;
  FarFile file(written(device, series, o));
  constexpr double left[6] = {0, 0, 0, 8, 19, 19}, right[6] = {119, 0, 0, 127, 19, 19};
  std::vector<Range> both;
  uint64_t read = 0;
  for (const double* box : {left, right}) {
    Cut cut{"a box", plane_of(0, 0, 0, 1, -2)};
    cut.options.box = box;
    expect_told(device, file, cut);
    read += bytes_of(file.reads);
    both.insert(both.end(), file.reads.begin(), file.reads.end());
  }
  const uint64_t twice = read - bytes_of(both);
  EXPECT_LT(20 * twice, read) << twice << " of " << read << " bytes are read for either box";
}

// Of an interval beyond the end of the series the last frame is left, whose mask it has.
TEST(Ranges, HoldTheMaskOfTheLastFrame) {
  const Device device = make_device();
  NoiseSeries series;
  series.nx = 40, series.scattered = true;
  FarFile file(written(device, series, series.options()));
  Cut cut{"beyond the end", plane_of(0, 0, 0, 1, -5)};
  cut.options.interval[0] = 20, cut.options.interval[1] = 21;
  expect_told(device, file, cut);
}

TEST(Ranges, HoldWhatOtherSeriesRead) {
  const Device device = make_device();
  NoiseSeries series;
  series.nx = 40;
  auto o = series.options();
  o.ends = BCCSPLAT_ENDS_PERIODIC;
  FarFile periodic(written(device, series, o));
  for (const Cut& cut : cuts(true, false)) expect_told(device, periodic, cut);
  o.ends = 0, o.lattice = BCCSPLAT_LATTICE_CC;
  FarFile cartesian(written(device, series, o));
  for (const Cut& cut : cuts(false, false))
    if (!cut.options.kernel) expect_told(device, cartesian, cut);
  auto part = sized<bccsplat_series_part>();
  std::vector<double> times(series.nt);
  for (uint32_t t = 0; t < series.nt; ++t) times[t] = t;
  part.first = 4, part.end = 9, part.times = times.data();
  o.lattice = 0, o.part = &part;
  FarFile piece(written(device, series, o));
  for (const Cut& cut : cuts(true, false)) expect_told(device, piece, cut);
  series.nt = 1;
  FarFile still(written(device, series, series.options()));
  expect_told(device, still, {"static", plane_of(0, 0, 0, 1, 0)});
}

// On the source's grid a frame of wavelets is made of its own layer, moments of those around them.
TEST(Ranges, HoldWhatWaveletsRead) {
  const Device device = make_device();
  NoiseSeries series;
  series.nx = 40, series.nt = 40;
  auto o = series.options();
  const double error = 4;
  const auto bytes = NoiseSeries::bytes_channel();
  o.lattice = BCCSPLAT_LATTICE_CC, o.scale = 1, o.time_scale = 1;
  o.store = BCCSPLAT_STORE_WAVELETS, o.wavelet_errors = &error;
  o.channels = &bytes, o.channel_count = 1;
  FarFile file(written(device, series, o));
  for (const Cut& cut : cuts(false, false))
    if (!cut.options.kernel) expect_told(device, file, cut);
  Cut frame{"frame", plane_of(0, 0, 0, 1, -15)}, moment{"moment", plane_of(0, 0, 0, 1, -15.5)};
  frame.options.kernel = moment.options.kernel = "exact";
  expect_told(device, file, frame);
  expect_told(device, file, moment);
  const Volume volume = open_far(device, file);
  EXPECT_LT(bytes_of(ranges_of(volume, frame)), bytes_of(ranges_of(volume, moment)) * 2 / 3);
  EXPECT_OK(bccsplat_volume_prefetch(volume.get(), &frame.plane, &frame.options));
  file.forget();
  (void)make(volume, frame);
  EXPECT_TRUE(file.reads.empty());
}

// At moments of an interval, a layer further to either side.
TEST(Ranges, HoldWhatValuesRead) {
  const Device device = make_device();
  const NoiseSeries series;
  FarFile file(written(device, series, series.options()));
  for (const auto& [t0, t1] : {std::pair{4.1, 4.1}, {0.3, 2.2}, {6.0, 6.6}, {9.7, 13.0}}) {
    Cut cut{"", plane_of(0, 0, 0, 1, -t0)};
    cut.options.interval[0] = -1, cut.options.interval[1] = t1 - t0 + 1;
    const std::vector<Range> told = ranges_of(open_far(device, file), cut);
    const Volume volume = open_far(device, file);
    file.forget();
    std::vector<double> points;
    for (int i = 0; i <= 20; ++i)
      points.insert(points.end(), {5.0 * i, 1.5 * i, i + 0.3, t0 + (t1 - t0) * i / 20});
    std::vector<float> values(21);
    ASSERT_OK(bccsplat_volume_evaluate(volume.get(), 21, points.data(), values.data(), nullptr));
    ASSERT_FALSE(file.reads.empty());
    EXPECT_TRUE(covers(told, file.reads)) << t0 << " to " << t1;
  }
}

TEST(Ranges, AreTheCallersToFill) {
  const Device device = make_device();
  NoiseSeries series;
  series.nx = 40;
  FarFile file(written(device, series, series.options()));
  const Volume volume = open_far(device, file);
  const Cut cut{"", plane_of(0, 0, 0, 1, -6)};
  const std::vector<Range> all = ranges_of(volume, cut);
  uint64_t few[3] = {7, 7, 7}, count = 0;
  EXPECT_OK(bccsplat_volume_get_ranges(volume.get(), &cut.plane, nullptr, 0, few, 1, &count));
  EXPECT_EQ(count, all.size());
  EXPECT_EQ(few[0], all[0].first);
  EXPECT_EQ(few[1], all[0].second);
  EXPECT_EQ(few[2], 7u);
  EXPECT_EQ(bccsplat_volume_get_ranges(volume.get(), &cut.plane, nullptr, 2, nullptr, 0, &count),
            BCCSPLAT_ERROR_INVALID_ARGUMENT);
  const auto beyond = plane_of(0, 0, 0, 1, -50);
  EXPECT_EQ(bccsplat_volume_get_ranges(volume.get(), &beyond, nullptr, 0, nullptr, 0, &count),
            BCCSPLAT_ERROR_OUT_OF_DOMAIN);
  const auto aside = plane_of(1, 1, 1, 0, 50);
  EXPECT_OK(bccsplat_volume_get_ranges(volume.get(), &aside, nullptr, 0, nullptr, 0, &count));
  EXPECT_EQ(count, 0u);
}

// Of a slice whose chunks stand apart in the file.
TEST(MergeGap, DecidesHowManyReadsThereAre) {
  const Device device = make_device();
  const NoiseSeries series;
  FarFile file(written(device, series, series.options()));
  const Cut cut = cuts(true, false)[4];
  struct Found {
    size_t reads = 0;
    uint64_t bytes = 0, largest = 0;
    std::vector<float> values;
  };
  const auto with_gap = [&](uint64_t gap) {
    const Volume volume = open_far(device, file, gap);
    file.forget();
    const Slice slice = make(volume, cut);
    Found f;
    f.reads = file.reads.size();
    for (const Range& r : file.reads) f.bytes += r.second, f.largest = std::max(f.largest, r.second);
    f.values.resize(13 * 17 * 17);
    EXPECT_OK(bccsplat_slice_sample_grid(slice.get(), nullptr, f.values.data()));
    return f;
  };
  const Found none = with_gap(1), usual = with_gap(0), same = with_gap(4096), wide = with_gap(256 << 10),
              endless = with_gap(UINT64_MAX);
  EXPECT_EQ(usual.reads, same.reads);
  EXPECT_EQ(usual.bytes, same.bytes);
  EXPECT_LE(usual.reads, none.reads);
  EXPECT_LT(wide.reads, usual.reads);
  EXPECT_GT(wide.bytes, usual.bytes);
  EXPECT_LE(usual.largest, 256u << 10);
  EXPECT_LE(wide.largest, 4u << 20);
  EXPECT_LE(endless.reads, wide.reads);
  for (const Found& f : {none, same, wide, endless}) EXPECT_EQ(f.values, usual.values);
  // Ranges are told as they are read.
  EXPECT_LT(ranges_of(open_far(device, file, 256 << 10), cut).size(),
            ranges_of(open_far(device, file, 1), cut).size());
}

} // namespace
} // namespace host
