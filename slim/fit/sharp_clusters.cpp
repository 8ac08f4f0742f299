#include "slim/fit/sharp_clusters.h"

#include "slim/fit/double_lanes.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace slim {
namespace {

constexpr double kClosest = 0.866;     // cos of the least angle between two clusters
constexpr double kClosestFlat = 0.9945;  // the same, 6 degrees, of clusters of faces
/// Mean of 1 - cos of a cluster's normals to its own over 1 - cos between two clusters: up to it
/// they are the normals of flat faces.
constexpr double kFlat = 0.01;
constexpr std::size_t kLeastMembers = 3;  // a plane's worth
constexpr double kLeastShare = 0.04;
constexpr int kRounds = 4;
constexpr double kSpreadWithin2 = 0.4,
                 kSpreadWithin3 = 0.24;  // shares of the spread left in 2, 3 groups
constexpr double kLeastSpreadOfFaces = 0.001;  // 6 degrees through the middle of a ball
constexpr std::size_t kJudged = 48;

/// The normal whose largest cosine to any of the first `k` normals is smallest, of every
/// `stride`-th point.
template <class T>
Vec3d farthest(const BallPoints<T>& p, const std::array<Vec3d, kMostSheets>& from, std::size_t k,
               std::size_t stride) {
    Vec3d best;
    double least = 2;
    for (std::size_t i = 0; i < p.n; i += stride) {
        const Vec3d n = p.normal(i);
        if (!(sq_length(n) > 0)) continue;
        double nearest = -1;
        for (std::size_t c = 0; c < k; ++c) nearest = std::max(nearest, dot(n, from[c]));
        if (nearest < least) least = nearest, best = n;
    }
    return best;
}

template <class T>
void seed(const BallPoints<T>& p, std::size_t k, std::array<Vec3d, kMostSheets>& normal,
          std::size_t stride = 1) {
    Vec3d sum;
    for (std::size_t i = 0; i < p.n; i += stride) sum += p.normal(i);
    normal[0] = normalized(sum);
    normal[0] = farthest(p, normal, 1, stride);
    for (std::size_t c = 1; c < k; ++c) normal[c] = farthest(p, normal, c, stride);
}

/// normal_spread of every `stride`-th point within its group, after k-means into k groups.
template <class T>
double spread_within(const BallPoints<T>& p, std::size_t k, std::size_t stride) {
    std::array<Vec3d, kMostSheets> normal{};
    seed(p, k, normal, stride);
    double n = 0, along = 0;
    for (int round = 0; round < 3; ++round) {
        std::array<Vec3d, kMostSheets> sum{};
        n = 0, along = 0;
        for (std::size_t i = 0; i < p.n; i += stride) {
            const Vec3d x = p.normal(i);
            std::size_t best = 0;
            for (std::size_t c = 1; c < k; ++c)
                if (dot(x, normal[c]) > dot(x, normal[best])) best = c;
            sum[best] += x;
            n += sq_length(x);
        }
        for (std::size_t c = 0; c < k; ++c) {
            along += length(sum[c]);
            if (sq_length(sum[c]) > 0) normal[c] = normalized(sum[c]);
        }
    }
    return n > 0 ? 1 - along / n : 0;
}

/// The nearest cluster of each point, by its bit; 0 where a normal is missing, or not clearly that
/// cluster's: nearer to another by less than kAmbiguous of what lies between the two.
template <class T>
void assign_clusters(const BallPoints<T>& p, const std::array<Vec3d, kMostSheets>& normal,
                     std::size_t k, std::vector<std::uint8_t>& member) {
    std::array<std::array<double, kMostSheets>, kMostSheets> margin{};
    for (std::size_t a = 0; a < k; ++a)
        for (std::size_t b = 0; b < k; ++b)
            margin[a][b] = kAmbiguous * (1 - dot(normal[b], normal[a]));
    for (std::size_t first = 0; first < p.n; first += DoubleLanes::size()) {
        const DoubleLanes x = double_lanes_at(p.nx, first), y = double_lanes_at(p.ny, first),
                          z = double_lanes_at(p.nz, first);
        std::array<DoubleLanes, kMostSheets> along;
        DoubleLanes most = -INFINITY, best = 0;
        for (std::size_t c = 0; c < k; ++c) {
            along[c] = x * normal[c].x + y * normal[c].y + z * normal[c].z;
            const auto nearer = along[c] > most;
            stdx::where(nearer, most) = along[c];
            stdx::where(nearer, best) = static_cast<double>(c);
        }
        auto clear = x * x + y * y + z * z > 0.0;
        for (std::size_t a = 0; a < k; ++a) {
            const auto is_other = best != static_cast<double>(a);
            for (std::size_t b = 0; b < k; ++b)
                if (b != a) clear = clear && (is_other || most - along[b] >= margin[a][b]);
        }
        const std::uint64_t bits = lane_bits(clear);
        std::array<double, DoubleLanes::size()> nearest;
        best.copy_to(nearest.data(), stdx::element_aligned);
        for (std::size_t lane = 0; lane < DoubleLanes::size(); ++lane)
            member[first + lane] = static_cast<std::uint8_t>(
                (bits >> lane & 1) << static_cast<unsigned>(nearest[lane]));
    }
}

}  // namespace

