#pragma once

#include <string>

namespace slim {

/// Removes what processes of this host that were killed left of a file: `path` and
/// temporary_suffix() of each. Those of living processes, of other hosts and of containers with
/// process numbers of their own, whose processes cannot be told dead from here, stay.
/// cost   the folder is listed once in a process's life: what is left there later stays
void remove_dead_temporaries(const std::string& path);

}  // namespace slim
