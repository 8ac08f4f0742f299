#include "slim/normals/estimate.h"

#include "slim/base/parallel.h"
#include "slim/neighbors/knn.h"

#include <Eigen/Eigenvalues>

#include <atomic>

namespace slim {
namespace {

constexpr double kSpansPlane = 1e-10;  // middle / largest eigenvalue below which the points lie on a line

Eigen::Matrix3d covariance_of(const PointBlock& points, std::span<const std::uint32_t> ids) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    const auto at = [&](std::uint32_t i) {
        const Vec3d& p = points.position[i];
        return Eigen::Vector3d(p.x, p.y, p.z);
    };
    for (const std::uint32_t i : ids) mean += at(i);
    mean /= static_cast<double>(ids.size());
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (const std::uint32_t i : ids) covariance += (at(i) - mean) * (at(i) - mean).transpose();
    return covariance;
}

}  // namespace

NeighborGraph neighbor_graph(const PointBlock& points, std::size_t k) {
    NeighborGraph graph;
    std::vector<double> sq_distances;
    const KnnIndex index(points.position);
    graph.k = index.search(points.position, k, graph.neighbors, sq_distances);
    return graph;
}

void estimate_normals(PointBlock& points, const NeighborGraph& graph,
                      std::span<const std::uint32_t> wanted, std::size_t& degenerate) {
    std::atomic<std::size_t> flat_count{0};
    parallel_blocks(wanted.size(), 1024, [&](std::size_t begin, std::size_t end) {
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
        std::size_t lines = 0;
        for (std::size_t w = begin; w < end; ++w) {
            const std::uint32_t i = wanted[w];
            solver.compute(covariance_of(points, graph.of(i)));
            const Eigen::Vector3d values = solver.eigenvalues();
            if (!(values[1] > kSpansPlane * values[2])) ++lines;
            const Eigen::Vector3f n = solver.eigenvectors().col(0).cast<float>();
            points.normal[i] = normalized(Vec3f{n.x(), n.y(), n.z()});
        }
        flat_count += lines;
    });
    degenerate = flat_count;
}

}  // namespace slim
