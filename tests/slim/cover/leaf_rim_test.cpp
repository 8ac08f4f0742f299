#include "slim/cover/leaf_rim.h"

#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace slim::test {
namespace {

/// The leaf about a place of points that lie where `keep` says, on z = height(x, y).
template <class Keep, class Height>
CoveringSurfel leaf_at(const Vec3d& center, PointBlock& block, Keep&& keep, Height&& height) {
    PointBlock all = graph_points(4000, 1, 3, height);
    all.position[0] = center;
    block = {};
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (!keep(all.position[i])) continue;
        block.position.push_back(all.position[i]);
        block.normal.push_back(all.normal[i]);
        block.id.push_back(i);
    }
    BallPoints<double> work;
    return fit_surfel(tree_of(block), center, {0, 0, 1}, 0.3, 1, false, 1e-10, work);
}

double flat(double, double) { return 0; }

TEST(LeafRim, ASurfaceAllAroundHasNone) {
    PointBlock block;
    const auto leaf = leaf_at({0, 0, 0}, block, [](const Vec3d&) { return true; }, flat);
    EXPECT_EQ(rims_of(leaf), PackedRims{});
}

TEST(LeafRim, EndsALittleBeyondABorderInItsDirection) {
    for (const double angle : {0.0, 0.7, 2.0, 4.0}) {
        SCOPED_TRACE(angle);
        const Vec3d out{std::cos(angle), std::sin(angle), 0};
        PointBlock block;
        const auto leaf =
            leaf_at({0, 0, 0}, block, [&](const Vec3d& p) { return dot(p, out) <= 0.06; }, flat);
        const Surfel& s = leaf.fitted.surfel;
        const Rim rim = unpack_rim(rims_of(leaf).first);
        ASSERT_FALSE(rim.is_whole());
        EXPECT_GT(dot(s.frame.u_axis * rim.u + s.frame.v_axis * rim.v, out), std::cos(0.12));
        EXPECT_GE(rim.reach, 0.06 / 0.3);  // the border, over rho
        EXPECT_LE(rim.reach, 0.06 / 0.3 + 0.3);
        for (const Covered& c : leaf.covered) {
            const Vec3d x = s.frame.local_from_world((block.position[c.point] - s.center) / 0.3);
            EXPECT_GT(rim_share(rim, x.x, x.y), 0) << "no covered point is beyond it";
        }
    }
}

TEST(LeafRim, AScoreOfPointsOnOneSideEndHalfASpacingBeyondTheLast) {
    PointBlock block;
    std::size_t n = 0;
    const auto leaf = leaf_at(
        {0, 0, 0}, block,
        [&](const Vec3d& p) { return p.x <= 0 && sq_length(p) < 0.09 && n++ < 20; }, flat);
    const Rim rim = unpack_rim(rims_of(leaf).first);
    ASSERT_FALSE(rim.is_whole());
    // The last is the centre; the spacing is sqrt(pi / 2 / 20) = 0.28,
    // and reaches are multiples of 0.08.
    EXPECT_LE(rim.reach, 0.24 + 1e-9);
    EXPECT_GT(rim.u * leaf.fitted.surfel.frame.u_axis.x + rim.v * leaf.fitted.surfel.frame.v_axis.x,
              0.9);
}

TEST(LeafRim, FewPointsAreNoRim) {
    // Six points may leave a half of the disc empty by chance.
    PointBlock block;
    std::size_t n = 0;
    const auto leaf = leaf_at(
        {0, 0, 0}, block,
        [&](const Vec3d& p) { return p.x <= 0 && sq_length(p) < 0.09 && n++ < 6; }, flat);
    EXPECT_EQ(rims_of(leaf), PackedRims{});
}

