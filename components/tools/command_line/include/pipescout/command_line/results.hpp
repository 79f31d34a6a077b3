// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

/// What a command writes never takes the place of anything. The exceptions say so where they are:
/// stores that grow over days, and what is made anew from a mission folder into that folder.
namespace pipescout::command_line {

/// To be called before any work. Throws CommandError naming the file if there is one of this name,
/// or a folder. An empty path: no such result is asked for.
void require_new_file(const std::filesystem::path& file);

/// The same for a folder of results, which may exist if nothing is in it. The error names a file in
/// it.
void require_new_folder(const std::filesystem::path& folder);

/// FOLDER/000123_NAME.png: of image 123, from 0 on, of this name. A topic's slashes and blanks
/// become
/// '_'.
[[nodiscard]] std::filesystem::path numbered_picture(const std::filesystem::path& folder,
                                                     std::size_t number, std::string name);

}  // namespace pipescout::command_line
