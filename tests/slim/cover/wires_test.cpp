#include "slim/model/rim.h"
#include "tests/slim/cover/cover_support.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slim::test {
namespace {

constexpr double kHeight = 6, kScatter = 0.02;

/// A ground of 20,000 points, and one wire of 500 over it, along x; its normals agree, as those of
/// a scan line do.
PointBlock wire_over_ground() {
    PointBlock block = graph_points(20000, 20, 21, [](double, double) { return 0.0; });
    for (std::uint64_t i = 0; i < 500; ++i) {
        block.position.push_back({20 * random_at(22, i), kScatter * gaussian(23, i),
                                  kHeight + kScatter * gaussian(24, i)});
        block.normal.push_back({0, 0, 1});
        block.id.push_back(block.id.size());
    }
    return block;
}

/// How far beside the wire the leaf stands where it is drawn: within 0.72 rho and its rims.
double farthest_beside(const Surfel& s) {
    double most = 0;
    for (int k = 0; k < 64; ++k)
        for (double r = 0.02; r < 0.72; r += 0.02) {
            const double a = std::numbers::pi * k / 32, u = r * std::cos(a), v = r * std::sin(a);
            if (!(rim_share(s.rims, u, v) > 0)) continue;
            const Vec3d at = s.center + s.frame.world_from_local(
                                            Vec3d{u, v, s.polynomial.value(u, v)}) *
                                            s.support_radius;
            most = std::max(most, std::hypot(at.y, at.z - kHeight));
        }
    return most;
}

struct WireLeaves {
    std::size_t n = 0;
    double largest = 0, beside = 0;
};

WireLeaves wire_leaves(bool lines_are_wires) {
    const PointBlock block = wire_over_ground();
    CoverRules rules = rules_for(block);
    rules.lines_are_wires = lines_are_wires;
    WireLeaves out;
    for (const FittedSurfel& f : leaves_of(cover(block, rules))) {
        if (f.surfel.center.z < kHeight / 2) continue;
        ++out.n;
        out.largest = std::max(out.largest, f.surfel.support_radius);
        out.beside = std::max(out.beside, farthest_beside(f.surfel));
    }
    return out;
}

TEST(Wires, LeavesAreShortAndNarrowWhereTheRestIsDenseBothWays) {
    const WireLeaves wire = wire_leaves(true);
    EXPECT_GT(wire.n, 20u);
    EXPECT_LT(wire.largest, 2);
    EXPECT_LT(wire.beside, 0.7);
}

TEST(Wires, ALineOfAScanIsCoveredAsAPatch) {
    const WireLeaves line = wire_leaves(false);
    EXPECT_GT(line.n, 0u);
    EXPECT_GT(line.largest, 4);
    EXPECT_GT(line.beside, 1.4);
}

}  // namespace
}  // namespace slim::test
