#include "raytrace/hillshade.h"
#include "raytrace/shade.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace slim {
namespace {

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

/// A map from above, one unit a pixel, with a line every 4 units of height.
struct Map {
    explicit Map(int size) : n(size) {
        camera.eye = {0, 0, 100}, camera.target = {0, 0, 0}, camera.up = {0, 1, 0};
        camera.orthographic = true, camera.width = size;
        shade.orthographic = true;
    }
    Picture paint(const GBuffer& b, bool lines = true) const {
        const Relief relief{{Vec3f{1, 0, 0}, Vec3f{0, 0, 1}, Vec3f{0, -1, 0}}, 0, 315, 45,
                            lines ? 4.0 : 0.0, 1000};
        return paint_relief(b, pixel_view(camera, n, n), shade, {0, b.height}, relief, 1);
    }
    /// How much darker the lines make the pixels of each row, together.
    std::vector<double> ink(const GBuffer& b) const {
        const Picture with = paint(b), without = paint(b, false);
        std::vector<double> sums(static_cast<std::size_t>(b.height));
        for (int y = 0; y < b.height; ++y)
            for (int x = 0; x < b.width; ++x)
                sums[static_cast<std::size_t>(y)] +=
                    static_cast<double>(without.pixel(x, y)[0] - with.pixel(x, y)[0]);
        return sums;
    }

    int n;
    Camera camera;
    ShadeView shade;
};

/// Moves the heights of a slope in x by a slope in y and a constant.
void shear(GBuffer& b, double in_y, double up) {
    for (int y = 0; y < b.height; ++y)
        for (int x = 0; x < b.width; ++x)
            b.position[2][b.index(x, y)] += static_cast<float>(in_y * y + up);
}

TEST(Hillshade, ContourLinesAreEvenWhereNormalsAreNotTheSlopeOfTheHeights) {
    // Where surfels change, the blended normal may be several times as steep as the heights are, or
    // a part.
    const int n = 100;
    const Map map(n);
    for (const double of_normals : {0.02, 0.1, 0.5}) {
        SCOPED_TRACE(of_normals);
        GBuffer b = slope(n, 0.1);
        const GBuffer other = slope(n, of_normals);
        b.normal = other.normal;
        // Lines that cross the rows at all distances from the pixels.
        shear(b, 0.013, 3.3);
        const std::vector<double> ink = map.ink(b);
        const auto [least, most] = std::minmax_element(ink.begin() + 10, ink.end() - 10);
        EXPECT_GT(*least, 0.5);
        EXPECT_LT(*most, 1.15 * *least);
    }
}

TEST(Hillshade, AStepBetweenTwoSurfacesIsNoContourLine) {
    const int n = 40;
    GBuffer b = slope(n, 0);
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) b.position[2][b.index(x, y)] = x < 20 ? 1.0f : 23.0f;
    EXPECT_NEAR(Map(n).ink(b)[20], 0, 1e-6);
}

TEST(Hillshade, SamplesOfAPixelLookAtNoOthers) {
    // What lies beyond is drawn or not by how a picture is shared out.
    const int n = 40;
    Map map(n);
    GBuffer whole = slope(n, 0.3);
    for (std::size_t i = 0; i < whole.n_pixels(); ++i)  // curved
        whole.position[2][i] += 0.02f * whole.position[0][i] * whole.position[0][i];
    GBuffer part = whole;
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x)
            if (x / 2 % 3 == 0 || y / 2 % 5 == 0) part.hit[part.index(x, y)] = 0;
    const CoarsePlanes around{whole.hit, {whole.normal[0], whole.normal[1], whole.normal[2]},
                              0,         0,
                              n,         n};
    map.shade.around = &around;
    const Picture a = map.paint(whole), b = map.paint(part);
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x)
            if (part.hit[part.index(x, y)] != 0) {
                EXPECT_EQ(a.pixel(x, y)[0], b.pixel(x, y)[0]) << x << " " << y;
            }
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

}  // namespace
}  // namespace slim
