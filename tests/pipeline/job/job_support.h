#pragma once

#include "pipeline/job/job.h"
#include "slim/base/error.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

namespace slim::test {

inline constexpr const char* kDemo = R"(
[input.scan]
shape = "sculpture"
points = 1000
noise = 0.001

[fit]
degree = 3

[render]
size = "640x480"

[[view]]
name = "front"
camera = "front"

[[view]]
camera = "iso"
aovs = ["mean"]
size = "320x240"

[measure]

[output]
dir = "out"
aovs = ["shaded", "k1"]
)";

/// A folder of this process alone, as tests run side by side; gone at its end.
inline const std::filesystem::path& job_folder() {
    struct Folder {
        std::filesystem::path path =
            std::filesystem::path(testing::TempDir()) / ("slim_job_" + std::to_string(getpid()));
        Folder() { std::filesystem::create_directories(path); }
        ~Folder() { std::filesystem::remove_all(path); }
    };
    static const Folder folder;
    return folder.path;
}

inline std::filesystem::path write_job(const std::string& text) {
    const std::filesystem::path path = job_folder() / "job.toml";
    std::ofstream(path) << text;
    return path;
}

/// What reading the job says, empty if it is taken.
inline std::string refusal(const std::string& text) {
    try {
        read_job(write_job(text));
        return "";
    } catch (const ConfigError& error) {
        return error.what();
    }
}

inline bool has(const JobStep& step, const std::string& argument) {
    return std::find(step.arguments.begin(), step.arguments.end(), argument) !=
           step.arguments.end();
}

}  // namespace slim::test
