#include "slim/fit/noise_variance.h"

#include "slim/base/parallel.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <vector>

namespace slim {
namespace {

constexpr double kFlat = 0.1;
constexpr std::size_t kMostNeighbors = 160;
constexpr std::size_t kGrain = 1024;

/// Sums over one block of samples; blocks are added in order, so threads do not matter.
struct Partial {
    double smallest = 0, flatness = 0;
    std::size_t n = 0;
};

/// Eigenvalues of the covariance of the first k distinct places among the neighbours, rising; false if fewer
/// than three.
bool spread(std::span<const Vec3d> points, std::span<const std::uint32_t> found, std::size_t k,
            Eigen::Vector3d& eigenvalues) {
    std::vector<Eigen::Vector3d> distinct;
    for (const std::uint32_t i : found) {
        const Eigen::Vector3d p(points[i].x, points[i].y, points[i].z);
        if (std::find(distinct.begin(), distinct.end(), p) != distinct.end()) continue;
        distinct.push_back(p);
        if (distinct.size() == k) break;
    }
    if (distinct.size() < 3) return false;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& p : distinct) mean += p;
    mean /= static_cast<double>(distinct.size());
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (const auto& p : distinct) covariance += (p - mean) * (p - mean).transpose();
    covariance /= static_cast<double>(distinct.size());
    eigenvalues =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance, Eigen::EigenvaluesOnly)
            .eigenvalues()
            .cwiseMax(0);
    return true;
}

NoiseVariance with_neighbors(const KnnIndex& index, std::span<const Vec3d> points,
                             std::span<const Vec3d> samples, std::size_t k) {
    std::vector<std::uint32_t> found;
    std::vector<double> sq_distances;
    // Duplicates eat neighbours: ask for more, so that k distinct ones are left in all but odd data.
    const std::size_t asked = index.search(samples, k + std::max<std::size_t>(k / 4, 10), found,
                                           sq_distances);
    std::vector<Partial> partial((samples.size() + kGrain - 1) / kGrain);
    parallel_blocks(samples.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        Partial& sum = partial[begin / kGrain];
        for (std::size_t i = begin; i < end; ++i) {
            Eigen::Vector3d e;
            if (!spread(points, {found.data() + i * asked, asked}, k, e)) continue;
            sum.smallest += e[0];
            sum.flatness += e[1] > 0 ? e[0] / e[1] : 0;
            ++sum.n;
        }
    });
    NoiseVariance out;
    out.neighbors = k;
    for (const Partial& p : partial) {
        out.value += p.smallest;
        out.flatness += p.flatness;
        out.n_sampled += p.n;
    }
    if (out.n_sampled > 0) {
        out.value /= static_cast<double>(out.n_sampled);
        out.flatness /= static_cast<double>(out.n_sampled);
    }
    return out;
}

}  // namespace

NoiseVariance estimate_noise_variance(const KnnIndex& index, std::span<const Vec3d> points,
                                      std::span<const Vec3d> samples, bool automatic) {
    // Whether k is large enough shows on a tenth of the samples; a mean over more neighbours each needs
    // fewer samples, so that the cost does not grow with k.
    const auto first = [&](std::size_t n) {
        return samples.first(std::min(samples.size(), std::max<std::size_t>(n, 1000)));
    };
    std::size_t k = 10;
    while (automatic && k < kMostNeighbors && k < points.size() &&
           with_neighbors(index, points, first(samples.size() / k), k).flatness > kFlat)
        k *= 2;
    return with_neighbors(index, points, first(samples.size() * 10 / k), k);
}

}  // namespace slim
