// SPDX-License-Identifier: Apache-2.0
// Data files that a header names: inside its own folder, one by one or by a format with numbers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace bcc4 {

// Returns the path of a file named by a header, none when it does not lie below the header's own folder: a
// file from a stranger cannot make another one be read.
[[nodiscard]] std::optional<std::string> path_below(const std::string& header, std::string_view name);
// The same of a data file; throws when it does not lie there.
[[nodiscard]] std::string confined_path(const std::string& header, std::string_view name);

// Returns the files that "name.%03d 1 93 1" names, as confined paths: the format with the numbers first,
// first + step ... last put in. `words` are the format and three numbers; `where` begins the texts of errors.
[[nodiscard]] std::vector<std::string> numbered_data_files(const std::string& header,
                                                           const std::string& where,
                                                           const std::vector<std::string_view>& words);

} // namespace bcc4
