// SPDX-License-Identifier: Apache-2.0
// The paper's wish: volumes that are reconstructed from projections on the BCC lattice itself. A phantom of
// smooth balls, whose projections are known in closed form, is back-projected by the filter of Ramachandran
// and Lakshminarayanan at the sites of CC and of BCC, and the volume on CC is resampled to BCC.
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include <unistd.h>

#include "base/error.h"
#include "lattice/lattice.h"
#include "tests/bench/paper/paper.h"
#include "tests/bench/scale/scale_host.h"

namespace bccsplat::bench {
namespace {

using host::sized;

struct SmoothBall {
  Vec3 at;
  double sigma, height;
};

// Balls in a cube of samples; frequencies beyond the lattices' band hold less than a thousandth.
std::vector<SmoothBall> phantom(double n) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(-0.26, 0.26), size(1.4, 4), height(0.3, 1);
  std::vector<SmoothBall> balls;
  for (int i = 0; i < 24; ++i)
    balls.push_back({{n * (0.5 + place(random)), n * (0.5 + place(random)), n * (0.5 + place(random))},
                     size(random),
                     height(random)});
  return balls;
}

double density(const std::vector<SmoothBall>& balls, const Vec3& p) {
  double sum = 0;
  for (const SmoothBall& b : balls) {
    const Vec3 d = p - b.at;
    sum += b.height * std::exp(-dot(d, d) / (2 * b.sigma * b.sigma));
  }
  return sum;
}

// Projections by parallel rays across the z axis: for each angle a detector of samples 1 apart in s and, as
// the volume's own planes are, in z.
class Projections {
 public:
  Projections(const std::vector<SmoothBall>& balls, int n, int angles, double z_step)
      : n_(n), angles_(angles), z_step_(z_step),
        planes_(static_cast<int>(std::lround((n - 1) / z_step)) + 1 + 2 * outside),
        values_(static_cast<size_t>(angles) * planes_ * width()) {
    for (int a = 0; a < angles; ++a)
      for (int k = 0; k < planes_; ++k) filter(balls, a, k);
  }

  // Adds up the filtered projections at a point whose z is that of a plane.
  [[nodiscard]] double back_projected(double x, double y, double z) const {
    const int k = static_cast<int>(std::lround(z / z_step_)) + outside;
    if (k < 0 || k >= planes_ || std::fabs((k - outside) * z_step_ - z) > 1e-6)
      fail(Code::internal, "phantom: no projections at z = ", z);
    double sum = 0;
    for (int a = 0; a < angles_; ++a) {
      const double s = (x - centre()) * cosine(a) + (y - centre()) * sine(a) + middle();
      const auto i = static_cast<int>(std::floor(s));
      const float* const row = values_.data() + (static_cast<size_t>(a) * planes_ + k) * width();
      sum += row[i] + (s - i) * (row[i + 1] - row[i]);
    }
    return sum * std::numbers::pi / angles_;
  }

 private:
  static constexpr int outside = 8; // planes beyond either end, which lattices with margins ask for
  static constexpr int finer = 4;   // samples of the detector per T, so that lines between them are true
  [[nodiscard]] double centre() const { return (n_ - 1) / 2.0; }
  [[nodiscard]] int width() const { return finer * (2 * n_) + 2; }
  [[nodiscard]] double middle() const { return finer * n_; }
  [[nodiscard]] double cosine(int a) const { return finer * std::cos(std::numbers::pi * a / angles_); }
  [[nodiscard]] double sine(int a) const { return finer * std::sin(std::numbers::pi * a / angles_); }

  // The projection of a ball is a Gaussian in s; the ramp filter is applied to its samples 1 T apart.
  void filter(const std::vector<SmoothBall>& balls, int a, int k) {
    const int count = width(), reach = 2 * n_; // T, of the filter
    std::vector<double> raw(static_cast<size_t>(count) + 2 * finer * reach);
    const double c = std::cos(std::numbers::pi * a / angles_), sn = std::sin(std::numbers::pi * a / angles_),
                 z = (k - outside) * z_step_;
    for (size_t i = 0; i < raw.size(); ++i) {
      const double s = (static_cast<double>(i) - middle()) / finer - reach;
      double sum = 0;
      for (const SmoothBall& b : balls) {
        const double ds = s - ((b.at[0] - centre()) * c + (b.at[1] - centre()) * sn), dz = z - b.at[2],
                     r2 = ds * ds + dz * dz;
        if (r2 < 50 * b.sigma * b.sigma)
          sum +=
              b.height * b.sigma * std::sqrt(2 * std::numbers::pi) * std::exp(-r2 / (2 * b.sigma * b.sigma));
      }
      raw[i] = sum;
    }
    float* const out = values_.data() + (static_cast<size_t>(a) * planes_ + k) * count;
    for (int i = 0; i < count; ++i) {
      const double* const at = raw.data() + i + finer * reach;
      double sum = at[0] / 4;
      for (int m = 1; m <= reach; m += 2)
        sum -= (at[finer * m] + at[-finer * m]) / (std::numbers::pi * std::numbers::pi * m * m);
      out[i] = static_cast<float>(sum);
    }
  }

