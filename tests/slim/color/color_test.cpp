#include "slim/base/hash.h"
#include "slim/base/parallel.h"
#include "slim/color/color_blend.h"
#include "slim/color/color_fit.h"
#include "slim/model/surfel_encoder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {
namespace {

// Colours are stored in steps of 1/8192, frames and radii of leaves in 16 bits or so.
constexpr double kStored = 2e-3;

/// A level sheet of n x n leaves over the unit square below a root; every ball overlaps its
/// neighbours.
SurfelTreeData sheet(std::size_t n, const Vec3d& normal = {0, 0, 1}) {
    std::vector<Surfel> surfels(1, Surfel{{0.5, 0.5, 0}, 2, frame_from_normal(normal), {}, 1});
    SurfelTreeData data;
    data.header.degree = 1;
    data.nodes.resize(n * n + 1);
    data.nodes[0].first_child = 1;
    data.nodes[0].n_children = static_cast<std::uint32_t>(n * n);
    for (std::size_t i = 0; i < n * n; ++i) {
        const double x = (static_cast<double>(i % n) + 0.5) / static_cast<double>(n),
                     y = (static_cast<double>(i / n) + 0.5) / static_cast<double>(n);
        surfels.push_back(
            {{x, y, 0}, 1.2 / static_cast<double>(n), frame_from_normal(normal), {}, 1});
        data.nodes[i + 1].flags = kLeaf;
        data.nodes[i + 1].degree = 1;
        data.nodes[i + 1].n_points = 10;
    }
    encode_surfels(surfels, data);
    return data;
}

Vec3f linear_color(const Vec3d& p) {
    return to_float(Vec3d{0.2 + 0.5 * p.x, 0.8 - 0.4 * p.y, 0.3 + 0.2 * p.x + 0.1 * p.y});
}

struct ColoredPoints {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> colors;
};

template <class Color>
ColoredPoints points_of(std::size_t n, const Color& color) {
    ColoredPoints out;
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3d p{unit_interval(keyed_hash(7, i, 1)), unit_interval(keyed_hash(7, i, 2)), 0};
        out.positions.push_back(p);
        out.colors.push_back(color(p));
    }
    return out;
}

std::vector<PackedColor> packed(const std::vector<SurfelColor>& colors) {
    std::vector<PackedColor> out;
    for (const SurfelColor& c : colors) out.push_back(pack(c));
    return out;
}

TEST(Color, ALinearFieldComesBack) {
    const SurfelTreeData data = sheet(8);
    const SurfelTree tree = data.view();
    const ColoredPoints cloud = points_of(40000, linear_color);
    ColorFit fit(tree);
    fit.add(cloud.positions, {}, cloud.colors);
    EXPECT_EQ(fit.n_lost(), 0u);
    const std::vector<PackedColor> colors = packed(fit.finish());
    const ColorBlend blend(tree, colors);
    std::vector<const Surfel*> found;
    // Slopes are damped by 2e-3 of a variance of about 0.09: 2 % of what the colour changes over a
    // leaf, 0.15.
    for (std::size_t i = 0; i < 500; ++i) {
        const Vec3d p{unit_interval(keyed_hash(8, i, 1)), unit_interval(keyed_hash(8, i, 2)), 0};
        const Vec3f got = blend.at(p, {0, 0, 1}, 0, found), expected = linear_color(p);
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(got[c], expected[c], 4e-3) << p.x << " " << p.y;
    }
}

TEST(Color, OneColourIsExactWhateverThePointsAre) {
    const SurfelTreeData data = sheet(4);
    const SurfelTree tree = data.view();
    const Vec3f red{0.9f, 0.1f, 0.25f};
    const ColoredPoints cloud = points_of(60, [&](const Vec3d&) { return red; });
    ColorFit fit(tree);
    fit.add(cloud.positions, {}, cloud.colors);
    for (const SurfelColor& color : fit.finish()) {
        for (std::size_t c = 0; c < 3; ++c) {
            EXPECT_NEAR(color.base[c], red[c], 1e-6);
            EXPECT_NEAR(color.du[c], 0, 1e-6);
            EXPECT_NEAR(color.dv[c], 0, 1e-6);
        }
    }
}

