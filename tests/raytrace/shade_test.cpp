#include "raytrace/shade.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace slim {
namespace {

/// The front half of a unit sphere seen by an orthographic camera that shows [-1.25, 1.25]^2.
struct SphereBuffers {
    int n;
    std::vector<float> x, y, z;
    std::vector<std::uint8_t> hit;

    explicit SphereBuffers(int size, float side = 1) : n(size) {
        for (int row = 0; row < n; ++row)
            for (int column = 0; column < n; ++column) {
                const float u =
                    1.25f * (2 * (static_cast<float>(column) + 0.5f) / static_cast<float>(n) - 1);
                const float v =
                    1.25f * (1 - 2 * (static_cast<float>(row) + 0.5f) / static_cast<float>(n));
                const float rest = 1 - u * u - v * v;
                hit.push_back(rest > 0);
                x.push_back(rest > 0 ? side * u : 0);
                y.push_back(rest > 0 ? side * v : 0);
                z.push_back(rest > 0 ? side * std::sqrt(rest) : 0);
            }
    }
    NormalPlanes normals() const { return {x, y, z}; }
    Picture shaded(const ShadeView& view, const Lighting& lighting = {}) const {
        return shade(n, n, view, normals(), hit, lighting);
    }
};

ShadeView orthographic_view() {
    ShadeView view;
    view.half_width = view.half_height = 1.25;
    view.orthographic = true;
    return view;
}

float brightness(const Picture& p, int x, int y) { return p.pixel(x, y)[1]; }

TEST(Shade, KeyLightComesFromTheUpperLeft) {
    const Picture p = SphereBuffers(64).shaded(orthographic_view());
    EXPECT_GT(brightness(p, 20, 18), 2 * brightness(p, 44, 46));
    EXPECT_GT(brightness(p, 20, 18), brightness(p, 20, 46));
    EXPECT_GT(brightness(p, 20, 18), brightness(p, 44, 18));
}

TEST(Shade, NothingIsBlackAndHardlyAnythingBurnsOut) {
    const SphereBuffers sphere(128);
    const Picture p = sphere.shaded(orthographic_view());
    int burnt = 0, n_hits = 0;
    for (std::size_t i = 0; i < p.n_pixels(); ++i) {
        if (!sphere.hit[i]) continue;
        ++n_hits;
        EXPECT_GT(p.rgba[4 * i + 1], 0.03f);
        burnt += p.rgba[4 * i] > 1;
    }
    EXPECT_LT(burnt, n_hits / 50);
}

/// Blinn-Phong in doubles, orthographic, of a normal that faces the eye.
double reference_green(const Lighting& l, const Vec3d& n) {
    const auto at = [&](const Vec3f& toward) { return std::max(0.0, dot(n, to_double(toward))); };
    const Vec3d half = normalized(to_double(l.key.toward) + Vec3d{0, 0, 1});
    const double up = 0.5 * (1 + n.y), facing = std::min(1.0, 4 * at(l.key.toward));
    const double diffuse = l.sky.y * up + l.ground.y * (1 - up) + l.key.color.y * at(l.key.toward) +
                           l.fill.color.y * at(l.fill.toward);
    return l.albedo.y * diffuse +
           l.key.color.y * l.specular * facing * std::pow(std::max(0.0, dot(n, half)), l.shininess);
}

TEST(Shade, IsBlinnPhongWithinAQuarterOfAnEightBitStep) {
    const SphereBuffers sphere(133);  // no multiple of the lanes
    const Picture p = sphere.shaded(orthographic_view());
    for (std::size_t i = 0; i < p.n_pixels(); ++i) {
        if (!sphere.hit[i]) continue;
        const double expected =
            reference_green(Lighting{}, {sphere.x[i], sphere.y[i], sphere.z[i]});
        ASSERT_NEAR(255 * srgb_from_linear(p.rgba[4 * i + 1]),
                    255 * srgb_from_linear(static_cast<float>(expected)), 0.25);
    }
}

TEST(Shade, AlphaIsTheHitMaskAndMissesAreZero) {
    const SphereBuffers sphere(32);
    const Picture p = sphere.shaded(orthographic_view());
    for (std::size_t i = 0; i < p.n_pixels(); ++i) {
        EXPECT_EQ(p.rgba[4 * i + 3], sphere.hit[i] ? 1 : 0);
        if (!sphere.hit[i]) {
            EXPECT_EQ(p.rgba[4 * i], 0);
        }
    }
}

TEST(Shade, BothSidesLookAlike) {
    const Picture out = SphereBuffers(48).shaded(orthographic_view());
    const Picture in = SphereBuffers(48, -1).shaded(orthographic_view());
    EXPECT_EQ(out.rgba, in.rgba);
}

/// Unit normal at an angle cosine to the eye (0, 0, 1), leaning up.
Vec3f leaning(float cosine) {
    return {0, std::sqrt(std::max(0.0f, 1 - cosine * cosine)), cosine};
}

TEST(Shade, SilhouetteNormalIsUnitFacesTheEyeAndIsContinuous) {
    const Vec3f eye{0, 0, 1};
    Vec3f before = leaning(1);
    for (int i = 0; i <= 2000; ++i) {
        const Vec3f n = silhouette_normal(leaning(1 - 0.001f * static_cast<float>(i)), eye);
        EXPECT_GE(n.z, 0) << i;
        EXPECT_NEAR(length(n), 1, 1e-5f) << i;
        // The steepest part turns by about 140 degrees over a cosine of 0.2.
        EXPECT_LT(length(n - before), 0.06f) << i;
        before = n;
    }
}

TEST(Shade, SilhouetteNormalMirrorsASilhouetteAndTurnsABackRound) {
    const Vec3f eye{0, 0, 1};
    const Vec3f rim = silhouette_normal(leaning(-0.2f), eye);
    const Vec3f back = silhouette_normal(leaning(-0.6f), eye);
    EXPECT_NEAR(length(rim - leaning(0.2f)), 0, 1e-6f);
    EXPECT_EQ(back.y, -leaning(-0.6f).y);
    EXPECT_EQ(back.z, 0.6f);
}

TEST(Shade, AnOvershootAtTheTopEdgeIsNoDarkRim) {
    // The top of an object under a light from above: the last pixel's normal leans over the edge.
    const std::vector<float> x(2, 0), y{0.995f, 0.995f}, z{0.1f, -0.1f};
    const std::vector<std::uint8_t> hit(2, 1);
    const Picture p = shade(1, 2, orthographic_view(), {x, y, z}, hit);
    EXPECT_NEAR(brightness(p, 0, 1), brightness(p, 0, 0), 1e-3f);
    // Far from any front it is the back of a sheet, and turned round.
    const std::vector<float> back_z{-0.1f, -0.1f};
    const Picture q = shade(1, 2, orthographic_view(), {x, y, back_z}, hit);
    EXPECT_LT(brightness(q, 0, 1), 0.5f * brightness(p, 0, 1));
}

TEST(Shade, OnlyANearbyFrontMakesASilhouette) {
    // Just reversed normals with a front of two columns at their left end,
    // from which they lean away.
    constexpr int kWidth = 9, kHeight = 5;
    const std::size_t n = kWidth * kHeight;
    const std::vector<float> x(n, -0.995f), y(n, 0.0f);
    std::vector<float> z(n, -0.1f);
    for (int row = 0; row < kHeight; ++row)
        for (int column = 0; column < 2; ++column)
            z[static_cast<std::size_t>(row * kWidth + column)] = 0.1f;
    const std::vector<std::uint8_t> hit(n, 1);
    const Picture p = shade(kWidth, kHeight, orthographic_view(), {x, y, z}, hit);
    EXPECT_NEAR(brightness(p, 2, 2), brightness(p, 1, 2), 0.02f);
    EXPECT_LT(brightness(p, 6, 2), 0.5f * brightness(p, 2, 2));
}

TEST(Shade, WhatOneFrontPixelOrAnotherSurfaceDoesHasNoShape) {
    // A star stood about single front pixels, along the picture's rows, columns and diagonals.
    constexpr int kSide = 41;
    const std::size_t n = kSide * kSide, middle = n / 2;
    std::vector<float> x(n, 0.0f), y(n, 0.995f), z(n, -0.1f);
    const std::vector<std::uint8_t> hit(n, 1);
    ShadeView view = orthographic_view();
    view.whole_width = view.whole_height = 4000;  // looks 20 pixels far
    const auto far_from_back = [&] {
        const Picture p = shade(kSide, kSide, view, {x, y, z}, hit);
        float most = 0;
        for (int row = 0; row < kSide; ++row)
            for (int column = 0; column < kSide; ++column)
                if (static_cast<std::size_t>(row * kSide + column) != middle)
                    most =
                        std::max(most, std::abs(brightness(p, column, row) - brightness(p, 0, 0)));
        return most;
    };
    z[middle] = 0.1f;
    EXPECT_LT(far_from_back(), 0.01f);
    for (std::size_t i = 0; i < n; ++i)  // half of the picture: a front that leans the other way
        if (i % kSide > kSide / 2) y[i] = -0.995f, z[i] = 0.1f;
    const Picture p = shade(kSide, kSide, view, {x, y, z}, hit);
    EXPECT_FLOAT_EQ(brightness(p, kSide / 2 - 1, 5), brightness(p, 0, 5));
}

TEST(Shade, RowsAreThoseOfTheWholePicture) {
    const SphereBuffers sphere(40);
    ShadeView view;
    view.half_width = view.half_height = 0.5;
    const Picture whole = sphere.shaded(view);
    const Picture part = shade_rows(40, 40, view, sphere.normals(), sphere.hit, {11, 30});
    ASSERT_EQ(part.height, 19);
    EXPECT_TRUE(std::equal(part.rgba.begin(), part.rgba.end(), whole.pixel(0, 11)));
    Picture lit(40, 40), lit_part(40, 19);
    for (Picture* p : {&lit, &lit_part}) std::fill(p->rgba.begin(), p->rgba.end(), 1.0f);
    light_picture(view, sphere.normals(), sphere.hit, 0.4f, lit);
    light_picture(view, sphere.normals(), sphere.hit, 0.4f, lit_part, 11);
    EXPECT_TRUE(std::equal(lit_part.rgba.begin(), lit_part.rgba.end(), lit.pixel(0, 11)));
}

TEST(Shade, LightsTurnWithTheCamera) {
    ShadeView turned = orthographic_view();  // from the left: right = +z, back = -x
    turned.right = {0, 0, 1}, turned.back = {-1, 0, 0};
    SphereBuffers sphere(48);
    const Picture front = sphere.shaded(orthographic_view());
    for (std::size_t i = 0; i < sphere.x.size(); ++i) {
        const float x = sphere.x[i];
        sphere.x[i] = -sphere.z[i], sphere.z[i] = x;
    }
    EXPECT_EQ(front.rgba, sphere.shaded(turned).rgba);
}

TEST(Shade, PerspectiveFlipsByTheRayOfThePixel) {
    // A normal that leans away from the axis but towards the eye at the picture's left edge.
    ShadeView view;
    view.half_width = view.half_height = 2;
    const std::vector<float> x{0.9539392f}, z{-0.3f};
    std::vector<float> wide_x(3, x[0]), wide_y(3, 0), wide_z(3, z[0]);
    const std::vector<std::uint8_t> hits(3, 1);
    const Picture p = shade(3, 1, view, {wide_x, wide_y, wide_z}, hits);
    EXPECT_NE(p.rgba[0], p.rgba[8]);  // left: as it is; right: turned round
    ShadeView flat = view;
    flat.orthographic = true;
    const Picture q = shade(3, 1, flat, {wide_x, wide_y, wide_z}, hits);
    EXPECT_EQ(q.rgba[0], q.rgba[8]);
}

TEST(Shade, SpecularAndAlbedoCount) {
    const SphereBuffers sphere(64);
    Lighting matte;
    matte.specular = 0;
    Lighting dark = matte;
    dark.albedo = matte.albedo * 0.5f;
    const Picture a = sphere.shaded(orthographic_view(), matte);
    const Picture b = sphere.shaded(orthographic_view(), dark);
    const Picture c = sphere.shaded(orthographic_view());
    float most = 0;
    for (std::size_t i = 0; i < a.rgba.size(); ++i) most = std::max(most, c.rgba[i] - a.rgba[i]);
    EXPECT_GT(most, 0.05f);
    EXPECT_NEAR(brightness(b, 30, 30), 0.5f * brightness(a, 30, 30), 1e-6f);
}

TEST(Shade, MissingNormalStaysFinite) {
    const std::vector<float> zero{0};
    const std::vector<std::uint8_t> hit{1};
    const Picture p = shade(1, 1, orthographic_view(), {zero, zero, zero}, hit);
    EXPECT_TRUE(std::isfinite(p.rgba[0]));
    EXPECT_EQ(p.rgba[3], 1);
}

TEST(Shade, LightPictureDimsTheFarSideToItsFloor) {
    const SphereBuffers sphere(64);
    Picture white(64, 64);
    std::fill(white.rgba.begin(), white.rgba.end(), 1.0f);
    light_picture(orthographic_view(), sphere.normals(), sphere.hit, 0.4f, white);
    EXPECT_GT(brightness(white, 20, 18), 0.95f);
    for (std::size_t i = 0; i < sphere.hit.size(); ++i) EXPECT_GE(white.rgba[4 * i], 0.4f);
    EXPECT_LT(brightness(white, 50, 46), 0.75f);
    EXPECT_EQ(brightness(white, 0, 0), 1);  // no hit: untouched
}

TEST(Shade, CompositesOverAGradient) {
    Picture p(1, 2);
    p.pixel(0, 1)[0] = 0.25f, p.pixel(0, 1)[3] = 0.5f;  // half covered
    composite_over({{1, 1, 1}, {0, 0.4f, 0}, 1}, p);
    EXPECT_FLOAT_EQ(p.pixel(0, 0)[0], 0.75f);
    EXPECT_FLOAT_EQ(p.pixel(0, 1)[0], 0.25f + 0.5f * 0.25f);
    EXPECT_FLOAT_EQ(p.pixel(0, 1)[3], 1);
    Picture clear(1, 1);
    composite_over({{1, 1, 1}, {1, 1, 1}, 0}, clear);
    EXPECT_EQ(clear.rgba, std::vector<float>(4, 0.0f));
}

}  // namespace
}  // namespace slim
