#include "slim/edges/edge_leaf.h"

#include <cmath>

namespace slim {
namespace {

constexpr int kSteps = 8;
constexpr double kSmallStep = 1e-10, kFarOff = 1.5;
// of a least sum of squares, which is reached more slowly where sheets do not meet in a point
constexpr double kSmallStepOfSum = 1e-4;
constexpr double kLeastVolume = 0.01;  // of the box of three unit normals

/// The vector d with rows[k] . d = b[k]; nothing where the rows nearly lie in a plane.
std::optional<Vec3d> solved(const std::array<Vec3d, 3>& rows, const Vec3d& b, double least) {
    const Vec3d c0 = cross(rows[1], rows[2]), c1 = cross(rows[2], rows[0]),
                c2 = cross(rows[0], rows[1]);
    const double volume = dot(rows[0], c0);
    if (!(std::abs(volume) > least * length(rows[0]) * length(rows[1]) * length(rows[2])))
        return std::nullopt;
    return (c0 * b.x + c1 * b.y + c2 * b.z) * (1 / volume);
}

/// Newton's step from x to where the three sheets are 0.
std::optional<Vec3d> step_of_three(const Surfel& s, const Vec3d& x) {
    const Vec3d values{s.sheet_value(0, x), s.sheet_value(1, x), s.sheet_value(2, x)};
    return solved({s.sheet_gradient(0, x), s.sheet_gradient(1, x), s.sheet_gradient(2, x)},
                  values * -1.0, kLeastVolume);
}

/// Gauss and Newton's step to where the sum of all squared sheets is least.
std::optional<Vec3d> step_of_all(const Surfel& s, const Vec3d& x) {
    std::array<Vec3d, 3> rows{};
    Vec3d b;
    for (std::size_t k = 0; k < s.n_sheets(); ++k) {
        const Vec3d g = s.sheet_gradient(k, x);
        rows[0] += g * g.x, rows[1] += g * g.y, rows[2] += g * g.z;
        b += g * -s.sheet_value(k, x);
    }
    return solved(rows, b, kLeastVolume * kLeastVolume);
}

}  // namespace

std::optional<Vec3d> nearest_on_edge(const Surfel& s, const SheetPair& pair, Vec3d x) {
    constexpr double kLeastSqSine = 0.01;
    for (int step = 0; step < kSteps; ++step) {
        const Vec3d ga = s.sheet_gradient(pair.a, x), gb = s.sheet_gradient(pair.b, x);
        const double fa = s.sheet_value(pair.a, x), fb = s.sheet_value(pair.b, x);
        // The step d = p ga + q gb with ga . d = -fa, gb . d = -fb.
        const double aa = sq_length(ga), ab = dot(ga, gb), bb = sq_length(gb),
                     det = aa * bb - ab * ab;
        if (!(det > kLeastSqSine * aa * bb)) return std::nullopt;
        const Vec3d d = ga * ((ab * fb - bb * fa) / det) + gb * ((ab * fa - aa * fb) / det);
        x += d;
        if (!(sq_length(x) < kFarOff * kFarOff)) return std::nullopt;
        if (sq_length(d) < kSmallStep * kSmallStep) return x;
    }
    return std::nullopt;
}

std::optional<Vec3d> corner_of(const Surfel& s) {
    Vec3d x;
    const bool is_of_three = s.n_sheets() == 3;
    const double small = is_of_three ? kSmallStep : kSmallStepOfSum;
    for (int step = 0; step < kSteps; ++step) {
        const auto d = is_of_three ? step_of_three(s, x) : step_of_all(s, x);
        if (!d) return std::nullopt;
        x += *d;
        if (!(sq_length(x) < kFarOff * kFarOff)) return std::nullopt;
        if (sq_length(*d) < small * small) return x;
    }
    return std::nullopt;
}

bool edge_shows(const Surfel& s, const SheetPair& pair, const Vec3d& x) {
    if (s.n_sheets() == 2) return true;
    std::array<double, kMostSheets> f = s.sheet_values(x);
    f[pair.a] = f[pair.b] = 0;
    return std::abs(s.sharp->joined(f)) <= kEdgeTolerance;
}

}  // namespace slim
