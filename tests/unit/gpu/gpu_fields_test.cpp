// SPDX-License-Identifier: Apache-2.0
// What a field has beside coefficients on BCC, by the GPU's two entries: Cartesian lattices, corrections,
// missing samples and sites; against the CPU, 45 dB at least.
#include "tests/unit/gpu/both_pictures.h"

#include "field/masks.h"
#include "field/slice_mask.h"
#include "gpu/field_bricks.h"

namespace bccsplat {
namespace {

using namespace test;

class GpuFields : public BothPictures {};

Slice corrected_slice(CorrectionShape shape, float size, LatticeKind kind = LatticeKind::bcc) {
  Slice s = make_slice({40, 36, 33}, ball(), "default", {}, 0, kind);
  s.corrections = make_corrections(shape, size, {40, 36, 33});
  s.bounds[0] -= size, s.bounds[1] += size;
  return s;
}

TEST_P(GpuFields, CartesianLattices) {
  for (const char* kernel : {"default", "fast", "exact", "paper"})
    for (const bool perspective : {false, true}) {
      const Slice s = make_slice({60, 48, 40}, smoke(), kernel, {}, 0, LatticeKind::cc);
      ASSERT_FALSE(s.lattice.bcc);
      const Scene scene =
          make_scene(s, ramp_function(0.1, 1, 0.3), fit_camera(s, perspective, 25, 40, pixels, pixels));
      RenderOptions o;
      o.shading = false;
      EXPECT_GT(differ(scene, o).db(), 80) << kernel;
      o.shading = true, o.without_ripple = perspective;
      EXPECT_GT(differ(scene, o).db(), 35) << kernel; // whose gradients by differences are coarse
    }
}

// Lit by the field's own gradients, of the kernel that divides by its sum, too.
TEST_P(GpuFields, CartesianLatticesAreLit) {
  for (const char* kernel : {"exact", "paper"}) {
    const Slice s = make_slice({60, 48, 40}, smoke(), kernel, {}, 0, LatticeKind::cc);
    const Scene scene =
        make_scene(s, ramp_function(0.1, 1, 0.3), fit_camera(s, false, 25, 40, pixels / 2, pixels / 2));
    RenderOptions o;
    (void)differ(scene, o, pixels / 2, pixels / 2);
    ImageStorage truth(pixels / 2, pixels / 2);
    o.reference = true;
    (void)draw(scene, o, truth);
    EXPECT_GT(compare(*gpu, truth).db(), least_db) << kernel;
  }
}

TEST_P(GpuFields, CartesianLatticesInEveryMode) {
  const Slice s = make_slice({41, 41, 41}, marschner_lobb(41, 4), "exact", {}, 0, LatticeKind::cc);
  for (const bool perspective : {false, true}) {
    const Scene scene =
        make_scene(s, ramp_function(0.1, 1, 0.3), fit_camera(s, perspective, 25, 40, pixels, pixels));
    RenderOptions o;
    o.mode = RenderMode::isosurface, o.iso_value = 0.5;
    (void)differ(scene, o);
    EXPECT_GT(db_but_grazes(*cpu, *gpu), least_db) << perspective;
    o.mode = RenderMode::maximum;
    EXPECT_GT(differ(scene, o).db(), least_db) << perspective;
    o.mode = RenderMode::xray;
    EXPECT_GT(differ(scene, o).db(), least_db - 20) << perspective; // of values up to 40
  }
}

// Skipping what is not seen leaves nothing out, the ripple of kernels on a Cartesian lattice included.
TEST_P(GpuFields, CartesianCellsBoundTheField) {
  TestContext context(2);
  for (const char* kernel : {"exact", "fast", "default"}) {
    const Slice s = make_slice(
        {30, 28, 26}, [](double x, double, double) { return x < 15 ? 0.5 : 1; }, kernel, {}, 0,
        LatticeKind::cc);
    const FieldBricks b = make_field_bricks(s, 2, context.get());
    for (int n = 0; n < 4000; ++n) {
      Vec3 p;
      std::array<size_t, 3> cell;
      for (size_t a = 0; a < 3; ++a) {
        p[a] = s.domain_end[a] * (std::rand() / (RAND_MAX + 1.0));
        cell[a] = static_cast<size_t>(std::floor(p[a] + 0.5) - b.first_site[a]) / 2;
      }
      const auto& [low, high] = b.range[(cell[2] * b.cells[1] + cell[1]) * b.cells[0] + cell[0]];
      const double value = evaluate_reference(s, p, nullptr) - s.base;
      ASSERT_TRUE(value >= low - 1e-6 && value <= high + 1e-6)
          << kernel << ' ' << value << ' ' << low << ' ' << high;
    }
  }
}

TEST_P(GpuFields, Corrections) {
  for (const CorrectionShape shape : {CorrectionShape::tent, CorrectionShape::smooth})
    for (const LatticeKind kind : {LatticeKind::bcc, LatticeKind::cc}) {
      const Slice s = corrected_slice(shape, 0.25f, kind);
      Slice without = s;
      without.corrections = nullptr;
      const Scene scene = make_scene(s, ramp_function(0.1, 1, 0.3),
                                     fit_camera(s, kind == LatticeKind::cc, 25, 40, pixels, pixels));
      Scene bare = scene;
      bare.slice = &without;
      RenderOptions o;
      o.shading = false;
      EXPECT_GT(differ(scene, o).db(), least_db) << static_cast<int>(shape);
      const std::unique_ptr<ImageStorage> corrected = std::move(gpu);
      (void)differ(bare, o);
      EXPECT_LT(compare(*corrected, *gpu).db(), least_db); // so that they are seen
      o.mode = RenderMode::isosurface, o.iso_value = 0.5;
      (void)differ(scene, o);
      EXPECT_GT(db_but_grazes(*cpu, *gpu), least_db) << static_cast<int>(shape);
      o.mode = RenderMode::maximum;
      EXPECT_GT(differ(scene, o).db(), least_db) << static_cast<int>(shape);
    }
}

// Shaded corrections against the truth: their gradients are the field's own.
TEST_P(GpuFields, CorrectionsAreLit) {
  const Slice s = corrected_slice(CorrectionShape::smooth, 0.05f);
  const Scene scene = make_scene(s, ramp_function(0.1, 1, 0.3), fit_camera(s, false, 25, 40, pixels, pixels));
  RenderOptions o;
  o.quality = Quality::fine;
  (void)differ(scene, o);
  ImageStorage truth(pixels, pixels);
  o.reference = true;
  (void)draw(scene, o, truth);
  EXPECT_GT(compare(*gpu, truth).db(), 40);
  EXPECT_GT(compare(*gpu, truth).db(), compare(*cpu, truth).db());
}

// Where nothing but corrections is, cells are seen.
TEST_P(GpuFields, CorrectionsInAir) {
  Slice s = make_slice({60, 30, 30}, [](double x, double, double) { return x < 8 ? 1 : 0; });
  s.corrections = make_corrections(CorrectionShape::tent, 0.5f, {60, 30, 30});
  s.bounds = {s.bounds[0] - 0.5, s.bounds[1] + 0.5};
  const Scene scene = make_scene(s, ramp_function(0.1, 1, 0.6), fit_camera(s, true, 25, 40, pixels, pixels));
  RenderOptions o;
  o.shading = false;
  EXPECT_GT(differ(scene, o).db(), least_db);
  o.mode = RenderMode::xray;
  EXPECT_GT(differ(scene, o).db(), least_db);
}

// Sites that are holes, some at the ends of the lattice.
Slice slice_with_holes(LatticeKind kind) {
  Slice s = make_slice({40, 36, 33}, ball(), "default", {}, 0, kind);
  for (int c = 0; c < s.lattice.cosets(); ++c) {
    BrickLayer& layer = s.coset[static_cast<size_t>(c)];
    for (size_t n = 0; n < layer.brick_slots(); n += 2) {
      if (!layer.brick(n)) continue;
      auto brick = std::make_shared<Brick>();
      brick->value = layer.brick(n)->value, brick->kept = layer.brick(n)->kept;
      brick->hole = std::make_unique<BrickMask>();
      for (size_t row = 0; row < brick_rows; ++row)
        if (row / 3 % 2 == 0) (*brick->hole)[row] = 0x0f07;
      layer.set(n, std::move(brick));
    }
  }
  s.has_holes = true;
  return s;
}

class MissingData : public GpuFields {
 protected:
  void expect_alike(const Scene& scene) {
    RenderOptions o;
    o.shading = false;
    EXPECT_GT(db_but_edges(scene, o), least_db);
    for (const RenderMode mode : {RenderMode::xray, RenderMode::maximum}) {
      o.mode = mode;
      EXPECT_GT(db_but_edges(scene, o), least_db) << static_cast<int>(mode);
    }
    o.mode = RenderMode::isosurface, o.iso_value = 0.5;
    (void)differ(scene, o);
    EXPECT_GT(db_but_grazes(*cpu, *gpu), least_db);
  }
  // Samples half way between two places are on either side by rounding.
  double db_but_edges(const Scene& scene, const RenderOptions& o) {
    (void)differ(scene, o);
    return db_but_grazes(*cpu, *gpu);
  }
};

TEST_P(MissingData, Sites) {
  for (const LatticeKind kind : {LatticeKind::bcc, LatticeKind::cc}) {
    const Slice s = slice_with_holes(kind);
    expect_alike(make_scene(s, ramp_function(0.1, 1, 0.3),
                            fit_camera(s, kind == LatticeKind::cc, 25, 40, pixels, pixels)));
  }
}

// Boxes of a frame that are missing, the first sample's among them.
FrameMaskPtr make_frame(MemoryBudget& budget, const std::array<int64_t, 3>& n, int64_t part) {
  FrameMask mask(n, Reservation(budget, FrameMask::bytes_of(n), "a mask"), false);
  for (int64_t z = 0; z < n[2]; ++z)
    for (int64_t y = 0; y < n[1]; ++y)
      for (int64_t x = 0; x < n[0]; ++x)
        if (x / 7 % 2 == part && y / 5 % 2 == part && z / 6 % 2 == part) {
          const auto at = static_cast<uint64_t>((z * n[1] + y) * n[0] + x);
          mask.add(at, at + 1);
        }
  mask.count_blocks();
  return std::make_shared<const FrameMask>(std::move(mask));
}

void set_mask(Slice& s, const SliceMask& mask) {
  s.mask = std::make_shared<const SliceMask>(mask);
  s.has_holes = s.holes_by_mask = true;
}

constexpr std::array<Vec4, 3> in_space{Vec4{1, 0, 0, 0}, Vec4{0, 1, 0, 0}, Vec4{0, 0, 1, 0}};

TEST_P(MissingData, Samples) {
  MemoryBudget budget;
  const FrameMaskPtr frame = make_frame(budget, {40, 36, 33}, 0), other = make_frame(budget, {40, 36, 33}, 1);
  for (const bool turning : {false, true}) {
    Slice s = make_slice({40, 36, 33}, ball());
    // Along a periodic axis samples are counted on.
    const Vec4 origin{turning ? 30.0 : 0.0, 0, 0, 2};
    const SliceMask mask({40, 36, 33, 5}, {turning, false, false, false}, origin, in_space, 2, {frame});
    set_mask(s, mask);
    expect_alike(make_scene(s, ramp_function(0.1, 1, 0.3), fit_camera(s, turning, 25, 40, pixels, pixels)));
    // What two moments lack, and holes beside a mask.
    const auto second = std::make_shared<const SliceMask>(
        std::array<int64_t, 4>{40, 36, 33, 5}, TurningAxes{}, origin, in_space, 2, std::vector{other});
    set_mask(s, mask.also({second}));
    if (turning) {
      EXPECT_FALSE(s.mask->grid()); // one goes round, the other does not
      continue;
    }
    expect_alike(make_scene(s, ramp_function(0.1, 1, 0.3), fit_camera(s, true, 25, 40, pixels, pixels)));
    Slice both = slice_with_holes(LatticeKind::bcc);
    set_mask(both, mask);
    both.holes_by_mask = false;
    expect_alike(
        make_scene(both, ramp_function(0.1, 1, 0.3), fit_camera(both, true, 25, 40, pixels, pixels)));
  }
}

// Of a slice with time along one of its axes the masks of its frames decide.
TEST_P(MissingData, SamplesOverTime) {
  MemoryBudget budget;
  std::vector<FrameMaskPtr> frames;
  for (int f = 0; f < 33; ++f)
    frames.push_back(f % 3 == 2 ? nullptr : make_frame(budget, {10, 40, 36}, f / 9 % 2));
  Slice s = make_slice({40, 36, 33}, ball());
  const std::array<Vec4, 3> basis{Vec4{0, 1, 0, 0}, Vec4{0, 0, 1, 0}, Vec4{0, 0, 0, 1}};
  set_mask(s, SliceMask({10, 40, 36, 50}, {}, {3, 0, 0, 6}, basis, 6, std::move(frames)));
  ASSERT_TRUE(s.mask->grid());
  EXPECT_EQ(s.mask->grid()->samples, (Int3{40, 36, 33}));
  expect_alike(make_scene(s, ramp_function(0.1, 1, 0.3), fit_camera(s, true, 25, 40, pixels, pixels)));
}

TEST_P(MissingData, ObliqueMasksAreTheCpus) {
  MemoryBudget budget;
  Slice s = make_slice({40, 36, 33}, ball());
  const std::array<Vec4, 3> basis{Vec4{0.6, 0, 0, 0.8}, Vec4{0, 1, 0, 0}, Vec4{0, 0, 1, 0}};
  set_mask(s, SliceMask({40, 36, 33, 1}, {}, {}, basis, 0, {make_frame(budget, {40, 36, 33}, 0)}));
  const Scene scene = make_scene(s, ramp_function(0.1, 1, 0.3), fit_camera(s, true, 25, 40, pixels, pixels));
  RenderOptions o;
  o.backend = Backend::gpu, o.gpu = gpu_;
  ImageStorage image(pixels, pixels);
  try {
    (void)draw(scene, o, image);
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_NE(e.message().find("in an oblique slice"), std::string::npos) << e.message();
  }
}

INSTANTIATE_TEST_SUITE_P(Entries, GpuFields, testing::Values(GpuEntry::compute, GpuEntry::fragment),
                         entry_name);
INSTANTIATE_TEST_SUITE_P(Entries, MissingData, testing::Values(GpuEntry::compute, GpuEntry::fragment),
                         entry_name);

} // namespace
} // namespace bccsplat
