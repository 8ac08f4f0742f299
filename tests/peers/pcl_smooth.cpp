// Moving least squares of the Point Cloud Library, for the benchmarks.
//   peer_pcl_smooth in out.ply RADIUS [ORDER] [THREADS]
// in: binary PLY or text (x y z first). RADIUS in the unit of the points, its square is the
// Gaussian's (PCL's default); ORDER of the polynomial, 2 unless given; THREADS 2. Writes doubles,
// in the order of the input; PCL itself computes in float, about the centre of the bounding box
// here. Points that PCL leaves out (fewer than 3 neighbours) stay where they are and are counted.
// One JSON object on stdout.
#include "tests/peers/plain_points.h"

#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/surface/mls.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <string>

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Mls = pcl::MovingLeastSquares<pcl::PointXYZ, pcl::PointXYZ>;

struct Options {
    double radius = 0;
    int order = 2;
    unsigned threads = 2;
};

std::array<double, 3> middle_of(const peers::Positions& points) {
    auto low = points.front(), high = low;
    for (const auto& p : points)
        for (std::size_t i = 0; i < 3; ++i)
            low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
    return {(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2};
}

/// Returns how many points PCL gave a new place.
std::size_t smooth(peers::Positions& points, const Options& options) {
    const auto middle = middle_of(points);
    Cloud::Ptr cloud(new Cloud);
    for (const auto& p : points)
        cloud->emplace_back(float(p[0] - middle[0]), float(p[1] - middle[1]),
                            float(p[2] - middle[2]));
    Mls mls;
    mls.setInputCloud(cloud);
    mls.setSearchMethod(
        pcl::search::KdTree<pcl::PointXYZ>::Ptr(new pcl::search::KdTree<pcl::PointXYZ>));
    mls.setSearchRadius(options.radius);
    mls.setPolynomialOrder(options.order);
    mls.setComputeNormals(false);
    mls.setNumberOfThreads(options.threads);
    Cloud smoothed;
    mls.process(smoothed);
    const auto& from = mls.getCorrespondingIndices()->indices;
    for (std::size_t i = 0; i < smoothed.size(); ++i) {
        auto& to = points[std::size_t(from[i])];
        to = {smoothed[i].x + middle[0], smoothed[i].y + middle[1], smoothed[i].z + middle[2]};
    }
    return smoothed.size();
}

int run(int argc, char** argv) {
    Options options;
    options.radius = std::stod(argv[3]);
    if (argc > 4) options.order = std::stoi(argv[4]);
    if (argc > 5) options.threads = unsigned(std::stoul(argv[5]));
    auto points = peers::read_positions(argv[1]);
    if (points.empty() || !(options.radius > 0))
        return std::fprintf(stderr, "%s: no points, or no radius above 0\n", argv[1]), 3;
    const auto start = std::chrono::steady_clock::now();
    const std::size_t moved = smooth(points, options);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    if (!peers::write_positions(argv[2], points)) return 4;
    std::printf(
        "{\"method\": \"pcl_mls\", \"points\": %zu, \"left_out\": %zu, \"method_seconds\": %.6f}\n",
        points.size(), points.size() - moved, seconds.count());
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 4) {
        std::fprintf(stderr, "usage: peer_pcl_smooth in out.ply RADIUS [ORDER] [THREADS]\n");
        return 2;
    }
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 3;
    }
}
