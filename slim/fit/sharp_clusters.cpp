#include "slim/fit/sharp_clusters.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr double kClosest = 0.866;     // cos of the least angle between two clusters
constexpr std::size_t kLeastMembers = 6;  // a plane's worth
constexpr double kLeastShare = 0.04;
constexpr int kRounds = 4;

template <class T>
Vec3d normal_of(const BallPoints<T>& p, std::size_t i) {
    return {p.nx[i], p.ny[i], p.nz[i]};
}

/// The normal whose largest cosine to any of the first `k` normals is smallest.
template <class T>
Vec3d farthest(const BallPoints<T>& p, const std::array<Vec3d, kMostSheets>& from, std::size_t k) {
    Vec3d best;
    double least = 2;
    for (std::size_t i = 0; i < p.n; ++i) {
        const Vec3d n = normal_of(p, i);
        if (!(sq_length(n) > 0)) continue;
        double nearest = -1;
        for (std::size_t c = 0; c < k; ++c) nearest = std::max(nearest, dot(n, from[c]));
        if (nearest < least) least = nearest, best = n;
    }
    return best;
}

template <class T>
void seed(const BallPoints<T>& p, std::size_t k, std::array<Vec3d, kMostSheets>& normal) {
    Vec3d sum;
    for (std::size_t i = 0; i < p.n; ++i) sum += normal_of(p, i);
    normal[0] = normalized(sum);
    normal[0] = farthest(p, normal, 1);
    for (std::size_t c = 1; c < k; ++c) normal[c] = farthest(p, normal, c);
}

/// Bit of the cluster that a normal clearly belongs to, or 0.
unsigned cluster_of(const Vec3d& n, const std::array<Vec3d, kMostSheets>& normal, std::size_t k) {
    if (!(sq_length(n) > 0)) return 0;
    std::size_t best = 0;
    for (std::size_t c = 1; c < k; ++c)
        if (dot(n, normal[c]) > dot(n, normal[best])) best = c;
    for (std::size_t c = 0; c < k; ++c) {
        const double apart = 1 - dot(normal[c], normal[best]);
        if (c != best && dot(n, normal[best]) - dot(n, normal[c]) < kAmbiguous * apart) return 0;
    }
    return 1u << best;
}

}  // namespace

template <class T>
bool cluster_normals(const BallPoints<T>& p, std::size_t k, NormalClusters& clusters,
                     std::vector<std::uint8_t>& member) {
    auto& normal = clusters.normal;
    seed(p, k, normal);
    if (member.size() < p.n) member.resize(2 * p.n);
    std::array<std::size_t, kMostSheets> count{};
    for (int round = 0; round < kRounds; ++round) {
        std::array<Vec3d, kMostSheets> sum{};
        count = {};
        for (std::size_t i = 0; i < p.n; ++i) {
            const Vec3d n = normal_of(p, i);
            const unsigned bit = cluster_of(n, normal, k);
            member[i] = static_cast<std::uint8_t>(bit);
            for (std::size_t c = 0; c < k; ++c) {
                if (!(bit & 1u << c)) continue;
                sum[c] += n;
                ++count[c];
            }
        }
        for (std::size_t c = 0; c < k; ++c)
            if (sq_length(sum[c]) > 0) normal[c] = normalized(sum[c]);
    }
    const auto least = std::max(kLeastMembers, static_cast<std::size_t>(kLeastShare *
                                                                        static_cast<double>(p.n)));
    for (std::size_t a = 0; a < k; ++a) {
        if (count[a] < least) return false;
        for (std::size_t b = 0; b < a; ++b)
            if (dot(normal[a], normal[b]) > kClosest) return false;
    }
    return true;
}

template bool cluster_normals(const BallPoints<float>&, std::size_t, NormalClusters&,
                              std::vector<std::uint8_t>&);
template bool cluster_normals(const BallPoints<double>&, std::size_t, NormalClusters&,
                              std::vector<std::uint8_t>&);

}  // namespace slim
