#pragma once

#include "pipeline/job.h"
#include "slim/base/error.h"

#include <gtest/gtest.h>

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

inline std::filesystem::path write_job(const std::string& text) {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "job.toml";
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
