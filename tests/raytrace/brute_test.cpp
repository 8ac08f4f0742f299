#include "raytrace/brute/brute_renderer.h"

#include "raytrace/lines/extract.h"
#include "raytrace/project/forward_renderer.h"
#include "slim/base/hash.h"
#include "tests/raytrace/support/like_brute.h"
#include "tests/raytrace/support/sharp_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace slim {
namespace {

using test::request_for, test::rough_model, test::sharp_model;

void expect_agreement(const SurfelTreeData& model, const RenderRequest& request) {
    GBuffer fast;
    render_forward(model.view(), request, fast);
    test::expect_like_brute(model, request, fast);
}

class BruteTest : public testing::TestWithParam<int> {};

TEST_P(BruteTest, AgreesWithTheFastRendererOnASphere) {
    const auto model = test::sphere_model(1, 800, GetParam());
    for (const bool orthographic : {false, true})
        expect_agreement(model, request_for(model, "iso", orthographic, 250));
}

TEST_P(BruteTest, AgreesWithTheFastRendererOnARoughModel) {
    const auto model = rough_model(GetParam(), 7);
    for (const bool orthographic : {false, true})
        expect_agreement(model, request_for(model, "right", orthographic, 250));
}

TEST_P(BruteTest, AgreesWithTheFastRendererOnSharpSurfels) {
    const auto model = sharp_model(GetParam(), 7);
    ASSERT_GT(model.sharp.size(), 400u);
    for (const bool orthographic : {false, true})
        expect_agreement(model, request_for(model, "right", orthographic, 250));
}

TEST_P(BruteTest, SharpSurfelsAreSeenInTheirCoresOnly) {
    const auto model =
        test::flat_tree({test::edge_surfel({0, 0, 0}, {1, 0, 1}, {-1, 0, 1}, 1)}, GetParam());
    const RenderRequest request = request_for(model, "front", true, 250);
    GBuffer plain, fast;
    render_brute(model.view(), request, plain);
    render_forward(model.view(), request, fast);
    for (const GBuffer* seen : {&plain, &fast}) {
        double farthest = 0;
        for (std::size_t i = 0; i < seen->n_pixels(); ++i)
            if (seen->hit[i])
                farthest =
                    std::max(farthest, length(Vec3d{seen->position[0][i], seen->position[1][i],
                                                    seen->position[2][i]}));
        EXPECT_LE(farthest, kSharpHitTrim + 1e-5);
        EXPECT_GT(farthest, kSharpHitTrim - 0.02);
    }
}

TEST_P(BruteTest, AgreesWithTheFastRendererOnRims) {
    auto model = rough_model(GetParam(), 7);
    const RenderRequest request = request_for(model, "right", false, 250);
    GBuffer whole, cut;
    render_forward(model.view(), request, whole);
    for (std::size_t i = 1; i < model.nodes.size(); ++i) {
        const auto first = static_cast<PackedRim>(keyed_hash(3, i));
        const auto second = static_cast<PackedRim>(keyed_hash(5, i));
        model.nodes[i].set_rims({first, first == 0 ? PackedRim{0} : second});
    }
    render_forward(model.view(), request, cut);
    EXPECT_NE(whole.position[2], cut.position[2]);
    for (const bool orthographic : {false, true})
        expect_agreement(model, request_for(model, "right", orthographic, 250));
}

TEST_P(BruteTest, AgreesWithTheFastRendererInsideABall) {
    const auto model = rough_model(GetParam(), 8);
    RenderRequest request = request_for(model, "front", false, 200);
    request.camera.eye = {0, 0, 1.04};  // within the ball of the pole's surfel
    request.camera.target = {0.3, 0.5, 0.2};
    request.camera.fov_y_deg = 90;
    request.camera.near_plane = 0.01;
    expect_agreement(model, request);
    request.camera.eye = {0.1, 0.1, 0};  // inside the sphere
    expect_agreement(model, request);
}

/// A surfel on the ellipsoid of these half axes at a point of the unit sphere: its height over the
/// tangent plane, developed to the third order by differences.
Surfel ellipsoid_surfel(const Vec3d& on_sphere, const Vec3d& axes, double rho) {
    const Vec3d c{on_sphere.x * axes.x, on_sphere.y * axes.y, on_sphere.z * axes.z};
    const auto over = [&](const Vec3d& v) {
        return Vec3d{v.x / axes.x, v.y / axes.y, v.z / axes.z};
    };
    Surfel s{c, rho, frame_from_normal(round_normal(normalized(over(over(c))))), {}, 3};
    const auto w = [&](double u, double v) {  // f(c + p + w n) = 0, the root near 0
        const Vec3d q = over(c + s.frame.u_axis * (u * rho) + s.frame.v_axis * (v * rho)),
                    n = over(s.frame.normal * rho);
        const double a = dot(n, n), b = dot(q, n), k = dot(q, q) - 1;
        return -k / (b + std::sqrt(b * b - a * k));
    };
    constexpr double h = 0.1;
    const double wu3 = (w(2 * h, 0) - 2 * w(h, 0) + 2 * w(-h, 0) - w(-2 * h, 0)) / (2 * h * h * h),
                 wv3 = (w(0, 2 * h) - 2 * w(0, h) + 2 * w(0, -h) - w(0, -2 * h)) / (2 * h * h * h);
    const auto uu = [&](double v) { return (w(h, v) - 2 * w(0, v) + w(-h, v)) / (h * h); };
    const auto vv = [&](double u) { return (w(u, h) - 2 * w(u, 0) + w(u, -h)) / (h * h); };
    const double uv = (w(h, h) - w(h, -h) - w(-h, h) + w(-h, -h)) / (4 * h * h);
    const double uuv = (uu(h) - uu(-h)) / (4 * h), uvv = (vv(h) - vv(-h)) / (4 * h);
    s.polynomial.a = {0, 0, 0, uu(0) / 2, uv, vv(0) / 2, wu3 / 6, uuv, uvv, wv3 / 6};
    return s;
}

SurfelTreeData ellipsoid_model(const Vec3d& axes) {
    std::vector<Surfel> leaves;
    for (std::size_t i = 0; i < 1500; ++i)
        leaves.push_back(ellipsoid_surfel(test::fibonacci_point(i, 1500), axes, 0.12));
    return test::flat_tree(std::move(leaves), 3);
}

/// Pixels from a point of the picture to the lines of a kind.
double nearest_line(const LinePoint& p, LineKind kind, const std::vector<FeatureLine>& lines) {
    double nearest = 1e9;
    for (const FeatureLine& line : lines) {
        if (line.kind != kind) continue;
        line.for_each_segment([&](const LinePoint& a, const LinePoint& b) {
            const double ux = b.x - a.x, uy = b.y - a.y, px = p.x - a.x, py = p.y - a.y;
            const double sq = ux * ux + uy * uy;
            const double t = sq > 0 ? std::clamp((px * ux + py * uy) / sq, 0.0, 1.0) : 0;
            nearest = std::min(nearest, std::hypot(px - t * ux, py - t * uy));
        });
    }
    return nearest;
}

/// Points of a kind of lines, and those of them farther than a tenth of a pixel from the others'
/// lines.
struct LinePoints {
    std::size_t all = 0, off = 0;
};
LinePoints points_off(LineKind kind, const std::vector<FeatureLine>& lines,
                      const std::vector<FeatureLine>& others) {
    LinePoints n;
    for (const FeatureLine& line : lines) {
        if (line.kind != kind) continue;
        for (const LinePoint& p : line.points)
            ++n.all, n.off += nearest_line(p, kind, others) > 0.1;
    }
    return n;
}

std::vector<FeatureLine> lines_in(const SurfelTreeData& model, const RenderRequest& request,
                                  const GBuffer& buffer) {
    constexpr std::array kKinds{LineKind::contour, LineKind::suggestive, LineKind::ridge,
                                LineKind::valley,  LineKind::parabolic,  LineKind::reflection};
    const PixelView view = pixel_view(request.camera, request.width, request.height);
    return extract_lines({buffer, view, model.header.diagonal, model.header.degree}, kKinds);
}

/// Its parabolic lines stand out from errors so small.
SurfelTreeData exact_rough_model() {
    SurfelTreeData model = rough_model(3, 7);
    for (TreeNode& node : model.nodes) node.fit_error *= 0.001f;
    return model;
}

TEST(BruteRenderer, LinesOfItsBufferAreThoseOfTheFastOnesPointByPoint) {
    // No model has lines of all kinds.
    const auto torus = test::torus_model(1, 0.35, 60, 24, 3), rough = exact_rough_model(),
               ellipsoid = ellipsoid_model({1, 0.7, 0.4});
    const auto has_kind = [&](const SurfelTreeData& model, LineKind kind) {
        if (kind == LineKind::contour || kind == LineKind::reflection) return true;
        if (kind == LineKind::ridge || kind == LineKind::valley)
            return &model == &ellipsoid && kind == LineKind::ridge;
        return &model == &rough || (&model == &torus && kind == LineKind::parabolic);
    };
    for (const SurfelTreeData* model : {&torus, &rough, &ellipsoid}) {
        const RenderRequest request = request_for(*model, "iso", false, 250);
        GBuffer fast, slow;
        render_forward(model->view(), request, fast);
        render_brute(model->view(), request, slow);
        const auto a = lines_in(*model, request, fast), b = lines_in(*model, request, slow);
        for (const LineKind kind : {LineKind::contour, LineKind::suggestive, LineKind::ridge,
                                    LineKind::valley, LineKind::parabolic, LineKind::reflection})
            for (const bool forth : {true, false}) {
                const LinePoints n = forth ? points_off(kind, a, b) : points_off(kind, b, a);
                SCOPED_TRACE(std::string(model == &torus   ? "torus "
                                         : model == &rough ? "rough "
                                                           : "ellipsoid ") +
                             std::string(line_name(kind)));
                EXPECT_GE(n.all, has_kind(*model, kind) ? 20u : 0u);
                EXPECT_LE(n.off, 1 + n.all / 200) << n.all;
            }
    }
}

INSTANTIATE_TEST_SUITE_P(Degrees, BruteTest, testing::Values(1, 2, 3));

TEST(BruteRenderer, AgreesWithTheFastRendererAtExtremeAngles) {
    const auto model = rough_model(2, 9);
    RenderRequest request = request_for(model, "front", false, 150);
    request.camera.eye = {0, 0, 1.5};
    request.camera.fov_y_deg = 150;
    expect_agreement(model, request);
    request.camera.eye = {0, 0, 30000};
    request.camera.fov_y_deg = 0.001;
    expect_agreement(model, request);
}

TEST(BruteRenderer, DoesNotDrawInternalNodes) {
    const auto model = test::two_level_sphere(1, 50, 400);
    RenderRequest request = request_for(model, "front", true, 40);
    GBuffer out;
    const auto stats = render_brute(model.view(), request, out);
    EXPECT_EQ(stats.surfels_drawn, 400u);
    for (std::size_t i = 0; i < out.n_pixels(); ++i)
        if (out.hit[i]) { ASSERT_GT(out.surfel_id[i], 50u); }
}

TEST(BruteRenderer, LooseSurfelsAreNeitherHitNorBlendedUnlessAsked) {
    // A disc in front of a sphere and one sunk into it, which would be blended.
    auto leaves = [] {
        std::vector<Surfel> out;
        for (std::size_t i = 0; i < 800; ++i)
            out.push_back(test::sphere_surfel(test::fibonacci_point(i, 800), 1, 0.16, 2));
        return out;
    }();
    const std::size_t n_sphere = leaves.size();
    const auto sphere = test::flat_tree(leaves, 2);
    const auto disc = [](const Vec3d& center) {
        return Surfel{center, 0.3, frame_from_normal(round_normal({0, 0, 1})), {}, 2};
    };
    leaves.push_back(disc({0, 0, 1.3}));
    leaves.push_back(disc({0, 0, 0.97}));
    auto model = test::flat_tree(leaves, 2);
    model.header.bounds = sphere.header.bounds;
    for (std::size_t i = n_sphere + 1; i < model.nodes.size(); ++i) model.nodes[i].flags |= kLoose;
    RenderRequest request = request_for(model, "front", true, 200);
    for (const bool brute : {false, true}) {
        const auto draw = [&](const SurfelTreeData& data, bool loose, GBuffer& out) {
            request.loose = loose;
            return brute ? render_brute(data.view(), request, out)
                         : render_forward(data.view(), request, out);
        };
        GBuffer plain, without, with;
        draw(sphere, false, plain);
        EXPECT_EQ(draw(model, false, without).loose_hidden, 2u);
        EXPECT_EQ(draw(model, true, with).loose_hidden, 0u);
        EXPECT_EQ(without.hit, plain.hit);
        EXPECT_EQ(without.count, plain.count);
        EXPECT_NE(with.count, plain.count);
        EXPECT_NE(with.surfel_id, plain.surfel_id);
        for (std::size_t i = 0; i < plain.n_pixels(); ++i)  // other page origins, other roundings
            ASSERT_NEAR(without.depth[i], plain.depth[i], 1e-5);
    }
    expect_agreement(model, request);
}

}  // namespace
}  // namespace slim
