#include "slim/blend/blend.h"

#include "slim/base/hash.h"
#include "tests/slim/blend/blend_support.h"

#include <gtest/gtest.h>

#include <numbers>
#include <span>
#include <vector>

namespace slim {
namespace {

using test::random_cubic, test::random_unit, test::sphere_surfel;

TEST(ProjectAlong, APointBeyondTheRimsOfAllItsSupportersKeepsThem) {
    Surfel s{{0, 0, 0}, 1, frame_from_normal(Vec3d{0, 0, 1}), {}, 2};
    const Rim rim = unpack_rim(s.rims.first = pack_rim(0, 0.24));
    const Vec3d out = s.frame.u_axis * rim.u + s.frame.v_axis * rim.v;
    const Surfel* supporters[] = {&s};
    const auto hit = project_along(out * 0.5 + Vec3d{0, 0, 0.1}, {0, 0, 1}, supporters);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->t, -0.1, 1e-12);
}

std::vector<Surfel> sphere_model() {
    std::vector<Surfel> surfels;
    for (std::uint64_t i = 0; i < 3000; ++i)
        surfels.push_back(sphere_surfel(random_unit(1000 + i), 0.15));
    return surfels;
}

std::vector<const Surfel*> pointers(const std::vector<Surfel>& surfels) {
    std::vector<const Surfel*> out;
    for (const Surfel& s : surfels) out.push_back(&s);
    return out;
}

TEST(ProjectAlong, PutsNoisyPointsOnTheSphereWithItsNormalAndCurvature) {
    const auto surfels = sphere_model();
    const auto all = pointers(surfels);
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
        SCOPED_TRACE(seed);
        const Vec3d n = random_unit(seed);
        const auto projection = project_along(n * 1.02, n, all, true);
        ASSERT_TRUE(projection);
        EXPECT_GT(projection->n_supporters, 3);
        EXPECT_NEAR(length(projection->point), 1, 2e-4);
        EXPECT_NEAR(projection->t, -0.02, 2e-4);
        EXPECT_GT(dot(projection->normal, n), 1 - 1e-5);
        EXPECT_NEAR(projection->curvature.mean, 1, 0.03);
        EXPECT_NEAR(projection->curvature.gauss, 1, 0.06);
    }
}

TEST(ProjectAlong, OneCubicSurfelKeepsTheCurvatureOfItsHeightField) {
    int n_projected = 0;
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        SCOPED_TRACE(seed);
        const Surfel s = random_cubic(seed);
        const std::vector<const Surfel*> one{&s};
        const Vec3d start = s.center + random_unit(seed + 5) * (0.3 * s.support_radius);
        const auto p = project_along(start, s.frame.normal, one, true);
        if (!p) continue;
        ++n_projected;
        const Vec3d q = s.frame.local_from_world((p->point - s.center) / s.support_radius);
        ASSERT_NEAR(q.z, s.polynomial.value(q.x, q.y), 1e-12);
        const auto& a = s.polynomial;
        const double u = a.d_u(q.x, q.y), v = a.d_v(q.x, q.y), g = std::sqrt(1 + u * u + v * v);
        const double uu = a.d_uu(q.x, q.y), uv = a.d_uv(q.x, q.y), vv = a.d_vv(q.x, q.y);
        // Classic formulas of a graph, over rho for the unit; minus, because convex is positive.
        const double mean = -((1 + v * v) * uu - 2 * u * v * uv + (1 + u * u) * vv) /
                            (2 * g * g * g * s.support_radius);
        const double gauss =
            (uu * vv - uv * uv) / (g * g * g * g * s.support_radius * s.support_radius);
        ASSERT_NEAR(p->curvature.mean, mean, 1e-10);
        ASSERT_NEAR(p->curvature.gauss, gauss, 1e-10);
        ASSERT_GT(p->weight, 0);
    }
    EXPECT_GT(n_projected, 80);
}

TEST(ProjectAlong, MissesWithoutSupportAndAgainstTheOrientation) {
    const auto surfels = sphere_model();
    const auto all = pointers(surfels);
    const Vec3d n = random_unit(3);
    EXPECT_FALSE(project_along(n * 1.5, n, all));
    EXPECT_FALSE(project_along(n, n * -1.0, all));
    EXPECT_FALSE(project_along(n, n, {}));
    EXPECT_EQ(project_along(n, n, all)->curvature.mean, 0);
}

TEST(ProjectAlong, OppositeSheetsDoNotMix) {
    const double gap = 0.02;
    Surfel top{{0, 0, gap}, 1, frame_from_normal(Vec3d{0, 0, 1}), {}, 1};
    Surfel bottom{{0, 0, -gap}, 1, frame_from_normal(Vec3d{0, 0, -1}), {}, 1};
    const std::vector<const Surfel*> both{&top, &bottom};
    const auto p = project_along({0.1, 0.2, 0.3}, {0, 0, 1}, both);
    ASSERT_TRUE(p);
    EXPECT_EQ(p->n_supporters, 1);
    EXPECT_NEAR(p->point.z, gap, 1e-15);
}