template <class T>
double normal_spread(const BallPoints<T>& p) {
    float x = 0, y = 0, z = 0, n = 0;
    for (std::size_t i = 0; i < p.n; ++i) {
        x += p.nx[i], y += p.ny[i], z += p.nz[i];
        n += p.nx[i] * p.nx[i] + p.ny[i] * p.ny[i] + p.nz[i] * p.nz[i];
    }
    const double sum = std::sqrt(static_cast<double>(x * x + y * y + z * z));
    return n > 0 ? 1 - sum / static_cast<double>(n) : 0;
}

template <class T>
bool shows_edge(const BallPoints<T>& p, double share) {
    const double spread = normal_spread(p), most = share * spread;
    if (spread < kLeastSpread) return false;
    const std::size_t stride = std::max<std::size_t>(1, p.n / kJudged);
    return spread_within(p, 2, stride) < kSpreadWithin2 * most ||
           spread_within(p, 3, stride) < kSpreadWithin3 * most;
}

template <class T>
bool shows_faces(const BallPoints<T>& p) {
    const double spread = normal_spread(p);
    if (spread < kLeastSpreadOfFaces) return false;
    const std::size_t stride = std::max<std::size_t>(1, p.n / kJudged);
    for (std::size_t k = 2; k <= kMostSheets; ++k)
        if (spread_within(p, k, stride) < kFlat * spread) return true;
    return false;
}

template <class T>
bool cluster_normals(const BallPoints<T>& p, std::size_t k, NormalClusters& clusters,
                     std::vector<std::uint8_t>& member) {
    auto& normal = clusters.normal;
    seed(p, k, normal);
    if (member.size() < p.padded()) member.resize(2 * p.padded());
    std::array<std::size_t, kMostSheets> count{};
    std::array<double, kMostSheets> off{};
    for (int round = 0; round < kRounds; ++round) {
        assign_clusters(p, normal, k, member);
        std::array<Vec3d, kMostSheets> sum{};
        count = {};
        for (std::size_t i = 0; i < p.n; ++i) {
            if (member[i] == 0) continue;
            const auto c = static_cast<std::size_t>(std::countr_zero(member[i]));
            sum[c] += p.normal(i);
            ++count[c];
        }
        bool moved = false;
        for (std::size_t c = 0; c < k; ++c) {
            if (!(sq_length(sum[c]) > 0)) continue;
            const Vec3d mean = normalized(sum[c]);
            moved |= mean != normal[c];
            normal[c] = mean;
            off[c] = 1 - length(sum[c]) / static_cast<double>(count[c]);
        }
        if (!moved) break;  // what further rounds would find as well
    }
    const auto least = std::max(kLeastMembers, static_cast<std::size_t>(kLeastShare *
                                                                        static_cast<double>(p.n)));
    for (std::size_t a = 0; a < k; ++a) {
        if (count[a] < least) return false;
        for (std::size_t b = 0; b < a; ++b) {
            const double cosine = dot(normal[a], normal[b]);
            const bool are_flat = std::max(off[a], off[b]) < kFlat * (1 - cosine);
            if (cosine > (are_flat ? kClosestFlat : kClosest)) return false;
            if (k > kUsualSheets && !are_flat) return false;
        }
    }
    return true;
}

template double normal_spread(const BallPoints<float>&);
template double normal_spread(const BallPoints<double>&);
template bool shows_edge(const BallPoints<float>&, double);
template bool shows_edge(const BallPoints<double>&, double);
template bool shows_faces(const BallPoints<float>&);
template bool shows_faces(const BallPoints<double>&);
template bool cluster_normals(const BallPoints<float>&, std::size_t, NormalClusters&,
                              std::vector<std::uint8_t>&);
template bool cluster_normals(const BallPoints<double>&, std::size_t, NormalClusters&,
                              std::vector<std::uint8_t>&);

}  // namespace slim
