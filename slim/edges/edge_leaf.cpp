#include "slim/edges/edge_leaf.h"

#include <cmath>

namespace slim {
namespace {

constexpr int kSteps = 8;
constexpr double kSmallStep = 1e-10, kFarOff = 1.5;

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
    constexpr double kLeastVolume = 0.01;
    Vec3d x;
    for (int step = 0; step < kSteps; ++step) {
        const Vec3d g[3] = {s.sheet_gradient(0, x), s.sheet_gradient(1, x), s.sheet_gradient(2, x)};
        const Vec3d c0 = cross(g[1], g[2]), c1 = cross(g[2], g[0]), c2 = cross(g[0], g[1]);
        const double volume = dot(g[0], c0);
        if (!(std::abs(volume) > kLeastVolume * length(g[0]) * length(g[1]) * length(g[2])))
            return std::nullopt;
        const Vec3d d =
            (c0 * s.sheet_value(0, x) + c1 * s.sheet_value(1, x) + c2 * s.sheet_value(2, x)) *
            (-1 / volume);
        x += d;
        if (!(sq_length(x) < kFarOff * kFarOff)) return std::nullopt;
        if (sq_length(d) < kSmallStep * kSmallStep) return x;
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
