// SPDX-License-Identifier: Apache-2.0
// Data sets are taken in the order in which a run names them: what is named later counts.
#include "readers/vti/vti_collection.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "readers/byte_stream.h"
#include "readers/data_files.h"
#include "readers/error.h"
#include "readers/name_numbers.h"
#include "readers/system.h"
#include "readers/vti/xml.h"

namespace bcc4 {
namespace {

std::string file_of(const std::string& collection, std::string name) {
  if (auto path = path_below(collection, name); path && std::filesystem::exists(to_path(*path))) return *path;
  std::replace(name.begin(), name.end(), '\\', '/'); // as Windows writes it
  if (auto path = path_below(collection, name)) return *path;
  fail_input(collection, ": names the file ", name,
             ", which is not below the collection's own folder: move the collection to a folder above its "
             "files and name them from there, or give the files themselves with --times");
}

struct DataSet {
  CollectionEntry entry;
  std::string part, group, name;
  [[nodiscard]] bool beside(const DataSet& other) const {
    return part != other.part || group != other.group || name != other.name;
  }
};

bool at_one_time(double a, double b) {
  constexpr double rounding = 1e-12; // restarted runs add up their steps anew
  return std::abs(a - b) <= rounding * std::max(std::abs(a), std::abs(b));
}

// Frames at one time, one named behind the other, are parts of one frame, or their times are too coarse.
void refuse_second_of_a_time(const std::string& collection, const DataSet& a, const DataSet& b,
                             bool other_times) {
  if (a.beside(b))
    fail_input(collection, ": timestep ", a.entry.time, " has several parts, ", a.entry.path, " and ",
               b.entry.path, ", which are not joined: write one .vti for each time step");
  if (!other_times)
    fail_input(collection, ": timestep ", a.entry.time, " has two files, ", a.entry.path, " and ",
               b.entry.path, ": leave one out, or give --dt or --times");
}

// Whether two files count as their times do, by the numbers in their names: s_2 and s_10.
bool counts_before(const std::string& path, const std::string& other) {
  std::vector<SequenceFile> files{{path}, {other}};
  try {
    if (order_by_names(files) == NameOrder::given) return false;
  } catch (const Error&) { // one number
    return false;
  }
  return (files[0].number < files[1].number) == (files[0].path == path);
}

// The names of files that are left out, not all of many.
std::string names_of(const std::vector<DataSet>& sets) {
  constexpr size_t most = 3;
  std::vector<std::string> names;
  for (const DataSet& set : sets)
    if (names.size() < most) names.push_back(to_text(to_path(set.entry.path).filename()));
  return sets.size() > most ? concat(join(names, ", "), " ...") : join(names);
}

// Takes the data sets as they are named. A run that was taken up at an earlier time goes on from there: what
// it had written from that time on no longer counts. A collection that is only not sorted has files whose
// numbers go with their times.
std::vector<DataSet> without_superseded(const std::string& collection, std::vector<DataSet> sets,
                                        bool other_times, std::vector<DataSet>& left_out) {
  std::vector<DataSet> kept;
  double latest = -HUGE_VAL;
  std::string latest_path;
  const auto take_up = [&](double from) {
    const auto old = std::stable_partition(kept.begin(), kept.end(),
                                           [&](const DataSet& other) { return other.entry.time < from; });
    left_out.insert(left_out.end(), old, kept.end());
    kept.erase(old, kept.end());
    latest = -HUGE_VAL;
  };
  for (DataSet& set : sets) {
    const double time = set.entry.time;
    const auto twin = time > latest && !at_one_time(time, latest)
                          ? kept.rend()
                          : std::find_if(kept.rbegin(), kept.rend(), [&](const DataSet& other) {
                              return at_one_time(other.entry.time, time);
                            });
    if (twin == kept.rend() && !other_times && time < latest && !at_one_time(time, latest) &&
        !kept.back().beside(set) && counts_before(latest_path, set.entry.path))
      take_up(time);
    if (twin != kept.rend()) {
      const bool again = twin->entry.path == set.entry.path, next = twin == kept.rbegin();
      if (twin->beside(set) || (next && !again)) refuse_second_of_a_time(collection, *twin, set, other_times);
      const double from = twin->entry.time;
      if (again || !next) take_up(from);
    }
    if (time > latest) latest = time, latest_path = set.entry.path;
    kept.push_back(std::move(set));
  }
  return kept;
}

} // namespace

Collection read_collection(const std::string& path, const ReaderOptions& options) {
  std::string text = read_text_file(path, 64 << 20);
  pugi::xml_document document;
  parse_xml(text, path, document);
  const pugi::xml_node root = document.document_element(), collection = root.child("Collection");
  if (root.attribute("type").value() != std::string_view("Collection") || !collection)
    fail_input(path, ": not a VTK collection (.pvd)");
  const bool other_times = options.dt || options.times;
  std::vector<DataSet> sets;
  Collection c;
  for (const pugi::xml_node e : collection.children("DataSet")) {
    const auto time = parse_number<double>(e.attribute("timestep").value());
    if (!time && !other_times)
      fail_input(path, ": data set ", sets.size(), " has no timestep: give --dt or --times");
    const std::string file = e.attribute("file").value();
    c.timed = c.timed && time;
    sets.push_back({{time.value_or(static_cast<double>(sets.size())), file_of(path, file)},
                    e.attribute("part").as_string("0"),
                    e.attribute("group").value(),
                    e.attribute("name").value()});
  }
  if (sets.empty()) fail_input(path, ": names no data sets");
  std::vector<DataSet> left_out;
  sets = without_superseded(path, std::move(sets), other_times, left_out);
  std::erase_if(left_out, [&](const DataSet& old) { // written over, or named twice
    return std::any_of(sets.begin(), sets.end(),
                       [&](const DataSet& set) { return set.entry.path == old.entry.path; });
  });
  if (!left_out.empty())
    c.note = concat(", without ", left_out.size(),
                    " that the run wrote before it was taken up again: ", names_of(left_out));
  std::stable_sort(sets.begin(), sets.end(),
                   [](const DataSet& a, const DataSet& b) { return a.entry.time < b.entry.time; });
  for (const DataSet& set : sets) c.entries.push_back(set.entry);
  return c;
}

} // namespace bcc4
