#include "raytrace/camera_path.h"
#include "raytrace/crop.h"
#include "raytrace/environment.h"
#include "raytrace/hillshade.h"
#include "raytrace/key.h"
#include "raytrace/matcap.h"
#include "raytrace/scale_bar.h"
#include "raytrace/shade.h"
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

TEST(Hillshade, SpacingOfContoursIsRound) {
    EXPECT_DOUBLE_EQ(contour_spacing(0, 100), 5);
    EXPECT_DOUBLE_EQ(contour_spacing(-3, 1), 0.2);
    EXPECT_DOUBLE_EQ(contour_spacing(1000, 1019), 1);
    EXPECT_EQ(contour_spacing(7, 7), 0);
}

/// A plane of slope s in x, seen from above at one pixel a unit; heights in x are s x.
GBuffer slope(int n, double s) {
    GBuffer b;
    b.reset(n, n, kNormalChannel | kPositionChannel);
    const Vec3d normal = normalized(Vec3d{-s, 0, 1});
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const std::size_t i = b.index(x, y);
            b.hit[i] = 1;
            const Vec3d p{x + 0.5 - n / 2.0, n / 2.0 - y - 0.5, s * (x + 0.5 - n / 2.0)};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                b.position[axis][i] = static_cast<float>(p[axis]);
                b.normal[axis][i] = static_cast<float>(normal[axis]);
            }
        }
    return b;
}

/// Columns of a row that are darker than the middle between two lines is.
std::vector<int> lines_of(const Picture& picture, int y, float level) {
    std::vector<int> columns;
    for (int x = 0; x < picture.width; ++x)
        if (picture.pixel(x, y)[0] < level) columns.push_back(x);
    return columns;
}

TEST(Hillshade, ContourLinesLieAtTheirHeightsOnePixelWide) {
    const int n = 100;
    const GBuffer b = slope(n, 0.5);
    Camera camera;
    camera.eye = {0, 0, 100}, camera.target = {0, 0, 0}, camera.up = {0, 1, 0};
    camera.orthographic = true, camera.width = n;
    ShadeView shade;
    shade.orthographic = true;
    Relief relief{{Vec3f{1, 0, 0}, Vec3f{0, 0, 1}, Vec3f{0, -1, 0}}, 0, 315, 45, 4, 5};
    const PixelView view = pixel_view(camera, n, n);
    const Picture with = paint_relief(b, view, shade, {0, n}, relief, 1);
    relief.spacing = 0;
    const Picture without = paint_relief(b, view, shade, {0, n}, relief, 1);
    // Height 4 k lies at x = 8 k; its line covers the two pixels beside it, half each.
    const float level = 0.9f * without.pixel(50, 50)[0];
    const std::vector<int> columns = lines_of(with, 50, level);
    for (const int x : columns) {
        const double in_lines = (x + 0.5 - n / 2.0) / 8;
        EXPECT_LT(std::abs(in_lines - std::round(in_lines)) * 8, 1.6) << x;
    }
    EXPECT_NEAR(static_cast<double>(columns.size()), 2 * n / 8.0, 8);
    // The heavy line of height 0 is darker than the next.
    EXPECT_LT(with.pixel(50, 50)[0], with.pixel(58, 50)[0]);
}

TEST(Hillshade, HeavyLinesStayWhereTheOthersRunIntoATone) {
    const int n = 100;
    Camera camera;
    camera.eye = {0, 0, 100}, camera.orthographic = true, camera.width = n;
    ShadeView shade;
    shade.orthographic = true;
    // A line every 1.5 pixels, a heavy one every 15.
    const Relief relief{{Vec3f{1, 0, 0}, Vec3f{0, 0, 1}, Vec3f{0, -1, 0}}, 0, 315, 45, 1.5, 10};
    const Picture p = paint_relief(slope(n, 1), pixel_view(camera, n, n), shade, {0, n}, relief, 1);
    std::vector<float> tone;
    for (int x = 53; x < 62; ++x) tone.push_back(p.pixel(x, 50)[0]);
    EXPECT_LT(
        *std::max_element(tone.begin(), tone.end()) - *std::min_element(tone.begin(), tone.end()),
        0.02f);
    for (const int heavy : {50, 65, 80}) EXPECT_LT(p.pixel(heavy, 50)[0], 0.6f * tone[4]) << heavy;
}

