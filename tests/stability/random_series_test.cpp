// SPDX-License-Identifier: Apache-2.0
// Series of small things that move through air, of any size, type and coding: near what they were made of,
// and the same to the bit whoever works.
#include "tests/stability/stability.h"
#include "tests/support/emulated.h"

namespace host {
namespace {

// Gaussians that move, of values 0 to `most`, or from there down to 0.
struct Blobs {
  struct Blob {
    std::array<double, 3> at, speed;
    double sigma;
  };
  std::array<uint32_t, 4> dims{};
  std::vector<Blob> blobs;
  bccsplat_type type = BCCSPLAT_TYPE_F32;
  double most = 1;

  explicit Blobs(std::mt19937& random) {
    const auto between = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    for (size_t a = 0; a < 3; ++a) dims[a] = between(0, 1) < 0.1 ? 1 : static_cast<uint32_t>(between(8, 75));
    dims[3] = static_cast<uint32_t>(between(1, 8));
    blobs.resize(1 + random() % 3);
    for (Blob& b : blobs) {
      for (size_t a = 0; a < 3; ++a) b.at[a] = between(0, dims[a]), b.speed[a] = between(-1.5, 1.5);
      b.sigma = between(2.5, 7);
    }
    constexpr std::array<std::pair<bccsplat_type, double>, 4> types{{{BCCSPLAT_TYPE_U8, 255},
                                                                     {BCCSPLAT_TYPE_U16, 4000},
                                                                     {BCCSPLAT_TYPE_I16, -3000},
                                                                     {BCCSPLAT_TYPE_F32, 1}}};
    std::tie(type, most) = types[random() % 4];
  }
  [[nodiscard]] double at(uint32_t x, uint32_t y, uint32_t z, uint32_t t) const {
    double largest = 0;
    for (const Blob& b : blobs) {
      double sum = 0;
      const std::array<double, 3> p{1.0 * x, 1.0 * y, 1.0 * z};
      for (size_t a = 0; a < 3; ++a) sum += std::pow(p[a] - b.at[a] - b.speed[a] * t, 2);
      largest = larger(largest, std::exp(-sum / (2 * b.sigma * b.sigma)));
    }
    const double value = most * (largest < 1e-4 ? 0 : largest);
    return type == BCCSPLAT_TYPE_F32 ? value : std::round(value);
  }
  // x fastest.
  [[nodiscard]] std::vector<double> frame(uint32_t t) const {
    std::vector<double> values;
    for (uint32_t z = 0; z < dims[2]; ++z)
      for (uint32_t y = 0; y < dims[1]; ++y)
        for (uint32_t x = 0; x < dims[0]; ++x) values.push_back(at(x, y, z, t));
    return values;
  }
};

template<class Sample> std::vector<unsigned char> bytes_of(const std::vector<double>& values) {
  std::vector<unsigned char> bytes(values.size() * sizeof(Sample));
  for (size_t i = 0; i < values.size(); ++i) {
    const auto sample = static_cast<Sample>(values[i]);
    std::memcpy(bytes.data() + i * sizeof sample, &sample, sizeof sample);
  }
  return bytes;
}

std::vector<unsigned char> bytes_of(bccsplat_type type, const std::vector<double>& values) {
  switch (type) {
  case BCCSPLAT_TYPE_U8:
    return bytes_of<uint8_t>(values);
  case BCCSPLAT_TYPE_U16:
    return bytes_of<uint16_t>(values);
  case BCCSPLAT_TYPE_I16:
    return bytes_of<int16_t>(values);
  default:
    return bytes_of<float>(values);
  }
}

std::vector<unsigned char> written(const Device& device, const Blobs& s, bccsplat_writer_options o) {
  std::copy(s.dims.begin(), s.dims.end(), o.dims);
  MemoryFile file;
  const Writer writer = make_writer(device, file, o);
  for (uint32_t t = 0; t < s.dims[3]; ++t) {
    const std::vector<unsigned char> samples = bytes_of(s.type, s.frame(t));
    auto box = sized<bccsplat_box>();
    box.type = s.type, box.data = samples.data();
    for (size_t a = 0; a < 3; ++a) box.dims[a] = s.dims[a];
    EXPECT_OK(bccsplat_writer_add_frame(writer.get(), 0, t, &box, 1));
  }
  EXPECT_OK(bccsplat_writer_finish(writer.get(), nullptr));
  return file.bytes;
}

TEST(StabilityRandomSeries, AreNearTheirSourceAndTheSameForAnyThreads) {
  const Device one = make_device(1), some = make_device(3);
  for (unsigned seed = 0; seed < 48; seed += bccsplat::test::emulated ? 6 : 1) {
    std::mt19937 random(seed);
    const Blobs s(random);
    auto o = sized<bccsplat_writer_options>();
    const bool still = s.dims[3] == 1;
    if (random() % 2) o.lattice = still || random() % 2 ? BCCSPLAT_LATTICE_DEFAULT : BCCSPLAT_LATTICE_CC;
    if (random() % 3 == 0) o.measure = BCCSPLAT_MEASURE_ALL;
    if (random() % 3 == 0) o.levels = 1 + random() % 2;
    if (random() % 3 == 0) o.abs_error = std::fabs(s.most) / 500;
    const std::vector<unsigned char> bytes = written(one, s, o);
    EXPECT_TRUE(bytes == written(some, s, o)) << seed;
    double squares = 0, worst = 0;
    size_t count = 0;
    std::vector<Volume> volumes;
    for (const Device* device : {&one, &some}) {
      bccsplat_volume* opened = nullptr;
      ASSERT_OK(bccsplat_volume_open_memory(device->get(), bytes.data(), bytes.size(), nullptr, &opened));
      volumes.emplace_back(opened);
    }
    for (uint32_t t = 0; t < s.dims[3]; ++t) {
      const std::vector<double> source = s.frame(t);
      const std::vector<float> values = grid_of(cut_time(volumes[0], t));
      ASSERT_EQ(values.size(), source.size());
      EXPECT_TRUE(values == grid_of(cut_time(volumes[1], t))) << seed << ", frame " << t;
      for (size_t i = 0; i < values.size(); ++i, ++count) {
        const double error = values[i] - source[i];
        squares += error * error, worst = larger(worst, std::fabs(error));
      }
    }
    const double psnr = 10 * std::log10(s.most * s.most * static_cast<double>(count) / squares);
    EXPECT_GT(psnr, 34) << seed << ": " << s.dims[0] << " x " << s.dims[1] << " x " << s.dims[2] << " x "
                        << s.dims[3];
    if (o.abs_error > 0) {
      EXPECT_LE(worst, o.abs_error * 1.001) << seed;
    }
  }
}

} // namespace
} // namespace host
