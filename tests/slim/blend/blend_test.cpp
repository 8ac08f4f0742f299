#include "slim/blend/blend.h"

#include "slim/base/hash.h"

#include <gtest/gtest.h>

#include <memory>
#include <numbers>
#include <span>
#include <vector>

namespace slim {
namespace {

Vec3d random_unit(std::uint64_t seed) {
    const double z = 2 * unit_interval(keyed_hash(seed, 1)) - 1;
    const double angle = 2 * std::numbers::pi * unit_interval(keyed_hash(seed, 2));
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
}

/// A surfel on the unit sphere: osculating paraboloid w = -rho (u^2 + v^2) / 2.
Surfel sphere_surfel(const Vec3d& n, double rho) {
    Surfel s{n, rho, frame_from_normal(n), {}, 2};
    s.polynomial.a[3] = s.polynomial.a[5] = -rho / 2;
    return s;
}

Surfel random_cubic(std::uint64_t seed) {
    Surfel s{random_unit(seed), 0.5, frame_from_normal(random_unit(seed + 77)), {}, 3};
    for (std::size_t i = 0; i < 10; ++i)
        s.polynomial.a[i] = 0.2 * (2 * unit_interval(keyed_hash(seed, 10 + i)) - 1);
    return s;
}

double surfel_function(const Surfel& s, const Vec3d& x) {
    const Vec3d q = s.frame.local_from_world((x - s.center) / s.support_radius);
    return q.z - s.polynomial.value(q.x, q.y);
}

TEST(RaySurfel, PolynomialIsTheFunctionAlongTheRay) {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(seed);
        const Surfel s = random_cubic(seed);
        const Ray ray{s.center + random_unit(seed + 1) * 3.0, random_unit(seed + 2)};
        const LocalRay local = local_ray(ray, s);
        const auto k = ray_polynomial(local, s.polynomial);
        for (const double t : {-0.9, 0.0, 0.3, 1.0}) {
            const double world_t = local.t_base + s.support_radius * t;
            const double f = surfel_function(s, ray.origin + ray.direction * world_t);
            ASSERT_NEAR(ray_value(k, t), f, 1e-11 * (1 + std::abs(f)));
        }
    }
}

TEST(RaySurfel, NothingIsHitOrBlendedBeyondTheRim) {
    Surfel s{{0, 0, 0}, 1, frame_from_normal(Vec3d{0, 0, 1}), {}, 2};
    const Rim rim = unpack_rim(s.rims.first = pack_rim(0, 0.24));
    const Vec3d out = s.frame.u_axis * rim.u + s.frame.v_axis * rim.v;
    const auto at = [&](double reach) { return Ray{out * reach + Vec3d{0, 0, 2}, {0, 0, -1}}; };
    const auto weight_at = [&](double reach) {
        BlendSums sums;
        add_supporter(at(reach), 2, {Vec3d{0, 0, 1}}, s, Derivatives::first, sums);
        return sums.weight;
    };
    Vec3d gradient;
    EXPECT_TRUE(first_hit(at(0.23), s, 0, kHitTrim, gradient));
    EXPECT_FALSE(first_hit(at(0.25), s, 0, kHitTrim, gradient));
    EXPECT_TRUE(first_hit(at(-0.5), s, 0, kHitTrim, gradient));
    EXPECT_EQ(weight_at(0.25), 0);
    EXPECT_GT(weight_at(0.23), 0);
    EXPECT_LT(weight_at(0.23), 0.2 * weight_at(0.13));  // no step: it fades over kRimRamp
}

TEST(ProjectAlong, APointBeyondTheRimsOfAllItsSupportersKeepsThem) {
    Surfel s{{0, 0, 0}, 1, frame_from_normal(Vec3d{0, 0, 1}), {}, 2};
    const Rim rim = unpack_rim(s.rims.first = pack_rim(0, 0.24));
    const Vec3d out = s.frame.u_axis * rim.u + s.frame.v_axis * rim.v;
    const Surfel* supporters[] = {&s};
    const auto hit = project_along(out * 0.5 + Vec3d{0, 0, 0.1}, {0, 0, 1}, supporters);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->t, -0.1, 1e-12);
}

TEST(RaySurfel, FirstHitLiesOnTheSurfelInsideTheTrimmedBall) {
    int hits = 0;
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
        const Surfel s = random_cubic(seed);
        const Vec3d eye = s.center + random_unit(seed + 1) * 3.0;
        const Ray ray{eye, normalized(s.center + random_unit(seed + 5) * 0.2 - eye)};
        Vec3d gradient;
        const auto t = first_hit(ray, s, 0, kTrim, gradient);
        if (!t) continue;
        ++hits;
        const Vec3d q = ray.origin + ray.direction * *t;
        ASSERT_NEAR(surfel_function(s, q), 0, 1e-12);
        ASSERT_LE(length(q - s.center), kTrim * s.support_radius * (1 + 1e-12));
        const double h = 1e-5;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            Vec3d e;
            e[axis] = h;
            const double difference =
                (surfel_function(s, q + e) - surfel_function(s, q - e)) / (2 * h);
            ASSERT_NEAR(gradient[axis], s.support_radius * difference, 1e-8);
        }
        EXPECT_FALSE(first_hit(ray, s, *t + 2 * s.support_radius, kTrim, gradient));
    }
    EXPECT_GT(hits, 200);
}

TEST(Blend, ASheetFartherOffThanPointsBelongToIsNotBlended) {
    // Two parallel planes, both facing up, whose balls hold the point between them.
    const Frame<double> up = frame_from_normal(Vec3d{0, 0, 1});
    const Surfel here{{0, 0, 0}, 1, up, {}, 1};
    for (const double gap : {0.25, 0.35}) {
        SCOPED_TRACE(gap);
        const Surfel other{{0.2, 0, gap}, 1, up, {}, 1};
        const Surfel* both[] = {&here, &other};
        const auto hit = project_along({0.1, 0, 0}, {0, 0, 1}, both);
        ASSERT_TRUE(hit);
        EXPECT_EQ(hit->n_supporters, gap < kBelongs ? 2 : 1);
        if (gap > kBelongs) EXPECT_EQ(hit->t, 0);
        else EXPECT_GT(hit->t, 0.05);
    }
}

TEST(Curvature, OfATorusMatchesItsClosedForm) {
    const double big = 2, small = 0.5;
    for (double b = 0.1; b < 6.2; b += 0.37) {
        // Implicit torus at angle b of the tube, in the plane y = 0:
        // F = (sqrt(x^2+y^2) - R)^2 + z^2.
        const double x = big + small * std::cos(b), z = small * std::sin(b), d = x - big;
        const Vec3d gradient{2 * d, 0, 2 * z};
        const SymmetricMatrix h{2, 0, 0, 2 * d / x, 0, 2};
        const Curvature k = curvature_from(gradient, h);
        const double other = std::cos(b) / x;
        EXPECT_NEAR(k.k1, std::max(1 / small, other), 1e-12);
        EXPECT_NEAR(k.k2, std::min(1 / small, other), 1e-12);
        EXPECT_NEAR(k.mean, (1 / small + other) / 2, 1e-12);
        EXPECT_NEAR(k.gauss, other / small, 1e-12);
    }
}

TEST(Curvature, DoesNotCancelAtAnUmbilic) {
    const Curvature k = curvature_from({0, 0, 1}, {1, 0, 0, 1 + 1e-13, 0, 0});
    EXPECT_NEAR(k.k1 - k.k2, 1e-13, 1e-15);
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
