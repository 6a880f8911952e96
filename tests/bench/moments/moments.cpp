// SPDX-License-Identifier: Apache-2.0
// Reads the options and makes a row for each thing that is measured, each from a volume just opened: a random
// moment, playing, other cuts, boxes, levels against level 0. Series are written by moments_series.cpp.
#include "tests/bench/moments/moments.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <span>

#include "base/error.h"
#include "field/sample_grid.h"
#include "slice/hyperslice.h"
#include "tests/bench/fit/tool_import.h"
#include "tests/bench/moments/level_pictures.h"
#include "tests/bench/moments/moments_volume.h"
#include "tests/bench/moments/stored_slices.h"

namespace bccsplat::bench {
namespace {

Row import_row(Row row, const MomentSeries& s, const WrittenSeries& w, double gzip) {
  const double bytes = s.voxels();
  row.push_back(figure("MB", static_cast<double>(w.file.size()) / 1e6, 2));
  row.push_back(figure("import, CPU s", w.seconds, 2));
  row.push_back(figure("MiB/s", bytes / mebibyte / w.seconds, 1));
  row.push_back(figure("gzip -6, MiB/s", bytes / s.frames / mebibyte / gzip, 1));
  row.push_back(figure("import / gzip, time", w.seconds / (gzip * s.frames), 2));
  row.push_back(figure("MiB held", static_cast<double>(w.peak) / mebibyte, 0));
  row.push_back(figure("bytes a voxel of a frame", static_cast<double>(w.peak) / bytes * s.frames, 1));
  return row;
}

// What the tool takes that is told nothing but what the bytes are, beside one that is told all there is to
// decide; one run each.
Row tool_row(Row row, const MomentSeries& s, double gzip) {
  const ToolImport tool(source_of(s));
  const double given = tool.seconds("--lattice d4star --exact --measure none"), none = tool.seconds("");
  row.push_back(figure("no options, CPU s", none, 2));
  row.push_back(figure("all given, CPU s", given, 2));
  row.push_back(figure("none / given", none / given, 2));
  row.push_back(figure("none / gzip, time", none / (gzip * s.frames), 2));
  return row;
}

// The mean of moments, each from a volume that has been opened but not looked at.
Row random_row(Row row, const WrittenSeries& w, const MomentOptions& o, double blend, int level) {
  double seconds = 0, bytes = 0, decoded = 0, reach = 0, mebibytes = 0;
  std::mt19937 random(9);
  std::uniform_real_distribution<double> at(std::min(3.0, o.frames / 4.0),
                                            o.frames - std::min(4.0, o.frames / 4.0));
  for (int i = 0; i < o.count; ++i) {
    Opened volume(w, o, level);
    const double frame = at(random);
    seconds += cpu_seconds([&] { (void)volume.moment(frame); }) / o.count;
    bytes += static_cast<double>(volume.reader->bytes_read() - volume.opening) / o.count;
    decoded += volume.layers_decoded() / o.count;
    reach += static_cast<double>(volume.in_reach(frame).size()) / o.count;
    mebibytes += volume.mebibytes() / o.count;
  }
  row.push_back(figure("CPU s", seconds, 3));
  row.push_back(figure("raw frames in memory, blended: CPU s", blend, 4));
  row.push_back(figure("layers in reach", reach, 1));
  row.push_back(figure("layers decoded", decoded, 1));
  row.push_back(figure("MB read", bytes / 1e6, 2));
  row.push_back(figure("MiB held", mebibytes, 0));
  return row;
}

// All of the series, half a frame on at a time, from a volume that stays open.
Row playing_row(Row row, const WrittenSeries& w, const MomentOptions& o) {
  Opened volume(w, o);
  double first = 0, others = 0, slowest = 0;
  const uint32_t steps = 2 * (o.frames - 1);
  for (uint32_t i = 0; i <= steps; ++i) {
    const double s = cpu_seconds([&] { (void)volume.moment(0.5 * i); });
    (i == 0 ? first : others) += s;
    if (i > 0) slowest = std::max(slowest, s);
  }
  row.push_back(figure("playing needs, MiB", static_cast<double>(volume.playing.bytes()) / mebibyte, 0));
  row.push_back(figure("cache, MiB", static_cast<double>(volume.cache) / mebibyte, 0));
  row.push_back(figure("first, CPU s", first, 3));
  row.push_back(figure("each of the others, CPU s", others / steps, 3));
  row.push_back(figure("slowest, CPU s", slowest, 3));
  row.push_back(figure("layers decoded", volume.layers_decoded(), 1));
  row.push_back(figure("of these twice", volume.layers_decoded_twice(), 1));
  row.push_back(figure("layers prefiltered", static_cast<double>(volume.field.layers_made()), 0));
  const uint64_t layers = volume.reader->info().lattice.layers();
  const uint64_t made = volume.field.layers_made();
  row.push_back(figure("twice", static_cast<double>(made - std::min(made, layers)), 0));
  row.push_back(figure("MiB held", volume.mebibytes(), 0));
  return row;
}

// Slices through the middle of the series, each from a volume that has been opened but not looked at. Where
// an x slice lies in its column of bricks decides whether it reads the next one, too: the row is the mean of
// places spread over a whole column.
void cut_rows(const Row& head, const WrittenSeries& w, const MomentOptions& o, std::vector<Row>& rows) {
  const double middle = 0.5 * o.edge, t = 0.53 * o.frames;
  constexpr int places = 8;
  std::vector<Hyperplane> across_x;
  double column_share = 0; // of the sites along x
  {
    const Lattice4 lattice = Opened(w, o).stored().lattice;
    const double column = 2 * brick_edge * lattice.space_step[0]; // voxels
    column_share = static_cast<double>(brick_edge) / lattice.space.dims(0)[0];
    for (int n = 0; n < places; ++n)
      across_x.push_back(
          Hyperplane::through({middle + (n + 0.5) / places * column, middle, middle, t}, {1, 0, 0, 0}));
  }
  const std::pair<const char*, std::vector<Hyperplane>> cuts[] = {
      {"x slice", across_x},
      {"oblique", {Hyperplane::through({0.47 * o.edge, middle, middle, t}, {.6, 0, 0, .8})}}};
  for (const auto& [name, planes] : cuts) {
    const auto count = static_cast<double>(planes.size());
    double seconds = 0, layers = 0, read = 0, held = 0;
    for (const Hyperplane& plane : planes) {
      Opened volume(w, o);
      seconds +=
          cpu_seconds([&] { (void)hyperslice(volume.field, plane, {}, {}, volume.context.get()); }) / count;
      layers += volume.layers_decoded() / count;
      read += static_cast<double>(volume.reader->bytes_read() - volume.opening) / count;
      held = std::max(held, volume.mebibytes());
    }
    const double share = read / static_cast<double>(w.file.size());
    Row row = head;
    row.push_back(word("cut", name));
    row.push_back(figure("places", count, 0));
    row.push_back(figure("CPU s", seconds, 3));
    row.push_back(figure("layers decoded", layers, 1));
    row.push_back(figure("MB read", read / 1e6, 2));
    row.push_back(figure("share of the file", share, 3));
    const char* const over = "over a column's share of the sites";
    row.push_back(planes.size() > 1 ? figure(over, share / column_share, 2) : word(over, ""));
    row.push_back(figure("MiB held", held, 0));
    rows.push_back(std::move(row));
  }
}

// Boxes of a moment in the middle of the series, of whole, half and a quarter of its edges, each from a
// volume that has been opened but not looked at, and half a frame on.
void box_rows(const Row& head, const WrittenSeries& w, const MomentOptions& o, std::vector<Row>& rows) {
  for (const int part : {1, 2, 4}) {
    Opened volume(w, o);
    const double middle = 0.5 * (o.edge - 1), half = middle / part, frame = 0.53 * o.frames;
    HypersliceOptions options;
    options.box = IndexBox{{middle - half, middle - half, middle - half},
                           {middle + half, middle + half, middle + half}};
    const Coefficients field(volume.samples, 0, volume.kernel, 0, volume.share.coefficients,
                             options.reads(volume.samples.lattice(), volume.kernel));
    const auto cut = [&](double at) {
      return cpu_seconds([&] {
        (void)hyperslice(field, {0, 0, 0, 1, -at}, options, {}, volume.context.get());
      });
    };
    const double first = cut(frame);
    Row row = head;
    row.push_back(word("box", part == 1 ? "all" : concat("1/", part, " of the edges")));
    row.push_back(figure("CPU s", first, 3));
    row.push_back(
        figure("MB read", static_cast<double>(volume.reader->bytes_read() - volume.opening) / 1e6, 2));
    row.push_back(figure("half a frame on, CPU s", cut(frame + 0.5), 3));
    row.push_back(figure("MiB held", volume.mebibytes(), 0));
    rows.push_back(std::move(row));
  }
}

// The means of a moment over pixels of 2^level voxels along each axis, in the middle of the box.
std::vector<float> pixels(Opened& volume, double frame, int level) {
  constexpr int32_t pixels = 12;
  const int32_t side = 1 << level, n = pixels * side;
  const Slice slice = volume.moment(frame);
  Grid grid;
  for (size_t a = 0; a < 3; ++a) {
    grid.dims[a] = n, grid.step[a] = 1;
    grid.origin[a] = std::floor((volume.stored().lattice.dims[a] - n) / 2.0);
  }
  std::vector<float> values(static_cast<size_t>(n) * n * n);
  sample_grid(slice, grid, values.data(), volume.context.get());
  std::vector<float> means(static_cast<size_t>(pixels) * pixels * pixels);
  for (size_t i = 0; i < values.size(); ++i) {
    const auto at = [&](size_t voxels) {
      return i / voxels % static_cast<size_t>(n) / static_cast<size_t>(side);
    };
    const size_t row = n;
    means[(at(row * row) * pixels + at(row)) * pixels + at(1)] +=
        values[i] / static_cast<float>(side * side * side);
  }
  return means;
}

// A level against level 0 at its own pixels.
Row level_row(Row row, const WrittenSeries& w, const MomentOptions& o, int level) {
  Opened whole(w, o), coarse(w, o, level);
  const double frame = 0.47 * o.frames;
  const std::vector<float> exact = pixels(whole, frame, level), given = pixels(coarse, frame, level);
  double squares = 0, largest = 0;
  for (size_t i = 0; i < exact.size(); ++i) {
    const double error = std::fabs(static_cast<double>(given[i] - exact[i]));
    squares += error * error / static_cast<double>(exact.size()), largest = std::max(largest, error);
  }
  row.push_back(figure("MB of its chunks", static_cast<double>(coarse.reader->level_bytes(level)) / 1e6, 2));
  row.push_back(figure("RMSE at its pixels, codes", std::sqrt(squares), 3));
  row.push_back(figure("PSNR, dB of 255", 20 * std::log10(255 / std::sqrt(squares)), 1));
  row.push_back(figure("largest", largest, 2));
  return row;
}

MomentOptions read_options(std::span<const std::string> args, bool quick) {
  MomentOptions o;
  if (quick) o.edge = 48, o.count = 2;
  for (size_t i = 0; i < args.size(); ++i) {
    const std::string& a = args[i];
    const auto number = [&] {
      if (i + 1 == args.size()) fail(Code::invalid_argument, "moments: ", a, " needs a number");
      return std::stoul(args[++i]);
    };
    if (a == "--edge")
      o.edge = static_cast<uint32_t>(number());
    else if (a == "--frames")
      o.frames = static_cast<uint32_t>(number());
    else if (a == "--count")
      o.count = static_cast<int>(number());
    else if (a == "--levels")
      o.levels = static_cast<int>(number());
    else if (a == "--cache")
      o.cache = uint64_t{number()} << 20;
    else if (a == "--dense" || a == "--sparse")
      o.sparse = {a == "--sparse"};
    else if (a == "--cuts")
      o.cuts = true;
    else if (a == "--slices")
      o.slices = true;
    else if (a == "--pictures")
      o.pictures = true;
    else if (a == "--contents")
      o.contents = true;
    else
      fail(Code::invalid_argument, "moments: unknown option ", a);
  }
  if ((o.pictures || o.contents) && o.levels == 0) o.levels = 3;
  if (o.edge < 16 || o.frames < 8 || o.count < 1)
    fail(Code::invalid_argument, "moments: at least 16 voxels along an axis, 8 frames and 1 moment");
  return o;
}

// Pictures of all levels of a series and the raw player's, whose truth is told by another.
void picture_rows(const Row& head, MomentSeries series, const WrittenSeries& truth, const MomentOptions& o,
                  std::vector<Row>& rows) {
  series.measured = true;
  level_picture_rows(head, write_series(series), o, best_picture(truth, o)->image, rows);
  raw_picture_rows(head, series, o, best_picture(truth, o, Lit::everything)->image, rows);
}

// Pictures of levels of dense series that differ in what fills them.
void report_contents(const MomentOptions& o, const Report& report) {
  std::vector<Row> pictures;
  for (int i = 0; i < contents; ++i) {
    MomentSeries series{.edge = o.edge, .frames = o.frames, .fill = static_cast<Content>(i), .exact = true};
    const WrittenSeries exact = write_series(series);
    series.exact = false, series.levels = o.levels;
    const Row head{word("series", concat(name_of(series.fill), ", ", o.edge, "^3 x ", o.frames, " u8"))};
    picture_rows(head, series, exact, o, pictures);
  }
  report.table("pictures of levels, one thread", pictures);
}

} // namespace

int run_moments_suite(std::span<const std::string> args, const Report& report) {
  const MomentOptions o = read_options(args, report.quick);
  if (o.contents) return report_contents(o, report), 0;
  std::vector<Row> imports, tools, moments, playing, boxes, cuts, levels, pictures, slices;
  for (const bool sparse : o.sparse) {
    MomentSeries series{.edge = o.edge, .frames = o.frames, .sparse = sparse};
    const Row head{
        word("series", concat(o.edge, "^3 x ", o.frames, " u8, ", sparse ? "an eighth filled" : "dense"))};
    if (o.slices) {
      slice_rows(head, series, slices);
      continue;
    }
    const double blend = blend_seconds(series), gzip = gzip_seconds(series);
    if (has_tool() && !o.pictures) tools.push_back(tool_row(head, series, gzip));
    const auto levelled = [&](int level, const char* name) {
      Row row = head;
      if (o.levels > 0) row.push_back(figure(name, level, 0));
      return row;
    };
    if (o.levels > 0 && !o.pictures)
      imports.push_back(import_row(levelled(0, "levels"), series, write_series(series), gzip));
    series.levels = o.levels;
    const WrittenSeries w = write_series(series);
    if (o.levels > 0) picture_rows(head, series, w, o, pictures);
    if (o.pictures) continue;
    imports.push_back(import_row(levelled(o.levels, "levels"), series, w, gzip));
    for (int l = 0; l <= o.levels; ++l) moments.push_back(random_row(levelled(l, "level"), w, o, blend, l));
    for (int l = 1; l <= o.levels; ++l) levels.push_back(level_row(levelled(l, "level"), w, o, l));
    playing.push_back(playing_row(head, w, o));
    box_rows(head, w, o, boxes);
    if (o.cuts) cut_rows(head, w, o, cuts);
  }
  report.table("import, one thread", imports);
  report.table("import by the tool, one thread", tools);
  report.table("a random moment, one thread", moments);
  report.table("levels against level 0", levels);
  report.table("pictures of levels, one thread", pictures);
  report.table("half a frame on at a time, one thread", playing);
  report.table("a box of a moment, one thread", boxes);
  report.table("other cuts, one thread", cuts);
  report.table("slices of files by the tool, one thread", slices);
  return 0;
}

} // namespace bccsplat::bench
