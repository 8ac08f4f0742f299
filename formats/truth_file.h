#pragma once

#include "formats/atomic_file.h"
#include "slim/base/vec.h"

#include <cstdint>
#include <fstream>
#include <span>
#include <string>
#include <vector>

namespace slim {

/// What an analytic surface knows exactly at the foot of a point.
struct PointTruth {
    Vec3d normal;   ///< outwards, unit length
    double k1 = 0;  ///< larger principal curvature, 1/length, positive where convex
    double k2 = 0;
};
static_assert(sizeof(PointTruth) == 40);

/// cloud.ply -> cloud.truth, beside it (`.gz` is dropped first).
std::string truth_path(const std::string& cloud_path);

/// Writes `cloud.truth`: no header, five little-endian doubles nx ny nz k1 k2 a point, in file
/// order.
class TruthWriter {
public:
    explicit TruthWriter(const std::string& path) : file_(path) {}
    void write(std::span<const PointTruth> truth) { file_.write(truth.data(), truth.size_bytes()); }
    void commit() { file_.commit(); }

private:
    AtomicFile file_;
};

/// Reads a truth file from its first point to its last, a part at a time.
class TruthReader {
public:
    /// throws IoError if it cannot be opened; FormatError if it does not hold whole points of 40
    ///        bytes
    explicit TruthReader(const std::string& path);
    std::uint64_t n_points() const { return n_points_; }
    std::uint64_t n_left() const { return n_points_ - n_read_; }
    /// The next n points. throws FormatError naming the cloud where fewer are left; IoError
    void read(std::size_t n, const std::string& cloud, std::vector<PointTruth>& out);

private:
    std::string path_;
    std::ifstream in_;
    std::uint64_t n_points_ = 0, n_read_ = 0;
};

/// throws FormatError naming file, row (from 0) and what was found, for a normal that is neither of
/// unit length nor zero (an apex has none), or a curvature that is not finite. first: the number of
/// truth[0] in the file
void check_truth(std::span<const PointTruth> truth, std::uint64_t first, const std::string& path);

/// throws FormatError if the file does not hold exactly n_points (40 bytes each); IoError
std::vector<PointTruth> read_truth(const std::string& path, std::uint64_t n_points);

}  // namespace slim
