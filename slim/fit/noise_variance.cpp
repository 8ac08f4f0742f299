#include "slim/fit/noise_variance.h"

#include "slim/base/parallel.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <vector>

namespace slim {
namespace {

constexpr std::size_t kGrain = 1024;

/// Sums over one block of samples; blocks are added in order, so threads do not matter.
struct Partial {
    double smallest = 0, flatness = 0;
    std::size_t n = 0, n_short = 0;
};

/// Eigenvalues of the covariance of the first k distinct places among the neighbours, rising, if there are at
/// least three. Returns the number of places.
std::size_t spread(std::span<const Vec3d> points, std::span<const std::uint32_t> found,
                   std::size_t k, Eigen::Vector3d& eigenvalues) {
    std::vector<Eigen::Vector3d> distinct;
    for (const std::uint32_t i : found) {
        const Eigen::Vector3d p(points[i].x, points[i].y, points[i].z);
        if (std::find(distinct.begin(), distinct.end(), p) != distinct.end()) continue;
        distinct.push_back(p);
        if (distinct.size() == k) break;
    }
    if (distinct.size() < 3) return distinct.size();
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
    return distinct.size();
}

/// The mean over the samples, and how many of them have fewer than k distinct places among the neighbours
/// that were asked for.
struct Measured {
    NoiseVariance noise;
    std::size_t n_short = 0;
};

Measured with_neighbors(const KnnIndex& index, std::span<const Vec3d> points,
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
            const std::size_t places = spread(points, {found.data() + i * asked, asked}, k, e);
            sum.n_short += places < k ? 1u : 0u;
            if (places < 3) continue;
            sum.smallest += e[0];
            sum.flatness += e[1] > 0 ? e[0] / e[1] : 0;
            ++sum.n;
        }
    });
    Measured measured;
    NoiseVariance& out = measured.noise;
    out.neighbors = k;
    for (const Partial& p : partial) {
        out.value += p.smallest;
        out.flatness += p.flatness;
        out.n_sampled += p.n;
        measured.n_short += p.n_short;
    }
    if (out.n_sampled > 0) {
        out.value /= static_cast<double>(out.n_sampled);
        out.flatness /= static_cast<double>(out.n_sampled);
    }
    return measured;
}

std::vector<Vec3d> distinct_places(std::span<const Vec3d> points) {
    std::vector<Vec3d> places(points.begin(), points.end());
    std::sort(places.begin(), places.end(), [](const Vec3d& a, const Vec3d& b) {
        return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    });
    places.erase(std::unique(places.begin(), places.end()), places.end());
    return places;
}

/// The first k whose neighbourhoods are flat, which shows on a tenth of the samples.
std::size_t flat_neighbors(const KnnIndex& index, std::span<const Vec3d> points,
                           std::span<const Vec3d> samples) {
    for (const std::size_t k : kNoiseNeighbors) {
        const std::size_t n = std::max<std::size_t>(samples.size() / k, 1000);
        const auto some = samples.first(std::min(samples.size(), n));
        if (k >= points.size() || with_neighbors(index, points, some, k).noise.flatness <= kFlat)
            return k;
    }
    return std::end(kNoiseNeighbors)[-1];
}

/// A mean over fewer samples the more neighbours each has: the cost does not grow with k.
/// False if duplicates left more than 1 % of the samples short of neighbours.
bool estimate(const KnnIndex& index, std::span<const Vec3d> points, std::span<const Vec3d> samples,
              std::size_t k, NoiseVariance& out) {
    if (k == 0) k = flat_neighbors(index, points, samples);
    const std::size_t n =
        std::min(samples.size(), std::max<std::size_t>(samples.size() * 10 / k, 1000));
    const Measured measured = with_neighbors(index, points, samples.first(n), k);
    out = measured.noise;
    return measured.n_short * 100 <= n || 2 * k + 1 >= points.size();
}

}  // namespace

NoiseVariance estimate_noise_variance(const KnnIndex& index, std::span<const Vec3d> points,
                                      std::span<const Vec3d> samples, std::size_t neighbors) {
    NoiseVariance out;
    if (estimate(index, points, samples, neighbors, out)) return out;
    const std::vector<Vec3d> places = distinct_places(points);
    estimate(KnnIndex(places), places, samples, neighbors, out);
    return out;
}

}  // namespace slim
