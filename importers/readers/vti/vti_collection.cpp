// SPDX-License-Identifier: Apache-2.0
#include "readers/vti/vti_collection.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "readers/byte_stream.h"
#include "readers/data_files.h"
#include "readers/error.h"
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

// Takes the data sets as they are named. A run that was taken up at an earlier time goes on from there: what
// it had written from that time on no longer counts.
std::vector<DataSet> without_superseded(const std::string& collection, std::vector<DataSet> sets,
                                        bool other_times) {
  std::vector<DataSet> kept;
  double latest = -HUGE_VAL;
  for (DataSet& set : sets) {
    const double time = set.entry.time;
    const auto twin = time > latest && !at_one_time(time, latest)
                          ? kept.rend()
                          : std::find_if(kept.rbegin(), kept.rend(), [&](const DataSet& other) {
                              return at_one_time(other.entry.time, time);
                            });
    latest = std::max(latest, time);
    if (twin != kept.rend()) {
      const bool again = twin->entry.path == set.entry.path, next = twin == kept.rbegin();
      if (twin->beside(set) || (next && !again)) refuse_second_of_a_time(collection, *twin, set, other_times);
      const double from = twin->entry.time;
      if (again || !next) {
        std::erase_if(kept, [&](const DataSet& other) { return other.entry.time >= from; });
        latest = time;
      }
    }
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
  const size_t named = sets.size();
  sets = without_superseded(path, std::move(sets), other_times);
  if (sets.size() < named)
    c.note = concat(", without ", named - sets.size(), " whose times were written again later");
  std::stable_sort(sets.begin(), sets.end(),
                   [](const DataSet& a, const DataSet& b) { return a.entry.time < b.entry.time; });
  for (const DataSet& set : sets) c.entries.push_back(set.entry);
  return c;
}

} // namespace bcc4
