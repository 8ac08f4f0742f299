#include "slim/cover/leaf_rim.h"

#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <cmath>

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
    EXPECT_EQ(rim_of(leaf), 0);
}

TEST(LeafRim, EndsALittleBeyondABorderInItsDirection) {
    for (const double angle : {0.0, 0.7, 2.0, 4.0}) {
        SCOPED_TRACE(angle);
        const Vec3d out{std::cos(angle), std::sin(angle), 0};
        PointBlock block;
        const auto leaf =
            leaf_at({0, 0, 0}, block, [&](const Vec3d& p) { return dot(p, out) <= 0.06; }, flat);
        const Surfel& s = leaf.fitted.surfel;
        const Rim rim = unpack_rim(rim_of(leaf));
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

TEST(LeafRim, FewPointsAreNoRim) {
    // Six points may leave a half of the disc empty by chance.
    PointBlock block;
    std::size_t n = 0;
    const auto leaf = leaf_at({0, 0, 0}, block,
                              [&](const Vec3d& p) { return p.x <= 0 && sq_length(p) < 0.09 && n++ < 6; }, flat);
    EXPECT_EQ(rim_of(leaf), 0);
}

}  // namespace
}  // namespace slim::test
