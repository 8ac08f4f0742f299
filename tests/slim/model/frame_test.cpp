#include "slim/base/frame.h"

#include "slim/model/surfel_tree.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slim::test {
namespace {

/// Directions from everywhere, from beside the equator n.z = 0 (where the octahedron folds and the
/// frame's sign turns), and from beside the axes.
std::vector<Vec3d> hard_directions() {
    std::vector<Vec3d> out;
    for (std::uint64_t i = 0; i < 20000; ++i) out.push_back(random_direction(1, i));
    for (const double tiny :
         {0.0, -0.0, 1e-300, 1e-18, 1.2e-16, 2.3e-16, 1e-12, 1e-9, 3e-8, 1e-7, 1e-5})
        for (const double sign : {1.0, -1.0}) {
            for (std::uint64_t i = 0; i < 500; ++i) {
                Vec3d n = random_direction(2, i);
                n.z = sign * tiny;
                out.push_back(normalized(n));
            }
            for (std::size_t axis = 0; axis < 3; ++axis)
                for (const double side : {1.0, -1.0})
                    for (std::uint64_t i = 0; i < 50; ++i) {
                        Vec3d n = random_in_cube(3, i) * (sign * tiny);
                        n[axis] = side;
                        out.push_back(normalized(n));
                    }
        }
    return out;
}

void expect_orthonormal(const Frame<double>& f) {
    EXPECT_NEAR(dot(f.u_axis, f.v_axis), 0, 1e-15);
    EXPECT_NEAR(dot(f.u_axis, f.normal), 0, 1e-15);
    EXPECT_NEAR(dot(f.v_axis, f.normal), 0, 1e-15);
    EXPECT_NEAR(length(f.u_axis), 1, 1e-15);
    EXPECT_NEAR(length(f.v_axis), 1, 1e-15);
    EXPECT_NEAR(length(cross(f.u_axis, f.v_axis) - f.normal), 0, 2e-15);
}

TEST(Frame, IsOrthonormalAndRightHandedForEveryNormal) {
    for (const Vec3d& n : hard_directions()) {
        SCOPED_TRACE(testing::Message() << n.x << ' ' << n.y << ' ' << n.z);
        expect_orthonormal(frame_from_normal(n));
        if (HasFailure()) return;
    }
}

TEST(Frame, LocalAndWorldAreInverse) {
    for (std::uint64_t i = 0; i < 100; ++i) {
        const Frame<double> f = frame_from_normal(random_direction(4, i));
        const Vec3d x = random_in_cube(5, i);
        EXPECT_NEAR(length(f.world_from_local(f.local_from_world(x)) - x), 0, 1e-15);
        EXPECT_NEAR(f.local_from_world(f.normal).z, 1, 1e-15);
    }
}

TEST(RoundNormal, KeepsTheDirectionToFloatPrecision) {
    for (const Vec3d& n : hard_directions()) {
        const Vec3d r = round_normal(n);
        ASSERT_NEAR(length(r), 1, 1e-15);
        // Half a step of a float below 1 is 3e-8 in each coordinate; the octahedron's faces stretch
        // by at most 3 when they become the sphere.
        ASSERT_LT(length(r - n), 1.3e-7) << n.x << ' ' << n.y << ' ' << n.z;
    }
}

TEST(RoundNormal, GivesWhatTheFilesFloatsGiveBack) {
    // A fit is made in the frame of the rounded normal and written as two floats: the frame that
    // the file gives back must be that frame, bit by bit, or the surface turns or jumps.
    for (const Vec3d& n : hard_directions()) {
        SCOPED_TRACE(testing::Message() << n.x << ' ' << n.y << ' ' << n.z);
        const Vec3d once = round_normal(n);
        const Octahedral first = octahedral_from_normal(n), second = octahedral_from_normal(once);
        ASSERT_EQ(first.s, second.s);
        ASSERT_EQ(first.t, second.t);
        const Vec3d twice = round_normal(once);
        ASSERT_EQ(once, twice);
        ASSERT_EQ(std::signbit(once.z), std::signbit(twice.z));
        ASSERT_EQ(frame_from_normal(once).u_axis, frame_from_normal(twice).u_axis);
    }
}

}  // namespace
}  // namespace slim::test
