// SPDX-License-Identifier: Apache-2.0
// Adds the options of bcc4 import, by what they are about, and reads those whose text says more than one
// thing.
#include "tool/import/import_arguments.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "readers/open_series.h"
#include "tool/cli.h"
#include "tool/import/level_choice.h"
#include "tool/import/writer_choices.h"
#include "tool/output/output_file.h"

namespace bcc4 {
namespace {

// --scale S, X,Y,Z or X,Y,Z,T. What space is left with is the mean, for those who ask for one number.
void read_scale(const std::string& text, const std::string& time_scale, WriterSettings& settings) {
  if (text.empty()) return;
  const std::vector<double> scale = option_numbers("--scale", text, 0);
  for (const double s : scale)
    if (!(s > 0)) fail_usage("--scale must be positive");
  if (scale.size() == 1) {
    settings.scale = scale[0];
    return;
  }
  if (scale.size() != 3 && scale.size() != 4)
    fail_usage("--scale ", text, ": one number, or those along x,y,z or x,y,z,t");
  if (scale.size() == 4 && !time_scale.empty())
    fail_usage("--scale ", text, " has a distance along time, and so has --time-scale: choose one");
  std::copy(scale.begin(), scale.end(), settings.scales.begin());
  settings.scale = std::cbrt(scale[0] * scale[1] * scale[2]);
  if (scale.size() == 4) settings.time_scale = scale[3];
}

// --lattice and --density. A lattice by name has the distances that are given, or 1.
void read_lattice(const ImportArguments& a, WriterSettings& settings) {
  Choices<int32_t> choices{{"auto", BCCSPLAT_LATTICE_DEFAULT}};
  choices.insert(choices.end(), kLatticeChoices.begin(), kLatticeChoices.end());
  if (!a.lattice.empty()) settings.lattice = option_choice("--lattice", a.lattice, choices);
  if (!a.density) return;
  if (!(*a.density > 0 && *a.density <= 4)) fail_usage("--density ", *a.density, ": more than 0, at most 4");
  if (!a.scale.empty() || !a.time_scale.empty())
    fail_usage("--density chooses the distances that --scale and --time-scale give: one or the other");
}

// The lattice and its distances.
void add_lattice_options(Command import, ImportArguments& a) {
  import
      .add_option(
          "--lattice", a.lattice,
          "auto (default): of a series D4* or the Cartesian lattice, with the distances along x, y, z and t "
          "that lose least; d4star, bcc (one frame) or cc: this one, with the distances of --scale")
      .type_name("auto|d4star|bcc|cc");
  add_number(import, "--density", a.density,
             "Sites per source sample (default 0.5; bcc and cc as they have at distance 1)");
  import
      .add_option("--scale", a.scale,
                  "Lattice distance in source samples (default 1): of x, y and z, or one for each, and for t "
                  "in frames")
      .type_name("S|X,Y,Z|X,Y,Z,T");
  import
      .add_option(
          "--time-scale", a.time_scale,
          "The same along time, in frames (default 1); auto: as coarse as the measured spectrum allows")
      .type_name("X|auto");
}

// Adds the options that say which values are there, and how they become samples of the lattice.
void add_fit_options(Command import, ImportArguments& a) {
  add_number(import, "--air", a.air,
             "Value of empty space (default: the background of OpenVDB grids, else 0, and of floats that are "
             "hardly ever 0 about their mean, for constants near air ripple least)");
  add_number(import, "--air-threshold", a.air_threshold,
             "Samples within this of air are not stored (default 0: integers that equal air, and floats "
             "within 1/512 of what is near, the filter's ringing)");
  add_choice<int32_t>(import, "--on-nonfinite", a.settings.nonfinite, kNonfiniteChoices,
                      "NaN and infinities: stop, missing data, or air and the largest value");
  add_choice<int32_t>(import, "--filter", a.settings.filter, kFilterChoices,
                      "Resampling filter (default kaiser8)");
  import.add_flag("--lowpass", a.settings.lowpass,
                  "First remove the frequencies the lattice cannot hold (outside_cell of --dry-run)");
  add_choice<int32_t>(
      import, "--ends", a.settings.ends, kEndsChoices,
      "Before the first frame and after the last: as they predict, with two layers more at "
      "each end (default on D4* from 14 frames on, at distance 1), the mirror image, or periodic: "
      "the last frame leads to the first, as of heart beats and climatologies");
  add_choice<int32_t>(
      import, "--faces", a.settings.faces, kFacesChoices,
      "Beyond the first and last sample along x, y and z: as those inside predict, with two "
      "planes of the lattice more at each face, along all axes that are not short, or along these at "
      "any cost; or the mirror image (default: what does best on a sample, else as they predict along "
      "axes of 43 samples or more)");
  add_choice<int32_t>(import, "--periodic", a.settings.periodic, kPeriodicChoices,
                      "Axes that go round, as longitude does: behind the last sample comes the first one "
                      "again, and there are no faces (of time: --ends periodic)");
}

// Adds the options that say how near the file has to be, and how it stores samples.
void add_coding_options(Command import, ImportArguments& a) {
  import.add_flag(
      "--exact", a.exact,
      "Store samples as precisely as the source has its values (default: rounded where that adds next to "
      "nothing to the lattice's own error)");
  add_number(
      import, "--abs", a.abs,
      "No source sample is off by more than this: finds the coarsest coding, checks every frame, corrects "
      "what misses");
  add_number(import, "--psnr", a.psnr,
             "The same for a peak signal-to-noise ratio of the series in dB, such as 50");
  add_choice<int32_t>(import, "--measure", a.settings.measure, kMeasureChoices,
                      "Frames whose error against the source is reported (default some: three, evenly "
                      "spread; all with a bound)");
  add_choice<int32_t>(import, "--quantize", a.settings.quantize, kTypeChoices,
                      "Type of the stored values (default: the source's own precision)");
  add_choice<int32_t>(import, "--store", a.settings.store, kStoreChoices,
                      "Store samples, or coefficients of the kernel (default samples)");
  import
      .add_option("--levels", a.levels,
                  "Store coarser levels as well, each at twice the distance in space, for small pictures "
                  "(bcc4 render takes what is enough): so many, or auto (default): of frames of 192^3 and "
                  "more, but not of labels, until one is "
                  "below 96^3; --append keeps those of the file")
      .type_name("auto|none|N");
  import.add_option("--kernel", a.settings.kernel, "Kernel recommended to readers").type_name("NAME");
}

// Adds the options that say what is written, and how.
void add_output_options(Command import, ImportArguments& a) {
  add_threads(import, a.common);
  add_max_memory(import, a.common);
  import.add_flag("--dry-run", a.dry_run, "Only print how the input is read and what would come out");
  import
      .add_option(
          "--plan", a.plan,
          "With --dry-run: write what was decided to FILE. Else: import by that file, which also names "
          "the input")
      .type_name("FILE.json");
  import
      .add_option("--part", a.part,
                  "With --plan: only frames A-B, counted from 0, or the K-th of N parts; bcc4 concat joins "
                  "the parts to the file that one process writes, byte for byte")
      .type_name("A-B|K/N");
  import.add_flag("--overwrite", a.settings.overwrite, "Replace an existing output");
  add_resume_options(import, a.resume);
  import.add_flag("--json", a.common.json, "Report as JSON");
  import.add_flag("--quiet", a.common.quiet, "Print nothing but warnings and errors");
}

} // namespace

void add_import_options(Command import, ImportArguments& a) {
  import.add_option("INPUT", a.reader.options.inputs,
                    "Files, a pattern such as smoke.%04d.vdb or smoke.####.vdb, a glob, or @LIST");
  import.add_option("-o,--output,--out", a.output, "The .bcc4 file to write").type_name("OUT.bcc4");
  add_reader_options(import, a.reader);
  add_fit_options(import, a);
  add_lattice_options(import, a);
  add_coding_options(import, a);
  add_output_options(import, a);
}

void check_outputs(const ImportArguments& a) {
  if (!a.dry_run) {
    require_option(a.output, "-o", "-o out.bcc4");
    if (a.output == "-") fail_usage("-o -: a .bcc4 file is not written in one go and has to have a name");
    if (const std::string format = format_of_name(a.output); !format.empty())
      fail_usage("-o ", a.output, ": import writes .bcc4 files, and this is the name of a file of ", format,
                 "; export writes others");
    refuse_existing(a.output, a.settings.overwrite || a.resume.append);
    require_writable_folder(a.output);
    if (!a.part.empty() && a.plan.empty())
      fail_usage("--part needs the --plan that all parts share; --dry-run --plan FILE makes one");
  } else if (!a.part.empty()) {
    fail_usage("--part with --dry-run: a plan is made of the whole series");
  } else if (!a.plan.empty()) {
    refuse_existing(a.plan, a.settings.overwrite);
    require_writable_folder(a.plan);
  }
}

uint32_t read_levels(const ImportArguments& a, const SeriesDescription& series) {
  if (a.auto_levels()) return is_scattered(series) ? 0 : levels_for(series.dims);
  return a.levels == "none" ? 0 : option_number<uint32_t>("--levels", a.levels);
}

bool chooses_lattice(const ImportArguments& a) {
  if (a.density) return true;
  if (!a.scale.empty() || !a.time_scale.empty()) return false;
  return a.settings.lattice == BCCSPLAT_LATTICE_DEFAULT;
}

ErrorBound read_settings(ImportArguments& a) {
  a.settings.air = a.air;
  a.settings.air_threshold = a.air_threshold.value_or(0);
  read_scale(a.scale, a.time_scale, a.settings);
  read_lattice(a, a.settings);
  if (!a.time_scale.empty() && a.time_scale != "auto") {
    a.settings.time_scale = option_number<double>("--time-scale", a.time_scale);
    if (!(a.settings.time_scale > 0)) fail_usage("--time-scale must be positive, or auto");
  }
  const auto finite = [](const std::optional<double>& number, double most, const char* option) {
    if (number && !(std::fabs(*number) <= most)) fail_usage(option, " ", *number, ": must be finite");
  };
  finite(a.abs, std::numeric_limits<double>::max(), "--abs"), finite(a.psnr, 1e6, "--psnr");
  finite(a.air, std::numeric_limits<float>::max(), "--air");
  finite(a.air_threshold, std::numeric_limits<float>::max(), "--air-threshold");
  if (a.abs && a.psnr) fail_usage("--abs and --psnr: choose one");
  if (a.abs && !(*a.abs > 0))
    fail_usage(
        "--abs must be positive: the largest error allowed at any source sample, in units of the values");
  if (a.psnr && !(*a.psnr > 0)) fail_usage("--psnr must be positive, in dB: 50 is good, 70 is next to exact");
  if (!(a.settings.air_threshold >= 0)) fail_usage("--air-threshold must not be negative");
  return {a.abs.value_or(0), a.psnr.value_or(0)};
}

} // namespace bcc4
