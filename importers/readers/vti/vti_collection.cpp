// SPDX-License-Identifier: Apache-2.0
#include "readers/vti/vti_collection.h"

#include <algorithm>
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
  std::string part, group;
};

// Frames at one time are parts of one frame, or their times are too coarse.
void refuse_second_of_a_time(const std::string& collection, const DataSet& a, const DataSet& b,
                             bool other_times) {
  if (a.part != b.part || a.group != b.group)
    fail_input(collection, ": timestep ", a.entry.time, " has several parts, ", a.entry.path, " and ",
               b.entry.path, ", which are not joined: write one .vti for each time step");
  if (!other_times)
    fail_input(collection, ": timestep ", a.entry.time, " has two files, ", a.entry.path, " and ",
               b.entry.path, ": leave one out, or give --dt or --times");
}

} // namespace

std::vector<CollectionEntry> read_collection(const std::string& path, const ReaderOptions& options) {
  std::string text = read_text_file(path, 64 << 20);
  pugi::xml_document document;
  parse_xml(text, path, document);
  const pugi::xml_node root = document.document_element(), collection = root.child("Collection");
  if (root.attribute("type").value() != std::string_view("Collection") || !collection)
    fail_input(path, ": not a VTK collection (.pvd)");
  const bool other_times = options.dt || options.times;
  std::vector<DataSet> sets;
  for (const pugi::xml_node e : collection.children("DataSet")) {
    const auto time = parse_number<double>(e.attribute("timestep").value());
    if (!time && !other_times)
      fail_input(path, ": data set ", sets.size(), " has no timestep: give --dt or --times");
    const std::string file = e.attribute("file").value();
    sets.push_back({{time.value_or(static_cast<double>(sets.size())), file_of(path, file)},
                    e.attribute("part").as_string("0"),
                    e.attribute("group").value()});
  }
  if (sets.empty()) fail_input(path, ": names no data sets");
  std::stable_sort(sets.begin(), sets.end(),
                   [](const DataSet& a, const DataSet& b) { return a.entry.time < b.entry.time; });
  for (size_t i = 1; i < sets.size(); ++i)
    if (sets[i].entry.time == sets[i - 1].entry.time)
      refuse_second_of_a_time(path, sets[i - 1], sets[i], other_times);
  std::vector<CollectionEntry> entries;
  for (const DataSet& set : sets) entries.push_back(set.entry);
  return entries;
}

} // namespace bcc4
