#include "formats/truth_file.h"

#include "formats/extension.h"
#include "formats/message.h"
#include "slim/base/error.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>

namespace slim {

std::string truth_path(const std::string& cloud_path) {
    std::filesystem::path path(cloud_path);
    if (lower_extension(cloud_path) == ".gz") path.replace_extension();
    return path.replace_extension(".truth").string();
}

TruthReader::TruthReader(const std::string& path) : path_(path), in_(path, std::ios::binary) {
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(path, error);
    if (error || !in_)
        throw IoError(message(
            path, ": the truth cannot be read (", error ? error.message() : std::strerror(errno),
            "); expected a file of five doubles a point, nx ny nz k1 k2, as `slim scan` writes "
            "beside its cloud"));
    if (size % sizeof(PointTruth) != 0)
        throw FormatError(message(path, ": expected points of ", sizeof(PointTruth),
                                  " bytes, found ", size, " bytes"));
    n_points_ = size / sizeof(PointTruth);
}

void TruthReader::read(std::size_t n, const std::string& cloud, std::vector<PointTruth>& out) {
    if (n > n_left())
        throw FormatError(
            message(path_, ": holds ", n_points_, " points' truth, ", cloud, " has more points"));
    out.resize(n);
    if (!in_.read(reinterpret_cast<char*>(out.data()),
                  static_cast<std::streamsize>(n * sizeof(PointTruth))))
        throw IoError(message(path_, ": cannot be read: ", std::strerror(errno)));
    n_read_ += n;
}

void check_truth(std::span<const PointTruth> truth, std::uint64_t first, const std::string& path) {
    // Normals that were floats are off by 1e-7; an apex has none.
    constexpr double kUnitWithin = 1e-3;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const PointTruth& t = truth[i];
        const double sq = dot(t.normal, t.normal);
        const bool has_normal = sq == 0 || std::abs(sq - 1) < 2 * kUnitWithin;
        if (has_normal && std::isfinite(t.k1) && std::isfinite(t.k2)) continue;
        throw FormatError(message(
            path, ": row ", first + i, ": expected a normal of unit length and finite k1, k2 ",
            "(five little-endian doubles a point, nx ny nz k1 k2), found ", t.normal.x, " ",
            t.normal.y, " ", t.normal.z, " ", t.k1, " ", t.k2));
    }
}

std::vector<PointTruth> read_truth(const std::string& path, std::uint64_t n_points) {
    TruthReader reader(path);
    if (reader.n_points() != n_points)
        throw FormatError(message(path, ": expected ", n_points, " points of ", sizeof(PointTruth),
                                  " bytes, found ", reader.n_points() * sizeof(PointTruth),
                                  " bytes"));
    std::vector<PointTruth> truth;
    reader.read(n_points, path, truth);
    return truth;
}

}  // namespace slim