  int n_, angles_;
  double z_step_;
  int planes_;
  std::vector<float> values_;
};

// A host's field for bccsplat_writer_add_field: called for every site, whatever its lattice.
int32_t back_project(void* user, uint64_t count, const double* xyzt, float* values) {
  const auto& projections = *static_cast<const Projections*>(user);
  for (uint64_t i = 0; i < count; ++i)
    values[i] = static_cast<float>(projections.back_projected(xyzt[4 * i], xyzt[4 * i + 1], xyzt[4 * i + 2]));
  return 0;
}

// A volume in a file of its own, that goes with it.
class Reconstruction {
 public:
  Reconstruction(bccsplat_device* device, int n, bccsplat_lattice lattice, const char* name)
      : device_(device), n_(n), path_((std::filesystem::temp_directory_path() /
                                       concat("bccsplat-phantom-", ::getpid(), name, ".bcc4"))
                                          .string()) {
    auto options = sized<bccsplat_writer_options>();
    for (int a = 0; a < 3; ++a) options.dims[a] = static_cast<uint64_t>(n);
    options.dims[3] = 1, options.lattice = lattice, options.overwrite = 1;
    bccsplat_writer* w = nullptr;
    api(bccsplat_writer_create(device, path_.c_str(), &options, &w));
    writer_ = Handle<bccsplat_writer>(w);
  }
  ~Reconstruction() { std::filesystem::remove(path_); }
  Reconstruction(const Reconstruction&) = delete;
  Reconstruction& operator=(const Reconstruction&) = delete;

  void project(Projections& projections) {
    api(bccsplat_writer_add_field(writer_.get(), 0, back_project, &projections));
    finish();
  }
  void resample(const std::vector<float>& samples) {
    auto box = sized<bccsplat_box>();
    box.type = BCCSPLAT_TYPE_F32, box.data = samples.data();
    for (int a = 0; a < 3; ++a) box.dims[a] = static_cast<uint64_t>(n_);
    api(bccsplat_writer_add_frame(writer_.get(), 0, 0, &box, 1));
    finish();
  }
  [[nodiscard]] double samples() const { return static_cast<double>(report_.sites_total); }

  [[nodiscard]] std::vector<float> values(const std::vector<std::array<double, 4>>& points,
                                          const char* kernel) const {
    auto options = sized<bccsplat_volume_options>();
    options.kernel = kernel;
    bccsplat_volume* v = nullptr;
    api(bccsplat_volume_open_file(device_, path_.c_str(), &options, &v));
    const Handle<bccsplat_volume> volume(v);
    std::vector<float> out(points.size());
    api(bccsplat_volume_evaluate(v, points.size(), points[0].data(), out.data(), nullptr));
    return out;
  }

 private:
  void finish() {
    report_ = sized<bccsplat_writer_report>();
    api(bccsplat_writer_finish(writer_.get(), &report_));
  }
  bccsplat_device* device_;
  int n_;
  std::string path_;
  Handle<bccsplat_writer> writer_;
  bccsplat_writer_report report_{};
};

// dB, peak: the largest density.
double psnr(const Reconstruction& volume, const char* kernel, const std::vector<SmoothBall>& balls,
            double n) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> place(0.15 * n, 0.85 * n);
  std::vector<std::array<double, 4>> points(20000);
  for (auto& p : points) p = {place(random), place(random), place(random), 0};
  const std::vector<float> values = volume.values(points, kernel);
  double error = 0, peak = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const double truth = density(balls, {points[i][0], points[i][1], points[i][2]});
    error += std::pow(values[i] - truth, 2), peak = std::max(peak, truth);
  }
  return 10 * std::log10(peak * peak * static_cast<double>(points.size()) / error);
}

} // namespace

void report_phantom(const Report& report) {
  const int n = report.quick ? 20 : 64, angles = report.quick ? 24 : 128;
  const auto edge = static_cast<uint32_t>(n);
  const std::vector<SmoothBall> balls = phantom(n);
  Projections at_samples(balls, n, angles, 1),
      at_planes(balls, n, angles, Lattice4::fit(LatticeKind::bcc, {edge, edge, edge, 1}).space_step[2]);
  const auto device = make_api_device(1);
  Reconstruction on_cc(device.get(), n, BCCSPLAT_LATTICE_CC, "-cc"),
      on_bcc(device.get(), n, BCCSPLAT_LATTICE_BCC, "-bcc"),
      resampled(device.get(), n, BCCSPLAT_LATTICE_BCC, "-resampled");
  const double cc_s = cpu_seconds([&] { on_cc.project(at_samples); }),
               bcc_s = cpu_seconds([&] { on_bcc.project(at_planes); });
  std::vector<float> samples;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) samples.push_back(static_cast<float>(at_samples.back_projected(x, y, z)));
  const double fit_s = cpu_seconds([&] { resampled.resample(samples); });
  std::vector<Row> rows;
  const auto add = [&](const char* way, const Reconstruction& volume, double seconds) {
    rows.push_back({word("reconstructed", way), figure("samples", volume.samples(), 0),
                    figure("s", seconds, 2), figure("time %", 100 * seconds / cc_s, 1),
                    figure("PSNR dB, default kernel", psnr(volume, "default", balls, n), 1)});
  };
  add("at the samples of CC", on_cc, cc_s);
  add("at the sites of BCC", on_bcc, bcc_s);
  add("on CC, then resampled to BCC", resampled, cc_s + fit_s);
  report.table(concat("A phantom of ", n, "^3 from ", angles, " projections, back-projected by one thread"),
               rows);
}

} // namespace bccsplat::bench
