#pragma once

#include "formats/point_source.h"
#include "slim/base/error.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <unistd.h>

namespace slim::test {

/// A folder of its own for one test, gone afterwards.
class TempFolder {
public:
    TempFolder() {
        const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
        path_ = std::filesystem::temp_directory_path() /
                ("slim_" + std::to_string(::getpid()) + "_" + test->test_suite_name() + "_" +
                 test->name());
        std::filesystem::create_directories(path_);
    }
    ~TempFolder() { std::filesystem::remove_all(path_); }
    TempFolder(const TempFolder&) = delete;
    TempFolder& operator=(const TempFolder&) = delete;

    std::string file(const std::string& name) const { return (path_ / name).string(); }
    std::string write(const std::string& name, const std::string& bytes) const {
        // Truncating an old file instead would make some file systems wait for the disk.
        std::filesystem::remove(file(name));
        std::ofstream(file(name), std::ios::binary) << bytes;
        return file(name);
    }
    std::size_t n_files() const {
        return static_cast<std::size_t>(
            std::distance(std::filesystem::directory_iterator(path_), {}));
    }

private:
    std::filesystem::path path_;
};

inline std::string read_bytes(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// All points of a cloud, read in chunks of the given size.
inline PointChunk read_all(const std::string& path, std::size_t chunk_points = 7) {
    const auto source = open_cloud(path);
    PointChunk all, chunk;
    while (source->read(chunk, chunk_points)) {
        all.position.insert(all.position.end(), chunk.position.begin(), chunk.position.end());
        all.normal.insert(all.normal.end(), chunk.normal.begin(), chunk.normal.end());
        all.scan.insert(all.scan.end(), chunk.scan.begin(), chunk.scan.end());
    }
    return all;
}

/// The message of the slim::Error that reading the cloud ends with; empty if it can be read.
inline std::string reading_error(const std::string& path) {
    try {
        read_all(path);
        return {};
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::bad_data) << error.what();
        return error.what();
    }
}

/// The shared test data: $SLIM_SHARED/data, else beside the source; empty if absent.
inline std::filesystem::path shared_data() {
    const char* shared = std::getenv("SLIM_SHARED");
    const std::filesystem::path root =
        shared ? shared : std::filesystem::path(SLIM_SOURCE_DIR) / ".." / "shared";
    return std::filesystem::is_directory(root / "data") ? root / "data" : std::filesystem::path();
}

}  // namespace slim::test