/// A leaf on the upper face z = 0 of a solid whose other faces have the outer normals `walls`, all
/// through the line or the point that lies 0.05 from its centre. The walls have a quarter of its
/// points, so that its normal is its own.
CoveringSurfel leaf_at_edge(const std::vector<Vec3d>& walls, PointBlock& block) {
    block = {};
    const auto add = [&](const Vec3d& p, const Vec3d& n) {
        block.position.push_back(p);
        block.normal.push_back(to_float(n));
        block.id.push_back(block.id.size());
    };
    add({0, 0, 0}, {0, 0, 1});
    const auto behind_all = [&](const Vec3d& p, const Vec3d* but) {
        return std::all_of(walls.begin(), walls.end(), [&](const Vec3d& w) {
            return &w == but || dot(w, p) <= 0.05 * std::hypot(w.x, w.y) + 1e-12;
        });
    };
    const auto random = [](std::uint64_t i) { return 0.3 * random_at(7, i); };
    for (std::uint64_t i = 0; i < 240; ++i) {
        const Vec3d p{random(2 * i), random(2 * i + 1), 0};
        if (behind_all(p, nullptr)) add(p, {0, 0, 1});
    }
    for (const Vec3d& w : walls) {
        const Vec3d out = normalized(Vec3d{w.x, w.y, 0}), along{-out.y, out.x, 0};
        const Vec3d down = normalized(Vec3d{0, 0, -1} + w * w.z);
        for (std::uint64_t i = 0; i < 60; ++i) {
            const Vec3d p = out * 0.05 + along * random(1000 + 2 * i) +
                            down * (0.02 + 0.3 + random(1001 + 2 * i));
            if (behind_all(p, &w)) add(p, w);
        }
    }
    BallPoints<double> work;
    return fit_surfel(tree_of(block), {0, 0, 0}, {0, 0, 1}, 0.3, 1, false, 1e-10, work);
}

double reach_towards(const CoveringSurfel& leaf, const Rim& rim, const Vec3d& out) {
    const Frame<double>& f = leaf.fitted.surfel.frame;
    return rim.reach / dot(f.u_axis * rim.u + f.v_axis * rim.v, out);
}

TEST(LeafRim, EndsAtTheEdgeThatOtherPointsShow) {
    for (const double angle : {85.0, 95.0, 105.0}) {  // between the normals
        SCOPED_TRACE(angle);
        const double a = angle * std::numbers::pi / 180;
        PointBlock block;
        const auto leaf = leaf_at_edge({{std::sin(a), 0, std::cos(a)}}, block);
        const PackedRims rims = rims_of(leaf);
        ASSERT_TRUE(rims.any());
        const double reach = reach_towards(leaf, unpack_rim(rims.first), {1, 0, 0});
        EXPECT_GE(reach, 0.05 / 0.3 - 1e-6);
        EXPECT_LE(reach, 0.05 / 0.3 + 1.5 * kRimStep);  // 1.2 spacings would be 0.2 further
    }
}

TEST(LeafRim, ACornerHasTwo) {
    PointBlock block;
    const auto leaf = leaf_at_edge({{1, 0, 0}, {0, 1, 0}}, block);
    const PackedRims rims = rims_of(leaf);
    ASSERT_TRUE(rims.any());
    ASSERT_NE(rims.second, 0);
    for (const PackedRim rim : {rims.first, rims.second}) {
        const Rim r = unpack_rim(rim);
        const Vec3d out =
            leaf.fitted.surfel.frame.u_axis * r.u + leaf.fitted.surfel.frame.v_axis * r.v;
        EXPECT_GT(std::max(out.x, out.y), 0.98);
        EXPECT_LE(r.reach, 0.05 / 0.3 + 1.5 * kRimStep);
    }
}

/// A leaf of few points of a square's corner or straight edge on a grid; the edge's own points have
/// the mean normal of their faces.
CoveringSurfel leaf_of_edge_points(bool corner, Edges edges, PointBlock& block) {
    block = {};
    for (int x = -3; x <= 0; ++x)
        for (int y = -3; y <= (corner ? 0 : 3); ++y) {
            block.position.push_back({0.27 * x, 0.27 * y, 0});
            const Vec3d n{x == 0 ? 1.0 : 0.0, corner && y == 0 ? 1.0 : 0.0, 1};
            block.normal.push_back(to_float(normalized(n)));
            block.id.push_back(block.id.size());
        }
    BallPoints<double> work;
    return fit_surfel(tree_of(block), {0, 0, 0}, {0, 0, 1}, 0.3, 1, false, 1e-10, work, edges);
}