TEST(Hillshade, ContoursOfAnySpacingAreNumbers) {
    ShadeView shade;
    shade.orthographic = true;
    Camera camera;
    camera.eye = {0, 0, 10}, camera.orthographic = true, camera.width = 9;
    for (const double spacing : {1e-300, 2.3e-308, 1e-20, 1e300}) {
        const Relief relief{
            {Vec3f{1, 0, 0}, Vec3f{0, 0, 1}, Vec3f{0, -1, 0}}, 5e9, 315, 45, spacing, 5};
        const Picture picture =
            paint_relief(slope(9, 0.5), pixel_view(camera, 9, 9), shade, {0, 9}, relief, 1);
        for (const float v : picture.rgba) ASSERT_TRUE(v >= 0 && v <= 1) << spacing;
    }
}

TEST(Hillshade, TheSunIsWhereItsAzimuthSays) {
    const int n = 9;
    ShadeView shade;
    shade.orthographic = true;
    Camera camera;
    camera.eye = {0, 0, 10}, camera.orthographic = true, camera.width = n;
    const PixelView view = pixel_view(camera, n, n);
    const auto light = [&](double slope_x, double azimuth) {
        const Relief relief{
            {Vec3f{1, 0, 0}, Vec3f{0, 0, 1}, Vec3f{0, -1, 0}}, 0, azimuth, 45, 0, 5};
        return paint_relief(slope(n, slope_x), view, shade, {0, n}, relief, 1).pixel(4, 4)[1];
    };
    // Its shade keeps the shape of what stands upright: no two slopes are alike.
    for (const double steep : {0.5, 1.0, 2.0, 4.0, 8.0})
        EXPECT_LT(light(2 * steep, 90), light(steep, 90) - 0.001f) << steep;
    // A slope that rises to the east looks west.
    EXPECT_GT(light(0.7, 270), light(0.7, 90) + 0.3f);
    EXPECT_GT(light(-0.7, 90), light(-0.7, 270) + 0.3f);
}

TEST(ScaleBar, LengthIsRoundAndTakesAFairShare) {
    for (const double px_per_unit : {0.003, 0.7, 1.0, 13.0, 4711.0}) {
        const double share = scale_bar_length({px_per_unit, ""}, 1000) * px_per_unit / 1000;
        EXPECT_GT(share, 0.11) << px_per_unit;
        EXPECT_LE(share, 0.3) << px_per_unit;
    }
    EXPECT_DOUBLE_EQ(scale_bar_length({1, ""}, 1000), 200);
}

TEST(ScaleBar, PartsOfAPictureGetTheirPartOfIt) {
    Picture whole(700, 500);
    ASSERT_TRUE(burn_scale_bar({2.5, "mm"}, whole));
    const PixelWindow window{20, 371, 150, 100};
    Picture part(window.width, window.height);
    ASSERT_TRUE(burn_scale_bar({2.5, "mm"}, Canvas(part, window.x, window.y, 700, 500)));
    EXPECT_EQ(part.rgba, crop(whole, window).rgba);
    EXPECT_GT(*std::max_element(part.rgba.begin(), part.rgba.end()), 0.5f);
    Picture tiny(60, 40);
    EXPECT_FALSE(burn_scale_bar({2.5, "mm"}, tiny));
}

TEST(Key, StandsWhereItHidesLeastAndIsWrittenAsSvg) {
    const Key key{"title", {{"red <x>", true, {1, 0, 0}}, {"plain", false, {}}}};
    Picture object(800, 600);
    for (int y = 300; y < 600; ++y)
        for (int x = 400; x < 800; ++x) object.pixel(x, y)[3] = 1;
    EXPECT_EQ(best_key_place(key, object), LegendPlace::right_top);
    ASSERT_TRUE(burn_key(key, object, LegendPlace::right_top));
    EXPECT_NE(key_svg(key).find("red &lt;x&gt;"), std::string::npos);
    EXPECT_NE(key_svg(key).find("#ff0000"), std::string::npos);
}

