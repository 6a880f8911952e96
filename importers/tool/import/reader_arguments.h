// SPDX-License-Identifier: Apache-2.0
// The options that say how the input is to be read, shared by import and verify.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "readers/reader_options.h"
#include "tool/handles.h"
#include "tool/options.h"

namespace bcc4 {

struct ReaderArguments {
  ReaderOptions options;
  std::vector<std::pair<std::string, std::string>> texts; // options as typed, without the dashes
};

// Inputs are not among them: each command names its own.
void add_reader_options(const Command& command, ReaderArguments& arguments);

// Sets an option of a reader as if it had been typed.
void set_reader_option(ReaderArguments& arguments, const std::string& key, const std::string& text);

// What import keeps in the file, so that verify reads the source the same way without being told again.
[[nodiscard]] std::vector<std::pair<std::string, std::string>>
reader_attributes(const ReaderArguments& arguments);
// Sets every recorded option the user has not given himself.
void recall_reader_options(const Volume& volume, ReaderArguments& arguments);

} // namespace bcc4
