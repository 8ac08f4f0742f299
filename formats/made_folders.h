#pragma once

#include <string>

namespace slim {

/// Makes a folder for outputs, and those above it, where there is none, and remembers which were
/// made. Returns whether it made this one, the deepest.
/// throws IoError: exit code `resource` where the disk is full, else `usage`
bool make_folders(const std::string& folder);

/// Removes those of the folders that this process made in which nothing lies: at the end of a
/// command that failed, which is to leave nothing behind.
void remove_empty_made_folders();

}  // namespace slim
