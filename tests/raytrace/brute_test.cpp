#include "raytrace/brute/brute_renderer.h"

#include "raytrace/project/forward_renderer.h"
#include "slim/base/hash.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim {
namespace {

struct Difference {
    std::uint64_t covered = 0, hit = 0, depth = 0, normal = 0, curvature = 0, third = 0;
};

/// Whether directions and derivatives differ, up to their common sign; not told where k1 is near k2.
bool third_order_differs(const GBuffer& fast, const GBuffer& reference, std::size_t i) {
    const double k1 = reference.k1[i], k2 = reference.k2[i], size = 1 + std::abs(k1) + std::abs(k2);
    if (k1 - k2 < 0.05 * size) return false;
    double cos = 0, off = 0, third = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        cos += static_cast<double>(fast.direction[axis][i] * reference.direction[axis][i]);
    for (std::size_t k = 0; k < 4; ++k) {
        const double a = fast.third[k][i], b = reference.third[k][i];
        off = std::max(off, std::abs(cos > 0 ? a - b : a + b));
        third = std::max(third, std::abs(b));
    }
    return std::abs(cos) < 1 - 1e-4 || off > 5e-3 * (size * size + third);
}

/// Pixels that differ: in the mask, or in position by more than 1e-5 of the winner's radius.
Difference compare(const SurfelTreeData& model, const RenderRequest& request) {
    GBuffer fast, reference;
    render_forward(model.view(), request, fast);
    render_brute(model.view(), request, reference);
    const PixelView view = pixel_view(request.camera, request.width, request.height);
    Difference d;
    for (std::size_t i = 0; i < fast.n_pixels(); ++i) {
        d.covered += reference.hit[i];
        if (fast.hit[i] != reference.hit[i]) {
            ++d.hit;
            continue;
        }
        if (!fast.hit[i]) continue;
        const Vec3d p{fast.position[0][i], fast.position[1][i], fast.position[2][i]};
        const Vec3d q{reference.position[0][i], reference.position[1][i], reference.position[2][i]};
        const double rho = model.view().support_radius(reference.surfel_id[i]);
        // The planes hold floats: two roundings of a coordinate come on top.
        const double rounding = 2e-7 * (length(q) + 1e-30);
        d.depth += std::abs(dot(p - q, view.forward)) > 1e-5 * rho + rounding;
        const Vec3d n{fast.normal[0][i], fast.normal[1][i], fast.normal[2][i]};
        const Vec3d m{reference.normal[0][i], reference.normal[1][i], reference.normal[2][i]};
        d.normal += length(n - m) > 1e-3;
        d.curvature += std::abs(fast.mean[i] - reference.mean[i]) > 1e-3 * (1 + std::abs(reference.mean[i]));
        d.third += third_order_differs(fast, reference, i);
    }
    return d;
}

void expect_agreement(const SurfelTreeData& model, const RenderRequest& request) {
    const Difference d = compare(model, request);
    const auto allowed = static_cast<double>(d.covered) * 1e-4 + 1;
    EXPECT_GT(d.covered, 100u);
    EXPECT_LE(static_cast<double>(d.hit + d.depth), allowed);
    EXPECT_LE(static_cast<double>(d.normal), allowed);
    EXPECT_LE(static_cast<double>(d.curvature), allowed);
    EXPECT_LE(static_cast<double>(d.third), 3 * allowed);
}

RenderRequest request_for(const SurfelTreeData& model, const char* name, bool orthographic,
                          int size) {
    RenderRequest request;
    Framing framing;
    framing.orthographic = orthographic;
    request.camera = named_camera(name, model.header.bounds, 1, framing);
    request.width = request.height = size;
    request.wanted = kAllChannels;
    request.lod_px = 0;
    return request;
}

/// A sphere whose surfels were shaken: rough polynomials of full degree, mixed radii, opposed sheets.
SurfelTreeData rough_model(int degree, std::uint64_t seed) {
    auto leaves = test::sphere_leaves(1, 700, 6, degree);
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const auto noise = [&](std::uint64_t k) {
            return 2 * unit_interval(keyed_hash(seed, i, k)) - 1;
        };
        Surfel& s = leaves[i];
        s.support_radius *= 1 + 0.5 * noise(0);
        s.center += Vec3d{noise(1), noise(2), noise(3)} * (0.05 * s.support_radius);
        const int n = degree <= 1 ? 1 : n_coefficients(degree);
        for (int k = 0; k < n; ++k)
            s.polynomial.a[static_cast<std::size_t>(k)] += 0.15 * noise(10 + static_cast<std::uint64_t>(k));
    }
    return test::flat_tree(std::move(leaves), degree);
}

/// The rough sphere with two or three sheets on two surfels of three, joined in every way.
SurfelTreeData sharp_model(int degree, std::uint64_t seed) {
    const SurfelTreeData rough = rough_model(degree, seed);
    const SurfelTree tree = rough.view();
    std::vector<Surfel> leaves;
    for (std::size_t i = 1; i < tree.n_nodes(); ++i) {
        Surfel s = tree.surfel(i);
        SharpSheets more;
        more.n_extra = i % 3;
        more.outer = i % 2 ? Join::max : Join::min;
        more.inner = i % 4 < 2 ? Join::max : Join::min;
        for (std::size_t k = 0; k < more.n_extra; ++k) {
            const auto noise = [&](std::uint64_t n) {
                return 2 * unit_interval(keyed_hash(seed + k, i, n)) - 1;
            };
            const Vec3d tilt{noise(100), noise(101), noise(102)};
            more.extra[k] = {frame_from_normal(round_normal(normalized(s.frame.normal + tilt * 0.8))),
                             s.polynomial};
        }
        if (more.n_extra > 0) s.sharp = std::make_shared<const SharpSheets>(more);
        leaves.push_back(s);
    }
    return test::flat_tree(std::move(leaves), degree);
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
