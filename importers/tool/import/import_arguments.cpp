// SPDX-License-Identifier: Apache-2.0
// Adds the options of bcc4 import, by what they are about, and reads those whose text says more than one
// thing.
#include "tool/import/import_arguments.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "readers/open_series.h"
#include "tool/cli.h"
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
  std::copy(scale.begin(), scale.end(), settings.scales);
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

// Adds the options that an import needs first.
void add_common_options(const Command& import, ImportArguments& a) {
  add_number(import, "--psnr", a.psnr,
             "Least peak signal-to-noise ratio in dB, over all samples; checked on every frame (default: 50 "
             "outside air)");
  add_number(import, "--abs", a.abs,
             "Largest error allowed at any source sample. Checks every frame and corrects what misses "
             "(default: 2 % of the range)");
  add_number(import, "--air", a.air,
             "Value of empty space (default: the background of OpenVDB grids, else 0; floats that are hardly "
             "ever 0: their mean)");
  import.add_flag("--dry-run", a.dry_run,
                  "Print how the input is read and what would come out; write no .bcc4 file");
  import.add_flag("--overwrite", a.overwrite, "Replace an existing output");
  add_resume_options(import, a.resume);
  add_threads(import, a.common);
  add_max_memory(import, a.common);
  import.add_flag("--json", a.common.json, "Report as JSON");
  import.add_flag("--quiet", a.common.quiet, "Print nothing but warnings and errors");
}

// Adds the options that say which values are there, and what is assumed where none are.
void add_value_options(const Command& import, ImportArguments& a) {
  add_number(import, "--air-threshold", a.air_threshold,
             "Do not store samples within this of air (default 0: integers that equal air, and floats that "
             "differ by the ringing of the filter only)");
  add_choice<int32_t>(import, "--on-nonfinite", a.settings.nonfinite, kNonfiniteChoices,
                      "NaN and infinities: stop (error), mark as missing (hole), or replace by air and the "
                      "largest value (clamp)");
  add_choice<int32_t>(
      import, "--ends", a.settings.ends, kEndsChoices,
      "What is assumed before the first frame and after the last. predict: as the frames predict, with two "
      "more layers (default on D4* from 14 frames on); mirror: the mirror image; periodic: the last frame "
      "leads to the first, as in heart beats and climatologies");
  add_choice<int32_t>(
      import, "--faces", a.settings.faces, kFacesChoices,
      "What is assumed beyond the faces. predict: as the samples inside predict, along all axes that are not "
      "short; x to xyz: along these axes at any cost; mirror: the mirror image. Default: what does best on a "
      "sample, else predict along axes of 43 samples or more");
  add_choice<int32_t>(
      import, "--periodic", a.periodic, kPeriodicChoices,
      "Axes that go round, as longitude does: the first sample follows the last. For time: --ends periodic");
}

// Adds the options that say what is stored: as what, on which lattice, how precisely.
void add_store_options(const Command& import, ImportArguments& a) {
  add_choice<int32_t>(
      import, "--store", a.settings.store, kStoreChoices,
      "wavelets (default, unless options or the data ask for a lattice): the fewest bytes that keep "
      "--psnr or --abs; or samples of a lattice: a moment opens sooner");
  import
      .add_option(
          "--lattice", a.lattice,
          "Of samples. auto: the D4* or Cartesian lattice and the distances that lose least. Else this "
          "lattice, with the distances of --scale; bcc is for one frame")
      .type_name("auto|d4star|bcc|cc");
  add_number(import, "--density", a.density,
             "Lattice sites per source sample, such as 0.5, on the lattice that loses least");
  import
      .add_option("--scale", a.scale,
                  "Lattice distance in source samples (default 1): one number, or one for each axis; along t "
                  "in frames")
      .type_name("S|X,Y,Z|X,Y,Z,T");
  import
      .add_option("--time-scale", a.time_scale,
                  "Lattice distance along time, in frames (default 1). auto: as coarse as the measured "
                  "spectrum allows")
      .type_name("X|auto");
  import.add_flag("--lowpass", a.lowpass,
                  "First remove the frequencies that the lattice cannot hold (outside_cell of --dry-run)");
  import.add_flag("--exact", a.exact,
                  "Store samples of the lattice that loses least as precisely as the source (else they are "
                  "rounded where that adds next to "
                  "nothing to the error of the lattice)");
  add_choice<int32_t>(import, "--quantize", a.quantize, kTypeChoices,
                      "Type of the stored values (default: the source's own precision)");
  add_choice<int32_t>(
      import, "--measure", a.settings.measure, kMeasureChoices,
      "Frames whose error is measured and reported (default some: three; with --abs or --psnr: all)");
  import
      .add_option("--levels", a.levels,
                  "Number of coarser levels to store for small pictures, each at twice the distance in "
                  "space. auto (default): from 192^3 on, until a level is below 96^3; none for labels. "
                  "--append keeps those of the file")
      .type_name("auto|none|N");
  import.add_option("--kernel", a.kernel, "Kernel that readers use by default").type_name("NAME");
}