TEST(Key, SvgIsAsWideAsItsWordsNeed) {
    const Key key{"contour lines", {{"every 5 m", false, {}}}};
    EXPECT_NE(key_svg(key).find("width=\"70mm\" height=\"18mm\" viewBox=\"0 0 70 18\""),
              std::string::npos);
    const std::string svg =
        key_svg({"contour lines", {{"heavy every 0.025 US survey feet (1927)", false, {}}}});
    const double width = std::stod(svg.substr(svg.find("width=\"") + 7));
    EXPECT_GT(width, 74);  // 69.9 mm in DejaVu Sans, and 4 to its left
    EXPECT_LT(width, 90);
}

TEST(CameraPath, PassesItsKeyframesAndStaysSmooth) {
    Camera a, b, c;
    a.eye = {0, 0, 5};
    b.eye = {5, 1, 0}, b.target = {0, 1, 0}, b.fov_y_deg = 50;
    c.eye = {0, 8, -5}, c.up = {0, 1, 0.2};
    const Camera keys[] = {a, b, c};
    for (int k = 0; k < 3; ++k) {
        const Camera at = camera_on_path(keys, k);
        EXPECT_LT(length(at.eye - keys[k].eye), 1e-9) << k;
        EXPECT_LT(length(at.target - keys[k].target), 1e-9) << k;
        EXPECT_NEAR(at.fov_y_deg, keys[k].fov_y_deg, 1e-9) << k;
        EXPECT_NO_THROW(validate(at));
    }
    // No jump of place or speed: second differences stay of the size of a step's square.
    const double step = 0.01;
    Vec3d before = camera_on_path(keys, 0).eye, now = camera_on_path(keys, step).eye;
    for (int i = 2; i <= 200; ++i) {
        const Vec3d next = camera_on_path(keys, i * step).eye;
        EXPECT_LT(length(next - now), 0.3) << i;
        EXPECT_LT(length(next - now * 2 + before), 0.02) << i;
        before = now, now = next;
    }
}

TEST(CameraPath, AFullTurnComesBackAndKeepsItsDistance) {
    Camera camera;
    camera.eye = {1, 2, 5}, camera.target = {0, 0, 1};
    const Vec3d center{0.5, 0, 0}, axis{0, 3, 0};
    EXPECT_LT(length(turned(camera, center, axis, 360).eye - camera.eye), 1e-12);
    const Camera quarter = turned(camera, center, axis, 90);
    EXPECT_NEAR(length(quarter.eye - quarter.target), length(camera.eye - camera.target), 1e-12);
    EXPECT_LT(length(quarter.eye - Vec3d{5.5, 2, -0.5}), 1e-12);
}

TEST(NamedCamera, ATurntableKeepsEveryPositionInThePicture) {
    const Bbox box{{-3, -1, -0.5}, {3, 1, 0.5}};
    for (const bool orthographic : {false, true}) {
        const Camera camera =
            named_camera("front", box, 1.5, {.orthographic = orthographic, .turns = 12});
        for (int k = 0; k < 12; ++k) {
            const PixelView view =
                pixel_view(turned(camera, box.center(), {0, 1, 0}, 30 * k), 300, 200);
            for (unsigned i = 0; i < 8; ++i) {
                const Vec3d p = view.camera_from_local(
                    {i & 1u ? 3.0 : -3.0, i & 2u ? 1.0 : -1.0, i & 4u ? 0.5 : -0.5});
                const double scale = orthographic ? view.px_per_unit : view.focal_px / p.z;
                EXPECT_LE(std::abs(p.x * scale), 150) << k;
                EXPECT_LE(std::abs(p.y * scale), 100) << k;
            }
        }
    }
}

}  // namespace
}  // namespace slim
