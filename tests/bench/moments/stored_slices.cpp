// SPDX-License-Identifier: Apache-2.0
// Has the tool store a series and cuts its file as a host does, each slice from a device of its own, whose
// peak is then that slice's.
#include "tests/bench/moments/stored_slices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <span>
#include <string>

#include <zlib.h>

#include "base/error.h"
#include "tests/bench/fit/tool_import.h"
#include "tests/bench/scale/scale_host.h"

namespace bccsplat::bench {
namespace {

constexpr int repeats = 3; // of which the least counts
constexpr double mebibyte_bytes = 1 << 20;

struct Asked {
  const char* name;
  double index;
  bool once = false, boxed = false;
};

struct Cost {
  double seconds = INFINITY, next = INFINITY; // and of the moment a tenth of a frame on
  double mebibytes = 0, megabytes_read = 0;
};

Cost cost_of(const std::string& path, const Asked& asked, uint32_t edge) {
  Cost least;
  for (int i = 0; i < repeats; ++i) {
    const Handle<bccsplat_device> device = make_api_device(1);
    bccsplat_volume* opened = nullptr;
    api(bccsplat_volume_open_file(device.get(), path.c_str(), nullptr, &opened));
    const Handle<bccsplat_volume> volume(opened);
    const double middle = 0.5 * (edge - 1), half = middle / 4;
    const std::array box{middle - half, middle - half, middle - half,
                         middle + half, middle + half, middle + half};
    const auto cut = [&](double index) {
      auto plane = host::sized<bccsplat_hyperplane>();
      plane.d = 1, plane.e = -index;
      auto options = host::sized<bccsplat_slice_options>();
      options.once = asked.once ? 1 : 0;
      if (asked.boxed) options.box = box.data();
      bccsplat_slice* made = nullptr;
      const double seconds =
          cpu_seconds([&] { api(bccsplat_slice_create(volume.get(), &plane, &options, &made)); });
      const Handle<bccsplat_slice> slice(made);
      least.megabytes_read =
          std::max(least.megabytes_read, static_cast<double>(info_of(made).bytes_read) / 1e6);
      return seconds;
    };
    least.seconds = std::min(least.seconds, cut(asked.index));
    least.mebibytes = static_cast<double>(peak_of(device.get())) / mebibyte_bytes;
    least.next = std::min(least.next, cut(asked.index + .1));
  }
  return least;
}

// Seconds that one frame takes out of gzip -6, and the bytes that it was; the frame alone is held.
Row plain_row(Row row, const MomentSeries& series) {
  const std::vector<uint8_t> raw = series.frame(series.frames / 3);
  uLongf size = compressBound(static_cast<uLong>(raw.size()));
  std::vector<Bytef> packed(size), out(raw.size());
  if (compress2(packed.data(), &size, raw.data(), static_cast<uLong>(raw.size()), 6) != Z_OK)
    fail(Code::internal, "zlib: no room");
  double least = INFINITY;
  for (int i = 0; i < repeats; ++i)
    least = std::min(least, cpu_seconds([&] {
                       uLongf got = static_cast<uLongf>(out.size());
                       if (uncompress(out.data(), &got, packed.data(), size) != Z_OK)
                         fail(Code::internal, "zlib: another frame");
                     }));
  row.push_back(word("file", "gzip -6 of each frame"));
  row.push_back(figure("MB", static_cast<double>(size) * series.frames / 1e6, 2));
  row.push_back(word("slice", "a frame"));
  row.push_back(figure("CPU s", least, 3));
  row.push_back(word("a tenth of a frame on", ""));
  row.push_back(figure("MiB held", static_cast<double>(raw.size()) / mebibyte_bytes, 0));
  row.push_back(figure("MB read", static_cast<double>(size) / 1e6, 2));
  return row;
}

} // namespace

FitSource source_of(const MomentSeries& s) {
  FitSource source;
  source.dims = {s.edge, s.edge, s.edge, s.frames}, source.type = SourceType::u8;
  for (uint32_t t = 0; t < s.frames; ++t) {
    const std::vector<uint8_t> frame = s.frame(t);
    const auto bytes = std::as_bytes(std::span(frame));
    source.bytes.insert(source.bytes.end(), bytes.begin(), bytes.end());
  }
  return source;
}

void slice_rows(const Row& head, const MomentSeries& series, std::vector<Row>& rows) {
  const ToolImport tool(source_of(series));
  const double frame = std::floor(series.frames / 3.0);
  const std::array all{Asked{"a frame", frame}, Asked{"a moment", frame + .5},
                       Asked{"a moment, once", frame + .5, true},
                       Asked{"1/64 of the moment", frame + .5, false, true}};
  for (const auto& [name, options] :
       {std::pair{"no options", ""}, {"samples", "--store samples --levels none --measure none"}}) {
    (void)tool.seconds(options);
    for (const Asked& asked : all) {
      const Cost cost = cost_of(tool.file(), asked, series.edge);
      Row row = head;
      row.push_back(word("file", name));
      row.push_back(figure("MB", static_cast<double>(std::filesystem::file_size(tool.file())) / 1e6, 2));
      row.push_back(word("slice", asked.name));
      row.push_back(figure("CPU s", cost.seconds, 3));
      row.push_back(figure("a tenth of a frame on", cost.next, 3));
      row.push_back(figure("MiB held", cost.mebibytes, 0));
      row.push_back(figure("MB read", cost.megabytes_read, 2));
      rows.push_back(std::move(row));
    }
  }
  rows.push_back(plain_row(head, series));
}

} // namespace bccsplat::bench