// Adds the options of imports that several processes do, or that others look at.
void add_part_options(const Command& import, ImportArguments& a) {
  import
      .add_option("--plan", a.plan,
                  "With --dry-run: write what was decided to this file. Without: import by this file, which "
                  "names the input, too")
      .type_name("FILE.json");
  import
      .add_option(
          "--part", a.part,
          "With --plan: import frames A-B, counted from 0, or the K-th of N parts (of a plan with --blocks: "
          "boxes of all frames); bcc4 concat joins them")
      .type_name("A-B|K/N");
  import
      .add_option("--block", a.block,
                  "With --plan, of a series planned with --blocks: import these samples of its frames, or of "
                  "those of --part; bcc4 concat joins all blocks. An axis may be left empty: ,,0:256")
      .type_name("X0:X1,Y0:Y1,Z0:Z1");
  import.add_flag(
      "--blocks", a.blocks,
      "Decide such that frames can be imported in blocks of space, and do so, one after the other, "
      "where whole ones do not fit --max-mem: nothing depends on more of a frame than what is near "
      "(samples, errors measured with --abs, --psnr or --measure all alone, predictions outside faces of one "
      "boldness). Frames beyond 400^3 samples that do not fit are "
      "imported so without it, too");
  add_live_option(import, a.resume);
}

} // namespace

void add_import_options(const Command& import, ImportArguments& a) {
  import.add_option(
      "INPUT", a.reader.options.inputs,
      "Files, a pattern such as smoke.%04d.vdb or smoke.####.vdb, a glob, or @LIST, a text file of names");
  import.add_option("-o,--output,--out", a.output, "The .bcc4 file to write").type_name("OUT.bcc4");
  add_common_options(import, a);
  add_reader_options(import, a.reader);
  add_value_options(import.under("Missing values, air, faces and ends", "values"), a);
  add_store_options(import.under("What is stored", "lattice"), a);
  add_part_options(import.under("Plans, parts, and files that grow", "parts"), a);
}

void check_outputs(const ImportArguments& a) {
  if (!a.dry_run) {
    require_option(a.output, "-o", "-o out.bcc4");
    if (a.output == "-") fail_usage("-o -: a .bcc4 file is not written in one go and has to have a name");
    if (const std::string format = format_of_name(a.output); !format.empty())
      fail_usage("-o ", a.output, ": import writes .bcc4 files, and this is the name of a file of ", format,
                 "; export writes others");
    refuse_existing(a.output, a.overwrite || a.resume.append);
    require_writable_folder(a.output);
    if (!a.block.empty() && a.plan.empty())
      fail_usage("--block needs the --plan that all blocks share; --blocks --dry-run --plan FILE makes one");
    if (!a.part.empty() && a.plan.empty())
      fail_usage("--part needs the --plan that all parts share; --dry-run --plan FILE makes one");
  } else if (!a.block.empty()) {
    fail_usage("--block with --dry-run: a plan is made of the whole series");
  } else if (!a.part.empty()) {
    fail_usage("--part with --dry-run: a plan is made of the whole series");
  } else if (!a.plan.empty()) {
    refuse_existing(a.plan, a.overwrite);
    require_writable_folder(a.plan);
  }
}

// Who says air says it of all channels, and a sparse source of each of its own.
std::vector<bccsplat_channel_options> read_channels(const ImportArguments& a, const SeriesDescription& s) {
  std::vector<bccsplat_channel_options> channels;
  for (const Channel& channel : s.channels) {
    auto& out = channels.emplace_back(sized<bccsplat_channel_options>());
    const bool wide = channel.scaled() && type_size(channel.precision) > 4; // read as floats
    out.source_type = wide ? BCCSPLAT_TYPE_F64 : library_type(channel.precision);
    out.value_type = a.quantize, out.air_threshold = a.air_threshold.value_or(0);
    out.air = a.air.value_or(channel.air);
    if (a.air || s.sparse) out.set_mask = BCCSPLAT_CHANNEL_SET_AIR;
  }
  return channels;
}

bool chooses_lattice(const ImportArguments& a) {
  if (a.density) return true;
  if (!a.scale.empty() || !a.time_scale.empty()) return false;
  return a.settings.lattice == BCCSPLAT_LATTICE_DEFAULT;
}

void read_settings(ImportArguments& a) {
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
  if (a.settings.store == BCCSPLAT_STORE_WAVELETS) {
    if (a.exact)
      fail_usage("--exact keeps samples as they are, and --store wavelets rounds them: choose one");
    const int32_t type = a.quantize;
    if (type != BCCSPLAT_TYPE_DEFAULT && type != BCCSPLAT_TYPE_U8 && type != BCCSPLAT_TYPE_U16)
      fail_usage("--store wavelets: samples are u8 or u16, and --quantize asks for others");
  }
  if (a.abs && !(*a.abs > 0))
    fail_usage(
        "--abs must be positive: the largest error allowed at any source sample, in units of the values");
  if (a.psnr && !(*a.psnr > 0)) fail_usage("--psnr must be positive, in dB: 50 is good, 70 is next to exact");
  if (!(a.air_threshold.value_or(0) >= 0)) fail_usage("--air-threshold must not be negative");
  a.settings.abs_error = a.abs.value_or(0), a.settings.psnr = a.psnr.value_or(0);
  if (!a.auto_levels())
    a.settings.levels = a.levels == "none" ? 0 : option_number<uint32_t>("--levels", a.levels);
  a.settings.lowpass = a.lowpass ? 1 : 0, a.settings.periodic_axes = static_cast<uint32_t>(a.periodic);
  a.settings.kernel = a.kernel;
}

} // namespace bcc4
