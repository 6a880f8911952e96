// SPDX-License-Identifier: Apache-2.0
// Faults lie where two features meet. Every pair of choices that may go together is in one of few cases, each
// of which is a file and a picture, compared with slow truths (pairs/field_truth.h, pairs/picture_truth.h);
// every pair that may not ends in its sentence. BCCSPLAT_LONG=1: triples.
#include <cstdlib>

#include "pairs/picture_truth.h"
#include "pairs/tables.h"
#include "pairs/written.h"

namespace host::pairs {
namespace {

void nothing(Asked&) {}

const std::vector<Option> options{
    // The series.
    {"frames",
     {{"8", nothing},
      {"1", [](Asked& a) { a.dims[3] = 1; }},
      {"unknown", [](Asked& a) { a.unknown_length = true; }}}},
    {"data",
     {{"blob", nothing},
      {"far", [](Asked& a) { a.data = Data::far_from_air; }},
      {"labels", [](Asked& a) { a.data = Data::labels; }}}},
    {"type",
     {{"f32", nothing},
      {"u8", [](Asked& a) { a.type = BCCSPLAT_TYPE_U8; }},
      {"i16", [](Asked& a) { a.type = BCCSPLAT_TYPE_I16; }}}},
    {"missing",
     {{"none", nothing},
      {"hole", [](Asked& a) { a.missing = true, a.file.nonfinite = BCCSPLAT_NONFINITE_HOLE; }},
      {"clamp",
       [](Asked& a) {
         a.missing = true, a.file.nonfinite = BCCSPLAT_NONFINITE_CLAMP;
         a.channel.set_mask |= BCCSPLAT_CHANNEL_SET_RANGE;
       }}}},
    {"thin", {{"no", nothing}, {"z", [](Asked& a) { a.dims[2] = 1; }}}},
    {"axes", {{"even", nothing}, {"uneven", [](Asked& a) { a.uneven = true; }}}},
    {"affine",
     {{"none", nothing},
      {"mirrored",
       [](Asked& a) {
         const double m[16] = {-2, 0, 0, 5, 0, 1.5, .2, 0, 0, 0, 2, -3, 0, 0, 0, 1};
         std::copy(m, m + 16, a.file.affine);
       }}}},
    // The file.
    {"store",
     {{"samples", [](Asked& a) { a.file.store = BCCSPLAT_STORE_SAMPLES; }},
      {"wavelets",
       [](Asked& a) {
         a.file.store = BCCSPLAT_STORE_WAVELETS;
         a.channel.value_type = BCCSPLAT_TYPE_U16, a.channel.set_mask |= BCCSPLAT_CHANNEL_SET_RANGE;
       }}}},
    {"lattice", {{"own", nothing}, {"cc", [](Asked& a) { a.file.lattice = BCCSPLAT_LATTICE_CC; }}}},
    {"scale", {{"1", nothing}, {"1.2", [](Asked& a) { a.file.scale = 1.2; }}}},
    {"levels", {{"0", nothing}, {"1", [](Asked& a) { a.file.levels = 1; }}}},
    {"kept",
     {{"own", nothing},
      {"f16", [](Asked& a) { a.channel.value_type = BCCSPLAT_TYPE_F16; }},
      {"u8",
       [](Asked& a) {
         a.channel.value_type = BCCSPLAT_TYPE_U8, a.channel.set_mask |= BCCSPLAT_CHANNEL_SET_RANGE;
         a.usual_error = .2; // of wavelets, whose error is larger than what steps of bytes round by
       }}}},
    {"bound",
     {{"none", nothing},
      {"abs", [](Asked& a) { a.file.abs_error = .4; }},
      {"psnr", [](Asked& a) { a.file.psnr = 30, a.channels = 1; }}}},
    {"measure", {{"none", nothing}, {"all", [](Asked& a) { a.file.measure = BCCSPLAT_MEASURE_ALL; }}}},
    {"ends",
     {{"own", nothing},
      {"predict", [](Asked& a) { a.file.ends = BCCSPLAT_ENDS_PREDICT; }},
      {"periodic", [](Asked& a) { a.file.ends = BCCSPLAT_ENDS_PERIODIC; }}}},
    {"faces",
     {{"own", nothing},
      {"predict", [](Asked& a) { a.file.faces = BCCSPLAT_FACES_PREDICT_X; }},
      {"periodic", [](Asked& a) { a.file.periodic_axes = BCCSPLAT_PERIODIC_Y; }}}},
    {"lowpass", {{"no", nothing}, {"yes", [](Asked& a) { a.file.lowpass = 1; }}}},
    {"predictions", {{"chosen", nothing}, {"fixed", [](Asked& a) { a.file.fixed_predictions = 1; }}}},
    {"channels", {{"2", nothing}, {"1", [](Asked& a) { a.channels = 1; }}}},
    {"written",
     {{"whole", nothing},
      {"parts", [](Asked& a) { a.way = Way::parts; }},
      {"blocks", [](Asked& a) { a.way = Way::blocks, a.file.fixed_predictions = 1; }},
      {"appended", [](Asked& a) { a.way = Way::appended; }},
      {"resumed", [](Asked& a) { a.way = Way::resumed; }},
      {"live", [](Asked& a) { a.way = Way::live; }},
      {"layers", [](Asked& a) { a.way = Way::layers; }},
      {"field", [](Asked& a) { a.way = Way::field; }}}},
    // The slice.
    {"kernel", {{"own", nothing}, {"fine", [](Asked& a) { a.slice.kernel = "fine"; }}}},
    {"cut",
     {{"time", nothing},
      {"mean", [](Asked& a) { a.cut = Cut::mean; }},
      {"box", [](Asked& a) { a.cut = Cut::box; }},
      {"oblique", [](Asked& a) { a.cut = Cut::oblique; }},
      {"axis", [](Asked& a) { a.cut = Cut::axis; }}}},
    {"level", {{"0", nothing}, {"1", [](Asked& a) { a.slice.level = 1, a.file.levels = 1; }}}},
    {"bricks", {{"no", nothing}, {"yes", [](Asked& a) { a.bricks = true; }}}},
    // The picture.
    {"mode",
     {{"composite", nothing},
      {"isosurface", [](Asked& a) { a.render.mode = BCCSPLAT_MODE_ISOSURFACE; }},
      {"surfaces",
       [](Asked& a) {
         a.render.mode = BCCSPLAT_MODE_ISOSURFACE;
         a.surfaces = {{.3, .4, {1, .5, 0}, 1, 0}, {.6, .8, {0, 0, 0}, 0, 0}};
       }},
      {"xray", [](Asked& a) { a.render.mode = BCCSPLAT_MODE_XRAY, a.render.shading = BCCSPLAT_SHADING_OFF; }},
      {"maximum", [](Asked& a) { a.render.mode = BCCSPLAT_MODE_MAXIMUM; }}}},
    {"drawn by",
     {{"renderer", nothing},
      {"scene", [](Asked& a) { a.drawn = Drawn::scene; }},
      {"budget", [](Asked& a) { a.drawn = Drawn::budget; }},
      {"two", [](Asked& a) { a.drawn = Drawn::two; }},
      {"mask", [](Asked& a) { a.drawn = Drawn::masked; }},
      {"paint", [](Asked& a) { a.drawn = Drawn::painted; }}}},
    {"view", {{"orthographic", nothing}, {"perspective", [](Asked& a) { a.perspective = true; }}}},
    {"clip", {{"none", nothing}, {"half", [](Asked& a) { a.clipped = true; }}}},
    {"things", {{"none", nothing}, {"wall", [](Asked& a) { a.behind_things = true; }}}},
    {"frame",
     {{"colours", nothing},
      {"planes",
       [](Asked& a) { a.planes = BCCSPLAT_FRAME_DEPTH | BCCSPLAT_FRAME_VALUE | BCCSPLAT_FRAME_TIME; }},
      {"deep", [](Asked& a) { a.planes = BCCSPLAT_FRAME_DEEP; }}}},
    {"parts", {{"one", nothing}, {"two", [](Asked& a) { a.in_parts = true; }}}},
    {"trail",
     {{"none", nothing},
      {"stills", [](Asked& a) { a.has_trail = true, a.trail.interval[0] = -2, a.trail.samples = 5; }},
      {"mean",
       [](Asked& a) {
         a.has_trail = true, a.trail.interval[0] = -1, a.trail.interval[1] = 1;
         a.trail.content = BCCSPLAT_TRAIL_MEAN;
       }}}},
    {"backend", {{"cpu", nothing}, {"gpu", [](Asked& a) { a.render.backend = BCCSPLAT_BACKEND_GPU; }}}},
    {"light", {{"one", nothing}, {"shadow", [](Asked& a) { a.lights.shadow = 1, a.lights.occlusion = 1; }}}},
};

const std::vector<Refused> refused{
    {{"frames=1|unknown", "ends=periodic"}, BCCSPLAT_ERROR_INVALID_ARGUMENT, "at least 2, as a whole number"},
    {{"frames=1", "cut=oblique|axis"}, BCCSPLAT_ERROR_UNSUPPORTED, "a static volume has no hyperplanes"},
    {{"frames=unknown", "store"}, BCCSPLAT_ERROR_INVALID_ARGUMENT, "need the number of frames in dims[3]"},
    {{"frames=unknown", "bound"}, BCCSPLAT_ERROR_INVALID_ARGUMENT, "need the number of frames in dims[3]"},
    {{"frames=unknown", "measure"}, BCCSPLAT_ERROR_INVALID_ARGUMENT, "need the number of frames in dims[3]"},
    {{"frames=unknown", "written=parts|blocks"}, BCCSPLAT_ERROR_INVALID_ARGUMENT, "a part needs the number"},
    {{"frames=unknown", "written=layers|field"}, BCCSPLAT_ERROR_WRONG_STATE, "need the number of frames"},
    {{"store=wavelets", "kept=f16"}, BCCSPLAT_ERROR_INVALID_ARGUMENT, "wavelets are of samples stored as U8"},
    {{"store=wavelets", "written=blocks"},
     BCCSPLAT_ERROR_UNSUPPORTED,
     "the steps of wavelets follow from all"},
    {{"lattice=cc", "lowpass"}, BCCSPLAT_ERROR_INVALID_ARGUMENT, "a low-pass is of use on D4* and BCC only"},
    {{"lattice=cc", "kernel=fine"},
     BCCSPLAT_ERROR_UNSUPPORTED,
     "on a Cartesian lattice take one that reaches no"},
    {{"axes=uneven", "faces=periodic"}, BCCSPLAT_ERROR_UNSUPPORTED, "a periodic axis takes none"},
    {{"levels", "written=layers|field"}, BCCSPLAT_ERROR_UNSUPPORTED, "coarser levels are made of frames"},
    {{"level", "written=layers|field"}, BCCSPLAT_ERROR_UNSUPPORTED, "coarser levels are made of frames"},
    {{"bound", "written=layers"}, BCCSPLAT_ERROR_WRONG_STATE, "source samples"},
    {{"measure", "written=layers"}, BCCSPLAT_ERROR_WRONG_STATE, "source samples"},
    {{"ends=periodic", "written=parts|blocks"}, BCCSPLAT_ERROR_UNSUPPORTED, "is not written in parts"},
    {{"ends=periodic", "written=appended"}, BCCSPLAT_ERROR_UNSUPPORTED, "so that none goes on"},
    {{"ends=periodic", "written=live"}, BCCSPLAT_ERROR_UNSUPPORTED, "is not looked at while it is written"},
    {{"faces=periodic", "written=blocks"}, BCCSPLAT_ERROR_UNSUPPORTED, "the last sample of a periodic axis"},
    {{"lowpass", "written=blocks"}, BCCSPLAT_ERROR_UNSUPPORTED, "lowpass holds whole frames"},
    {{"mode=xray|maximum", "frame=deep"}, BCCSPLAT_ERROR_UNSUPPORTED, "deep pictures are of modes composite"},
    {{"mode=xray|maximum", "trail"}, BCCSPLAT_ERROR_UNSUPPORTED, "a trail goes with modes composite"},
    {{"mode=surfaces", "trail"}, BCCSPLAT_ERROR_UNSUPPORTED, "a trail goes with isosurfaces that are opaque"},
    {{"mode=xray|maximum", "drawn by=paint"},
     BCCSPLAT_ERROR_UNSUPPORTED,
     "colours by another channel go with"},
    {{"axes=uneven", "drawn by=mask"}, BCCSPLAT_ERROR_UNSUPPORTED, "uneven"},
    {{"drawn by=budget", "frame=deep"}, BCCSPLAT_ERROR_UNSUPPORTED, "a deep picture has no budget"},
    {{"drawn by=two", "frame=planes"}, BCCSPLAT_ERROR_UNSUPPORTED, "values and times of several instances"},
    {{"drawn by=paint", "trail"}, BCCSPLAT_ERROR_UNSUPPORTED, "a trail has no colours by another channel"},
    {{"drawn by=mask", "trail"}, BCCSPLAT_ERROR_UNSUPPORTED, "leave mask_channel out"},
    {{"trail", "light"}, BCCSPLAT_ERROR_UNSUPPORTED, "shadow and ambient occlusion are not drawn"},
    {{"backend=gpu", "frame=deep"}, BCCSPLAT_ERROR_UNSUPPORTED, "the GPU does not draw"},
    {{"backend=gpu", "light"}, BCCSPLAT_ERROR_UNSUPPORTED, "the GPU does not draw"},
    {{"backend=gpu", "drawn by=paint"}, BCCSPLAT_ERROR_UNSUPPORTED, "the GPU does not draw"},
    {{"backend=gpu", "missing=hole", "trail"},
     BCCSPLAT_ERROR_UNSUPPORTED,
     "with corrections or missing data"},
    {{"backend=gpu", "bound=abs", "trail"}, BCCSPLAT_ERROR_UNSUPPORTED, "with corrections or missing data"},
    {{"backend=gpu", "missing=hole", "axes"}, BCCSPLAT_ERROR_UNSUPPORTED, "missing data along uneven axes"},
    {{"backend=gpu", "missing=hole", "cut=oblique"}, BCCSPLAT_ERROR_UNSUPPORTED, "in an oblique slice"},
    {{"backend=gpu", "missing=hole", "drawn by=two"}, BCCSPLAT_ERROR_UNSUPPORTED, "the GPU does not draw"},
    {{"backend=gpu", "bound=abs", "drawn by=two"}, BCCSPLAT_ERROR_UNSUPPORTED, "the GPU does not draw"},
    {{"backend=gpu", "trail", "drawn by=two"}, BCCSPLAT_ERROR_UNSUPPORTED, "trails among several"},
    {{"backend=gpu", "mode=isosurface|surfaces", "drawn by=two"}, BCCSPLAT_ERROR_UNSUPPORTED, "in this mode"},
    {{"mode=xray|maximum", "drawn by=two"},
     BCCSPLAT_ERROR_UNSUPPORTED,
     "several instances are drawn in modes"},
    {{"drawn by=two", "frame=deep", "mode=isosurface|surfaces"},
     BCCSPLAT_ERROR_UNSUPPORTED,
     "is of mode composite"},
    {{"data=far", "missing=clamp", "store=wavelets", "kept=u8"},
     BCCSPLAT_ERROR_BOUND_NOT_MET,
     "1.7 asked for"},
    {{"store=wavelets", "lattice=cc", "kept=u8", "bound=abs", "faces=predict"},
     BCCSPLAT_ERROR_BOUND_NOT_MET,
     "made of rounded samples"},
    {{"axes=uneven", "cut=oblique", "trail=mean"},
     BCCSPLAT_ERROR_UNSUPPORTED,
     "an oblique slice has no thickness"},
};

// Pairs that say nothing, or of which one takes the place of the other.
const std::vector<Together> no_sense{
    {"type=u8|i16", "missing"},                      // there are no such numbers
    {"type=u8", "data=far"},                         // nor these
    {"frames=1", "written=appended"},                // of nothing
    {"channels=1", "drawn by=mask|paint"},           // by the other channel
    {"bound=psnr", "drawn by=mask|paint"},           // is of one channel here
    {"bound=psnr", "data=labels"},                   // which jump, so that no lattice holds them well
    {"bound=psnr", "missing=clamp"},                 // likewise
    {"cut", "drawn by=scene|budget|two|mask|paint"}, // a scene cuts its slices itself
    {"level", "drawn by=scene|budget|two|mask|paint"},
    {"drawn by=two", "light"}, // volumes throw no shadow on each other
};

// Faults that are not mended yet. Each has to fail: where it does not, its row goes.
const char* const base_of_blocks =
    "errors are measured about air, as of blocks, where readers of the file take the median for its base";
const std::vector<Known> known{
    {{"data=far", "predictions=fixed", "measure"}, "the writer measured", base_of_blocks},
    {{"data=far", "predictions=fixed", "bound=psnr"}, "the writer measured", base_of_blocks},
    {{"data=far", "written=blocks", "measure"}, "the writer measured", base_of_blocks},
    {{"data=far", "written=blocks", "bound=psnr"}, "the writer measured", base_of_blocks},
    {{"missing=hole", "bound=psnr", "ends=periodic", "written=field"},
     "the writer compared",
     "a few samples at holes are compared by readers alone"},
};

const Tables tables{options, refused, no_sense, known};

// ---- The tests ----

// Whether there is a GPU, or Mesa's rasteriser in its place.
bool has_gpu() {
  static const bool has = [] {
    auto info = sized<bccsplat_gpu_info>();
    if (bccsplat_device_get_gpu_info(make_device(1).get(), &info) == BCCSPLAT_OK) return true;
    std::fprintf(stderr, "NOT TESTED, no GPU: %s\n", bccsplat_last_error());
    return false;
  }();
  return has;
}

// What a case ends in; empty: it is as it should be.
std::string ends_in(const ChosenOf& chosen, bccsplat_status* status = nullptr) {
  static const Device device = make_device(1);
  const Folder folder;
  Asked asked = tables.asked(chosen);
  if (asked.render.backend == BCCSPLAT_BACKEND_GPU && !has_gpu()) asked.render.backend = BCCSPLAT_BACKEND_CPU;
  try {
    Writing writing(device, folder, asked);
    const std::string path = writing.write();
    FieldTruth field(device, asked, path, writing.errors());
    field.check_bytes();
    field.check_values();
    field.check_slice();
    PictureTruth(device, asked, field).check_picture();
  } catch (const Refusal& r) {
    if (status) *status = r.status;
    return std::string(bccsplat_status_name(r.status)) + ": " + r.text;
  } catch (const Wrong& w) {
    if (status) *status = BCCSPLAT_OK;
    return w.text;
  }
  return {};
}

TEST(Pairs, ThoseThatGoTogetherAreTrue) {
  const bool triples = std::getenv("BCCSPLAT_LONG") != nullptr;
  Covering covering(
      tables.counts(), [](auto... c) { return tables.excludes(c...); }, triples ? 3 : 2);
  const std::vector<ChosenOf> cases = covering.cases();
  for (const auto& tuple : covering.left())
    if (!triples) ADD_FAILURE() << "no case holds " << tables.names(tuple);
  std::printf("%zu cases\n", cases.size());
  for (const ChosenOf& one : cases) {
    const std::string wrong = ends_in(one);
    if (wrong.empty() || tables.may_end_in(one, wrong)) continue;
    const ChosenOf least = bccsplat::test::reduced(one, [](const ChosenOf& less) {
      const std::string text = tables.allowed(less) ? ends_in(less) : "";
      return !text.empty() && !tables.may_end_in(less, text);
    });
    ADD_FAILURE() << tables.names(least) << "\n  " << ends_in(least) << "\n  first seen with "
                  << tables.names(one) << ":\n  " << wrong;
  }
}

TEST(Pairs, ThoseThatDoNotEndInTheirSentence) {
  for (const Refused& row : refused)
    for (const ChosenOf& one : tables.cases_of(row.together)) {
      if (tables.asked(one).render.backend == BCCSPLAT_BACKEND_GPU && !has_gpu()) continue;
      bccsplat_status status = BCCSPLAT_OK;
      const std::string text = ends_in(one, &status);
      EXPECT_EQ(status, row.status) << tables.names(one) << ": " << text;
      EXPECT_NE(text.find(row.text), std::string::npos) << tables.names(one) << ": " << text;
    }
}

TEST(Pairs, KnownFaultsAreStillThere) {
  for (const Known& row : known)
    for (const ChosenOf& one : tables.cases_of(row.together))
      EXPECT_NE(ends_in(one).find(row.text), std::string::npos)
          << tables.names(one) << " is mended: remove the row \"" << row.fault << '"';
}

} // namespace
} // namespace host::pairs