/// Of a convex edge the face z = 0.01 counts at the origin with a weight near 1; `other` is the
/// other face's normal.
Surfel edge_above_origin(const Vec3d& other) {
    Surfel edge{{0, 0, 0}, 1, frame_from_normal(Vec3d{0, 0, 1}), {}, 1};
    edge.polynomial.a[0] = 0.01;
    SharpSheets sheets;
    sheets.extra[0] = {frame_from_normal(other), {}};
    sheets.extra[0].polynomial.a[0] = 0.5;
    edge.sharp = std::make_shared<const SharpSheets>(sheets);
    return edge;
}

TEST(ProjectAlong, WhichFaceCountsIsNotSaidByALeafBeyondItsRim) {
    // Of a convex edge the face z = 0.01 is met; the other face's leaves pass nearer, but p lies
    // beyond the rim of one, and the rest of them is far off.
    const Vec3d up{0, 0, 1}, other{std::sin(1.0), 0, std::cos(1.0)};
    const Surfel edge = edge_above_origin(other);
    Surfel ended{{0, 0, 0}, 1, frame_from_normal(other), {}, 1},
        far{other * 0.1, 1, frame_from_normal(other), {}, 1};
    ended.center = ended.frame.u_axis * -0.5;
    ended.rims.first = pack_rim(0, 0.3);
    for (const std::vector<const Surfel*>& supporters :
         {std::vector<const Surfel*>{&edge, &ended, &far}, {&far, &ended, &edge}}) {
        const auto hit = project_along({0, 0, 0}, up, supporters);
        ASSERT_TRUE(hit);
        EXPECT_NEAR(hit->t, 0.01, 1e-12);
        EXPECT_EQ(hit->n_supporters, 1);
    }
    // Where all are beyond theirs, they still say it.
    const Surfel* alone = &ended;
    EXPECT_TRUE(project_along({0, 0, 0}, up, std::span(&alone, 1)));
}

TEST(ProjectAlong, WhichFaceCountsIsNotSaidByALeafAtTheEndOfItsWeight) {
    // Another leaf of the other face passes through p itself, nearer than the edge's own; p lies
    // inside its ball and its rim.
    const Vec3d up{0, 0, 1}, other{std::sin(1.0), 0, std::cos(1.0)};
    const Surfel edge = edge_above_origin(other);
    const auto at_local = [&](double u, double v, PackedRim rim) {
        Surfel leaf{{0, 0, 0}, 1, frame_from_normal(other), {}, 1};
        leaf.center = leaf.frame.u_axis * -u - leaf.frame.v_axis * v;
        leaf.rims.first = rim;
        return leaf;
    };
    const auto hit_beside = [&](const Surfel& leaf, double leaf_weight, double tolerance) {
        const Surfel* alone = &leaf;
        const auto own = project_along({0, 0, 0}, up, std::span(&alone, 1));
        EXPECT_TRUE(own);
        EXPECT_NEAR(own->weight, leaf_weight, tolerance);
        const std::vector<const Surfel*> both{&edge, &leaf};
        const auto hit = project_along({0, 0, 0}, up, both);
        EXPECT_TRUE(hit);
        EXPECT_EQ(hit->n_supporters, 1);
        return hit->t;
    };
    const PackedRim packed = pack_rim(0, 0.3);
    const Rim rim = unpack_rim(packed);
    const auto at_reach = [&](double reach) {
        return at_local(rim.u * reach, rim.v * reach, packed);
    };
    // at its ball's end
    EXPECT_NEAR(hit_beside(at_local(0.9176, 0, 0), 1e-4, 1e-5), 0.01, 1e-12);
    // at its rim's
    EXPECT_NEAR(hit_beside(at_reach(rim.reach - 3e-4 * kRimRamp), 1e-4, 5e-5), 0.01, 1e-12);
    // With an ordinary weight it does say.
    EXPECT_NEAR(hit_beside(at_local(0.6, 0, 0), 0.055, 0.01), 0, 1e-12);
    EXPECT_NEAR(hit_beside(at_reach(rim.reach - 0.5 * kRimRamp), 0.2, 0.1), 0, 1e-12);
}

TEST(NormalAt, GivesTheModelsOwnNormal) {
    const auto surfels = sphere_model();
    const auto all = pointers(surfels);
    const Vec3d n = random_unit(11);
    const auto found = normal_at(n * 1.01, all);
    ASSERT_TRUE(found);
    EXPECT_GT(dot(*found, n), 1 - 1e-4);
    EXPECT_FALSE(normal_at(n * 2.0, all));
}

}  // namespace
}  // namespace slim
