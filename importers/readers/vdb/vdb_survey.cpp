// SPDX-License-Identifier: Apache-2.0
// Goes through the files of an OpenVDB series: chooses grids by the first file that has any, unites the
// bounds of their active voxels, and checks that their transforms differ by whole voxels only.
#include "readers/vdb/vdb_survey.h"

#include <algorithm>
#include <cmath>

#include "readers/error.h"

namespace bcc4 {
namespace {

// Returns the whole voxels from the grid of `reference` to that of `other`; throws when their transforms
// differ by anything else.
VoxelOffset voxel_offset(const VdbGridInfo& reference, const VdbGridInfo& other, const std::string& path) {
  const Affine &a = reference.affine, &b = other.affine;
  const double size = std::cbrt(std::abs(determinant(a)));
  double difference = 0;
  for (size_t i = 0; i < 11; ++i)
    if (i % 4 != 3) difference = std::max(difference, std::abs(a[i] - b[i]));
  if (difference > 1e-6 * size)
    fail_input(path, ": the voxels of grid \"", other.name,
               "\" differ in size or direction from those of the first frame: "
               "resample the sequence to one transform");
  // Cramer's rule solves A * offset = difference of translations.
  const std::array<double, 3> t{b[3] - a[3], b[7] - a[7], b[11] - a[11]};
  VoxelOffset offset{};
  for (size_t column = 0; column < 3; ++column) {
    Affine m = a;
    for (size_t row = 0; row < 3; ++row) m[row * 4 + column] = t[row];
    const double voxels = determinant(m) / determinant(a);
    if (std::abs(voxels - std::round(voxels)) > 1e-3 || std::abs(voxels) > 1e9)
      fail_input(path, ": grid \"", other.name, "\" is moved by ", voxels,
                 " voxels against the first frame; only whole voxels can be followed");
    offset[column] = static_cast<int32_t>(std::round(voxels));
  }
  return offset;
}

VdbBounds moved(VdbBounds bounds, const VoxelOffset& by) {
  if (bounds.empty()) return bounds;
  for (size_t a = 0; a < 3; ++a) {
    bounds.begin[a] += by[a];
    bounds.end[a] += by[a];
  }
  return bounds;
}

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Whether a file has several grids of one name, which are told apart by numbers.
bool has_several(const std::vector<std::string>& names, const std::string& name) {
  return std::any_of(names.begin(), names.end(), [&](const auto& n) { return n.starts_with(name + "["); });
}

} // namespace

VdbSurvey::VdbSurvey(const ReaderOptions& options)
    : chosen_(!options.grids.empty()), fog_(options.level_set_fog.value_or(false)) {
  for (const std::string& name : options.grids) grids_.push_back({.name = name});
}

void VdbSurvey::choose_grids(VdbFile& file) {
  const std::vector<std::string> scalars = file.scalar_names();
  if (scalars.empty()) return;
  if (scalars.size() > 1 && !holds(scalars, "density"))
    fail_usage(file.path(), ": several grids: choose with --grid: ", join(scalars));
  if (scalars.size() > 1) choice_ = concat("of the grids ", join(scalars), " density was taken (use --grid)");
  grids_.push_back({.name = scalars.size() > 1 ? "density" : scalars[0]});
  grids_[0].present.assign(files_, false);
  grids_[0].active.assign(files_, 0);
  grids_[0].first_absent = first_file_;
  for (const std::string& name : scalars) others_[name] = ""; // told by the choice
}

void VdbSurvey::note_others(VdbFile& file, const std::vector<std::string>& names) {
  const auto is_new = [&](const std::string& name) { return !others_.contains(name); };
  if (chosen_ || std::none_of(names.begin(), names.end(), is_new)) return;
  const std::vector<std::string> scalars = file.scalar_names();
  for (const std::string& name : names)
    if (is_new(name))
      others_[name] = holds(scalars, name) ? concat("first in ", file.path()) : std::string("no scalars");
}

void VdbSurvey::check_grid(const SurveyedGrid& grid, const VdbGridInfo& info, const std::string& path) const {
  if (info.type != grid.info->type)
    fail_input(path, ": grid \"", info.name, "\" holds ", info.tree_type, " values, in the first frame ",
               type_name(grid.info->type));
  if (!(std::abs(determinant(info.affine)) > 0))
    fail_input(path, ": the transform of grid \"", info.name, "\" is singular");
}

void VdbSurvey::add(VdbFile& file) {
  const std::string& path = file.path();
  const std::vector<std::string> names = file.names();
  if (files_ == 0) first_file_ = path;
  if (grids_.empty()) choose_grids(file);
  note_others(file, names);
  const bool any =
      std::any_of(grids_.begin(), grids_.end(), [&](const SurveyedGrid& g) { return holds(names, g.name); });
  VdbBounds frame;
  std::optional<VoxelOffset> offset;
  FileTime time;
  for (SurveyedGrid& grid : grids_) {
    const bool knows_active = grid.active.size() == files_;
    const bool there = holds(names, grid.name);
    grid.present.push_back(there);
    // A file of other grids alone is not one of a series of which nobody said what to read.
    if (!there && (has_several(names, grid.name) || (!chosen_ && !any && !names.empty())))
      (void)file.read_info(grid.name, false, fog_); // says what it has
    if (!there) {
      if (grid.first_absent.empty()) grid.first_absent = path;
      if (knows_active) grid.active.push_back(0);
      continue;
    }
    const VdbGridInfo info = file.read_info(grid.name, !grid.info, fog_);
    if (!grid.info) grid.info = info;
    if (!reference_) reference_ = info;
    check_grid(grid, info, path);
    level_sets_ = level_sets_ || info.level_set;
    if (info.active && knows_active) grid.active.push_back(*info.active);
    const VoxelOffset own = voxel_offset(*reference_, info, path);
    if (!offset) time = {info.told.time, info.told.time_unit};
    if (own != offset.value_or(own))
      fail_input(path, ": grid \"", grid.name, "\" is moved against the others");
    offset = own;
    frame.unite(moved(info.bounds, own));
  }
  offsets_.push_back(offset.value_or(VoxelOffset{}));
  times_.push_back(time);
  empty_frames_ += frame.empty();
  bounds_.unite(frame);
  ++files_;
}

void VdbSurvey::finish(VdbFile& first) {
  if (grids_.empty()) {
    const std::vector<std::string> all = first.names();
    if (all.empty()) fail_input(first.path(), ": holds no grids");
    (void)first.read_info(all[0], false, false); // says why it cannot be read
    fail_input(first.path(), ": no scalar grid among ", join(all));
  }
  for (SurveyedGrid& grid : grids_) {
    if (!grid.info) (void)first.read_info(grid.name, false, fog_); // says what it has instead
    if (grid.active.size() < files_) grid.active.clear();
  }
}

std::vector<std::string> VdbSurvey::notes() const {
  std::vector<std::string> notes;
  if (!choice_.empty()) notes.push_back(choice_);
  std::vector<std::string> left_out;
  for (const auto& [name, why] : others_)
    if (!why.empty()) left_out.push_back(concat(name, " (", why, ")"));
  if (!left_out.empty())
    notes.push_back(concat("left out: ", join(left_out), "; --grid takes grids of scalars by their names"));
  for (const SurveyedGrid& grid : grids_) {
    const auto absent = std::count(grid.present.begin(), grid.present.end(), false);
    if (absent > 0)
      notes.push_back(concat("grid ", grid.name, " is not in ", absent, " of ", files_, " files, such as ",
                             grid.first_absent, ": empty there"));
  }
  return notes;
}

} // namespace bcc4
