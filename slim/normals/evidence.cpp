#include "slim/normals/evidence.h"

#include "slim/normals/covariance.h"
#include "slim/normals/outside.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace slim {
namespace {

constexpr std::size_t kFewestNeighbors = 16;
// Variances of neighbours of a plane: across it over along it, and along its two directions (scan
// lines are none).
constexpr double kFlat = 1.0 / 16, kWide = 1.0 / 4;
constexpr double kOff = 0.7071;            // cosine
constexpr std::size_t kFewestFlat = 50;
constexpr double kFewestFlatShare = 0.1;   // in thick noise, by chance, one in a hundred is flat
constexpr double kManyOff = 0.15;
constexpr double kSure = 4;                // standard deviations
constexpr double kMostArea = 100;          // medians: what stands for more is a stray far off

/// What one point adds.
NormalEvidence evidence_of_one(const PointBlock& points, std::uint32_t i,
                               std::span<const std::uint32_t> neighbors) {
    NormalEvidence one;
    const Vec3d p = points.position[i], normal = to_double(points.normal[i]);
    if (!(sq_length(normal) > 0)) return one;
    one.n = 1;
    one.area = sq_reach_of(points.position, i, neighbors);
    one.sq_size = one.area * sq_length(p);
    one.flux = one.area * dot(p, normal);
    one.moment = one.area * p;
    one.area_vector = one.area * normal;
    one.sq_flux = one.flux * one.flux;
    one.flux_normals = one.flux * one.area_vector;
    const Vec3d& a = one.area_vector;
    one.normal_squares = {a.x * a.x, a.x * a.y, a.x * a.z, a.y * a.y, a.y * a.z, a.z * a.z};
    const Spread spread = spread_of(points.position, neighbors);
    if (neighbors.size() < kFewestNeighbors || !(spread.middle > kWide * spread.largest) ||
        spread.smallest > kFlat * spread.middle)
        return one;
    one.n_flat = 1;
    one.n_off = std::abs(dot(normal, spread.normal)) < kOff ? 1 : 0;
    return one;
}

/// Leaves strays far off out of what is weighted by area: they would be all of it.
void pass_over_strays(std::vector<NormalEvidence>& each) {
    if (each.empty()) return;
    std::vector<double> areas;
    for (const NormalEvidence& one : each) areas.push_back(one.area);
    const auto middle = areas.begin() + static_cast<std::ptrdiff_t>(areas.size() / 2);
    std::nth_element(areas.begin(), middle, areas.end());
    for (NormalEvidence& one : each)
        if (one.area > kMostArea * *middle) one = {one.n, one.n_flat, one.n_off};
}

}  // namespace

NormalEvidence& NormalEvidence::operator+=(const NormalEvidence& o) {
    n += o.n, n_flat += o.n_flat, n_off += o.n_off;
    area += o.area, sq_size += o.sq_size, flux += o.flux;
    moment += o.moment, area_vector += o.area_vector;
    sq_flux += o.sq_flux, flux_normals += o.flux_normals;
    for (std::size_t i = 0; i < normal_squares.size(); ++i)
        normal_squares[i] += o.normal_squares[i];
    return *this;
}

void NormalEvidence::stand_for(std::size_t n_points) {
    if (n == 0) return;
    const double each = static_cast<double>(n_points) / static_cast<double>(n);
    area *= each, sq_size *= each, flux *= each;
    moment *= each, area_vector *= each;
    sq_flux *= each * each, flux_normals *= each * each;
    for (double& square : normal_squares) square *= each * each;
}

bool NormalEvidence::is_off_surface() const {
    const auto flat = static_cast<double>(n_flat);
    return n_flat >= kFewestFlat && flat > kFewestFlatShare * static_cast<double>(n) &&
           static_cast<double>(n_off) > kManyOff * flat;
}

/// Standard deviation of the flux about a centre, as the samples lie by chance.
double NormalEvidence::flux_chance(const Vec3d& c) const {
    const auto& [xx, xy, xz, yy, yz, zz] = normal_squares;
    const double of_center = c.x * (xx * c.x + 2 * xy * c.y + 2 * xz * c.z) +
                             c.y * (yy * c.y + 2 * yz * c.z) + zz * c.z * c.z;
    return std::sqrt(std::max(0.0, sq_flux - 2 * dot(c, flux_normals) + of_center));
}

bool NormalEvidence::is_inward() const {
    if (!(area > 0)) return false;
    const Vec3d center = moment / area;
    const double size = std::sqrt(std::max(0.0, sq_size / area - sq_length(center)));
    const double inside =
        (dot(center, area_vector) - flux) / area;    // three times the volume over the area
    const double hole = length(area_vector) / area;  // of a hemisphere 0.5
    const bool is_sure = inside > hole * size && inside * area > kSure * flux_chance(center);
    return hole < kSmallHole && (inside > kClearFlux * size || is_sure);
}

NormalEvidence evidence_of(const PointBlock& points, const NearestSearch& search,
                           std::span<const std::uint32_t> samples, std::size_t n_neighbors) {
    std::vector<std::uint32_t> wanted(samples.begin(), samples.end());
    std::sort(wanted.begin(), wanted.end());
    std::erase_if(wanted, [&](std::uint32_t i) { return search.is_repeat(i); });
    std::vector<NormalEvidence> each(wanted.size());
    search.for_each(wanted, n_neighbors,
                    [&](std::size_t w, std::span<const std::uint32_t> neighbors) {
                        each[w] = evidence_of_one(points, wanted[w], neighbors);
                    });
    pass_over_strays(each);
    NormalEvidence sum;
    for (const NormalEvidence& one : each) sum += one;
    return sum;
}

}  // namespace slim