TEST(LeafRim, EndsAtTheEdgeWhoseOwnPointsItCovers) {
    PointBlock block;
    for (const bool corner : {false, true}) {
        SCOPED_TRACE(corner);
        EXPECT_EQ(rims_of(leaf_of_edge_points(corner, Edges::doubtful, block)), PackedRims{});
        const auto leaf = leaf_of_edge_points(corner, Edges::real, block);
        EXPECT_LE(leaf.covered.size(), 4u);
        const PackedRims rims = rims_of(leaf);
        ASSERT_TRUE(rims.any());
        EXPECT_EQ(rims.second != 0, corner);
        EXPECT_LE(unpack_rim(rims.first).reach, kRimStep + 1e-12);
        const Frame<double>& f = leaf.fitted.surfel.frame;
        for (const PackedRim rim : {rims.first, rims.second}) {
            if (rim == 0) continue;
            const Rim r = unpack_rim(rim);
            const Vec3d out = f.u_axis * r.u + f.v_axis * r.v;
            EXPECT_GT(corner ? std::max(out.x, out.y) : out.x, 0.98);
        }
    }
}

TEST(LeafRim, AWallThatRisesIsNoEdge) {
    // A concave edge: the leaf ends behind the wall, where nothing sees it;
    // the wall's points say nothing.
    PointBlock block;
    auto leaf = leaf_at_edge({{1, 0, 0}}, block);
    const std::size_t n_signs = leaf.edges.size();
    ASSERT_GT(n_signs, 10u);
    leaf.edges.clear();
    const PackedRims by_border = rims_of(leaf);
    for (std::size_t i = 0; i < block.size(); ++i)
        if (block.normal[i].x > 0.5f) block.normal[i].x = -1, block.position[i].z *= -1;
    BallPoints<double> work;
    const auto concave =
        fit_surfel(tree_of(block), {0, 0, 0}, {0, 0, 1}, 0.3, 1, false, 1e-10, work);
    ASSERT_GT(concave.edges.size(), 10u);
    EXPECT_EQ(rims_of(concave), by_border);
}

/// A leaf whose covered points fill its disc up to an edge at u = reach, which points below it
/// show.
CoveringSurfel leaf_before_edge(double reach) {
    CoveringSurfel leaf;
    for (double u = -0.9; u <= reach + 1e-9; u += 0.05)
        for (double v = -0.9; v <= 0.9; v += 0.05)
            if (u * u + v * v < 1)
                leaf.covered.push_back(
                    {0, 1, static_cast<float>(u), static_cast<float>(v), 0, true});
    leaf.edges.assign(5, {1, 0, static_cast<float>(reach)});
    leaf.edges_are_real = true;
    return leaf;
}

TEST(LeafRim, ALeafIsMadeSoSmallThatItEndsAtAnEdgeWhereNoRimDoes) {
    for (const double reach :
         {0.6, 0.64, 0.68}) {  // beyond the last rim, before what is drawn ends
        SCOPED_TRACE(reach);
        const double share = share_at_edges(leaf_before_edge(reach));
        EXPECT_LT(share, 1);
        EXPECT_LE(share * kHitTrim, reach + 0.02 + 1e-9);
        EXPECT_GT(share * kHitTrim, reach);  // no smaller than that
    }
    EXPECT_EQ(share_at_edges(leaf_before_edge(0.71)), 1) << "hardly drawn beyond it";
    EXPECT_EQ(share_at_edges(leaf_before_edge(0.8)), 1) << "not drawn so far";
    EXPECT_EQ(share_at_edges(leaf_before_edge(0.48)), 1) << "a rim ends it";
    CoveringSurfel none = leaf_before_edge(0.64);
    none.edges.clear();
    EXPECT_EQ(share_at_edges(none), 1) << "a border, not an edge";
}

}  // namespace
}  // namespace slim::test
