#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>

namespace slim::test {

/// A file or folder of the data shared between checkouts: below $SLIM_SHARED, else below `shared`
/// beside the source folder; nullopt if it is not there (then GTEST_SKIP with a sentence).
inline std::optional<std::filesystem::path> shared_data(const std::filesystem::path& relative) {
    namespace fs = std::filesystem;
    const char* variable = std::getenv("SLIM_SHARED");
    // This file is <source>/tests/support/shared_data.h.
    const fs::path source = fs::path(__FILE__).parent_path().parent_path().parent_path();
    const fs::path root =
        variable && *variable ? fs::path(variable) : source.parent_path() / "shared";
    const fs::path path = root / relative;
    std::error_code ignored;
    if (!fs::exists(path, ignored)) return std::nullopt;
    return path;
}

}  // namespace slim::test
