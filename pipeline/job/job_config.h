#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace slim {

/// A job as TOML with everything that could be written in it: every key of [input.scan], [fit],
/// [measure] and [render] with its value or its default, views and lights as they are, their names
/// and AOVs filled in, --set applied, paths absolute. Running it does the same. Throws as read_job.
std::string resolved_job(const std::filesystem::path& file,
                         const std::vector<std::string>& settings);

}  // namespace slim