TEST(Color, FewPointsGiveNoWildSlopes) {
    const SurfelTreeData data = sheet(1);
    const SurfelTree tree = data.view();
    // Undamped, the slope of two points 1e-4 apart would be thousands.
    const std::vector<Vec3d> positions{{0.5, 0.5, 0}, {0.5001, 0.5, 0}};
    const std::vector<Vec3f> colors{{0, 0, 0}, {1, 1, 1}};
    ColorFit fit(tree);
    fit.add(positions, {}, colors);
    const SurfelColor color = fit.finish()[1];
    EXPECT_NEAR(color.base.x, 0.5, 0.01);
    EXPECT_LT(std::abs(color.du.x) + std::abs(color.dv.x), 0.05);
}

TEST(Color, PointsCountForLeavesThatFaceAsTheyDo) {
    const SurfelTreeData data = sheet(2);
    const SurfelTree tree = data.view();
    const ColoredPoints cloud = points_of(2000, linear_color);
    ColorFit fit(tree);
    fit.add(cloud.positions, std::vector<Vec3f>(cloud.positions.size(), Vec3f{0, 0, -1}),
            cloud.colors);
    EXPECT_EQ(fit.n_lost(), cloud.positions.size());
    fit.add(cloud.positions, std::vector<Vec3f>(cloud.positions.size(), Vec3f{0, 0, 1}),
            cloud.colors);
    EXPECT_EQ(fit.n_lost(), cloud.positions.size());
    EXPECT_GT(fit.finish()[1].base.x, 0.2f);
}

TEST(Color, LeavesWithoutAPointTakeTheirParents) {
    const SurfelTreeData data = sheet(8);
    const SurfelTree tree = data.view();
    const Vec3f blue{0.1f, 0.2f, 0.7f};
    const std::vector<Vec3d> positions(5, {0.05, 0.05, 0});
    const std::vector<Vec3f> colors(5, blue);
    ColorFit fit(tree);
    fit.add(positions, {}, colors);
    const std::vector<SurfelColor> fitted = fit.finish();
    for (const std::size_t node : {std::size_t{0}, std::size_t{1}, std::size_t{64}})
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(fitted[node].base[c], blue[c], 1e-6) << node;
}

TEST(Color, PiecesAndThreadsDoNotMatter) {
    const SurfelTreeData data = sheet(6);
    const SurfelTree tree = data.view();
    const ColoredPoints cloud = points_of(30000, linear_color);
    const auto fitted = [&](int threads, std::size_t piece) {
        const ThreadLimit limit(threads);
        ColorFit fit(tree);
        for (std::size_t i = 0; i < cloud.positions.size(); i += piece)
            fit.add(std::span(cloud.positions).subspan(i, piece), {},
                    std::span(cloud.colors).subspan(i, piece));
        return packed(fit.finish());
    };
    const auto once = fitted(1, 30000);
    EXPECT_EQ(once, fitted(3, 30000));
    EXPECT_EQ(once, fitted(2, 1500));
}

TEST(ColorBlend, IsTheMeanOfTheLeavesByWeight) {
    const SurfelTreeData data = sheet(2);
    const SurfelTree tree = data.view();
    std::vector<SurfelColor> colors(5);
    for (std::size_t i = 1; i < 5; ++i)
        colors[i].base = i % 2 == 1 ? Vec3f{1, 0, 0} : Vec3f{0, 0, 1};
    colors[0].base = {0, 1, 0};
    const auto stored = packed(colors);
    const ColorBlend blend(tree, stored);
    std::vector<const Surfel*> found;
    // As near to the red leaves as to the blue ones.
    const Vec3f middle = blend.at({0.5, 0.5, 0}, {0, 0, 1}, 0, found);
    EXPECT_NEAR(middle.x, 0.5, kStored);
    EXPECT_NEAR(middle.z, 0.5, kStored);
    // Nearer to the red ones, all of one side.
    EXPECT_GT(blend.at({0.3, 0.5, 0}, {0, 0, 1}, 0, found).x, 0.6f);
    // From behind, or where no leaf is, the node's own.
    for (const auto& [p, n] : {std::pair{Vec3d{0.5, 0.5, 0}, Vec3d{0, 0, -1}},
                               std::pair{Vec3d{9, 9, 9}, Vec3d{0, 0, 1}}})
        EXPECT_NEAR(blend.at(p, n, 0, found).y, 1, kStored);
}

}  // namespace
}  // namespace slim
