// SPDX-License-Identifier: Apache-2.0
// Names, units and other attributes that a source gives its dimensions and variables. A file keeps them as
// objects of JSON (formats/bcc4.md, record 7); examples/python/bccsplat/records.py is the same for Python.
#pragma once

#include <nlohmann/json.hpp>

#include <cstddef>
#include <string>
#include <string_view>

#include "readers/frame_reader.h"
#include "series/data_kind.h"

namespace bcc4 {

using Record = nlohmann::ordered_json;

// The attributes of a file that hold them. axis: 0 to 3 of x, y, z and t.
[[nodiscard]] std::string axis_record(size_t axis);
[[nodiscard]] std::string channel_record(const std::string& channel);

// Whether an attribute of a source is one of a record: what a file says elsewhere is not, nor what is true of
// the source's bytes alone, or names other variables.
[[nodiscard]] bool in_record(std::string_view attribute, bool of_time);

// Returns a record of its text; an empty one where that is none.
[[nodiscard]] Record read_record(const std::string& text);
// Returns an attribute that is text; "" where there is none.
[[nodiscard]] std::string text_in(const Record& record, const char* attribute);

// Keep what a source says of a dimension, whose name "" is not known, or of a channel, where it says more
// than the file does by itself.
void keep_axis(SeriesDescription& d, size_t axis, const std::string& name, Record attributes);
void keep_channel(SeriesDescription& d, const std::string& channel, const Record& attributes);
// Keeps what a code of the source's header says that the data are.
void keep_kind(SeriesDescription& d, const std::string& channel, bccsplat::series::DataKind kind);

} // namespace bcc4
