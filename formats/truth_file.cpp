#include "formats/truth_file.h"

#include "formats/extension.h"
#include "formats/message.h"
#include "slim/base/error.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace slim {

std::string truth_path(const std::string& cloud_path) {
    std::filesystem::path path(cloud_path);
    if (lower_extension(cloud_path) == ".gz") path.replace_extension();
    return path.replace_extension(".truth").string();
}

std::vector<PointTruth> read_truth(const std::string& path, std::uint64_t n_points) {
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(path, error);
    if (error) throw IoError(message(path, ": cannot be opened: ", error.message()));
    if (size / sizeof(PointTruth) != n_points || size % sizeof(PointTruth) != 0)
        throw FormatError(message(path, ": expected ", n_points, " points of ", sizeof(PointTruth),
                                  " bytes, found ", size, " bytes"));
    std::vector<PointTruth> truth(n_points);
    std::ifstream in(path, std::ios::binary);
    if (!in.read(reinterpret_cast<char*>(truth.data()), static_cast<std::streamsize>(size)))
        throw IoError(message(path, ": cannot be read: ", std::strerror(errno)));
    return truth;
}

}  // namespace slim
