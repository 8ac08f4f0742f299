#pragma once

#include <string>

namespace slim {

/// "0.1.0 (1a2b3c4)": release and commit, "+" if the tree was changed when it was configured.
std::string program_version();

}  // namespace slim
