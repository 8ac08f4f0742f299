#include "raytrace/environment.h"
#include "raytrace/matcap.h"
#include "raytrace/stripes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slim {
namespace {

constexpr std::array<Vec3d, 3> kAxes{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};

/// A map of one lamp, a disc of half-angle `radius` about `toward`, over a dim rest.
std::vector<float> lamp_map(int width, int height, const Vec3d& toward, double radius) {
    std::vector<float> rgb;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double a = 2 * std::numbers::pi * ((x + 0.5) / width - 0.5),
                         p = std::numbers::pi * (y + 0.5) / height;
            const Vec3d d{std::sin(p) * std::sin(a), std::cos(p), -std::sin(p) * std::cos(a)};
            const auto light =
                static_cast<float>(std::acos(dot(d, normalized(toward))) < radius ? 40.0 : 0.1);
            rgb.insert(rgb.end(), {light, light, light});
        }
    return rgb;
}

/// The sum itself: light of the map times cosine over pi, by its own texels.
double irradiance(const std::vector<float>& rgb, int width, int height, const Vec3d& n) {
    double sum = 0;
    for (int y = 0; y < height; ++y) {
        const double p = std::numbers::pi * (y + 0.5) / height;
        const double angle = 2 * std::numbers::pi / width *
                             (std::cos(std::numbers::pi * y / height) -
                              std::cos(std::numbers::pi * (y + 1) / height));
        for (int x = 0; x < width; ++x) {
            const double a = 2 * std::numbers::pi * ((x + 0.5) / width - 0.5);
            const double c =
                dot(n, Vec3d{std::sin(p) * std::sin(a), std::cos(p), -std::sin(p) * std::cos(a)});
            if (c > 0)
                sum += static_cast<double>(rgb[3 * static_cast<std::size_t>(y * width + x)]) * c *
                       angle;
        }
    }
    return sum / std::numbers::pi;
}

TEST(Environment, DiffuseLightIsTheSumOverTheMap) {
    const Vec3d lamp{0.4, 0.7, 0.6};
    const auto rgb = lamp_map(512, 256, lamp, 0.2);
    const Environment light(512, 256, rgb, kAxes, 0);
    const double scale = static_cast<double>(light.radiance(to_float(normalized(lamp))).x) / 40;
    double worst = 0;
    for (int i = 0; i < 200; ++i) {
        const double z = 1 - (2.0 * i + 1) / 200, a = 2.399963 * i, r = std::sqrt(1 - z * z);
        const Vec3d n{r * std::cos(a), z, r * std::sin(a)};
        const double exact = scale * irradiance(rgb, 512, 256, n);
        worst =
            std::max(worst, std::abs(static_cast<double>(light.diffuse(to_float(n)).x) - exact));
    }
    const double most = scale * irradiance(rgb, 512, 256, normalized(lamp));
    EXPECT_LT(worst / most, 5e-3);  // bilinear between directions 5.6 degrees apart
}

TEST(Environment, AConstantMapLightsAllAlikeWithItsMean) {
    const Environment light(8, 4, std::vector<float>(96, 3.0f), kAxes, 0);
    for (const Vec3f d : {Vec3f{0, 1, 0}, Vec3f{0, -1, 0}, Vec3f{1, 0, 0}, Vec3f{0.6f, 0, 0.8f}}) {
        EXPECT_NEAR(light.radiance(d).y, 0.5f, 1e-4);
        EXPECT_NEAR(light.diffuse(d).y, 0.5f, 1e-3);
        EXPECT_NEAR(light.glossy(d).y, 0.5f, 1e-4);
    }
}

TEST(Environment, TurnsAboutTheUpAxisAndFollowsIt) {
    const auto rgb = lamp_map(128, 64, {0, 0, -1}, 0.15);  // in the middle of the map
    const auto brightest = [&](const std::array<Vec3d, 3>& axes, double turn, const Vec3f& where) {
        return Environment(128, 64, rgb, axes, turn).radiance(where).x > 5;
    };
    EXPECT_TRUE(brightest(kAxes, 0, {0, 0, -1}));
    EXPECT_TRUE(brightest(kAxes, 90, {-1, 0, 0}));  // counterclockwise from above
    const std::array<Vec3d, 3> z_up{Vec3d{1, 0, 0}, Vec3d{0, 0, 1}, Vec3d{0, -1, 0}};
    EXPECT_TRUE(brightest(z_up, 0, {0, 1, 0}));
}

TEST(Matcap, LooksUpTheBallByTheNormalSeenFromTheEye) {
    // Red grows to the right, green downwards.
    std::vector<float> rgb;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            rgb.insert(rgb.end(), {static_cast<float>(x) / 63, static_cast<float>(y) / 63, 0});
    const Matcap ball(64, 64, rgb);
    const Vec3f ahead{0, 0, 1};
    EXPECT_NEAR(ball.color({0, 0, 1}, ahead).x, 0.5f, 0.01);
    EXPECT_NEAR(ball.color({1, 0, 0}, ahead).x, 1, 0.03);
    EXPECT_NEAR(ball.color({0, 1, 0}, ahead).y, 0, 0.03);
    // A surface that faces an eye off the axis is the middle of the ball; one across its view is
    // the rim.
    const Vec3f aside = normalized(Vec3f{0.5f, 0.2f, 1});
    EXPECT_NEAR(ball.color(aside, aside).x, 0.5f, 0.01);
    EXPECT_NEAR(ball.color(aside, aside).y, 0.5f, 0.01);
    const Vec3f across = normalized(cross(Vec3f{0, 1, 0}, aside));
    const Vec3f rim = ball.color(across, aside);
    EXPECT_NEAR(std::hypot(rim.x - 0.5f, rim.y - 0.5f), 0.5f, 0.03);
}

TEST(Stripes, FacingTheEyeIsTheEdgeOfNoStripeAndAnglesAlternate) {
    const Vec3f eye{0, 0, 1};
    int n_edges = 0;
    bool was_lit = false;
    for (int i = 0; i < 3600; ++i) {  // normals turn by half of what the mirrored ray does
        const float a = (static_cast<float>(i) / 3600 - 0.5f) * std::numbers::pi_v<float>;
        const float facing = 0.55f + 0.45f * std::max(0.0f, std::cos(a));
        const bool lit = reflected_stripes({std::sin(a), 0, std::cos(a)}, eye) / facing > 0.44f;
        n_edges += i > 0 && lit != was_lit;
        was_lit = lit;
    }
    EXPECT_EQ(n_edges, static_cast<int>(kReflectionStripes));
}

}  // namespace
}  // namespace slim
