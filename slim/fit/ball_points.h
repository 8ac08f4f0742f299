#pragma once

#include "slim/base/simd.h"
#include "slim/model/weight_kernel.h"
#include "slim/neighbors/point_tree.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace slim {

/// The points of one ball, world axes, relative to its centre and divided by its radius; a
/// workspace that a thread keeps. Arrays are padded to whole SIMD groups by points of zero weight
/// (sq = 2).
template <class T>
struct BallPoints {
    std::vector<T> x, y, z;         ///< |.| < 1, but of a disc
    std::vector<T> sq;              ///< x^2 + y^2 + z^2; of a disc that of the foot
    std::vector<float> nx, ny, nz;  ///< unit normals, or zero
    std::vector<std::uint32_t> index;  ///< in the tree they came from; of doubles only
    std::size_t n = 0;              ///< without padding
    double radius = 0;
    FitWeight weight = FitWeight::gauss;  ///< that fits to it use; gathering leaves it as it is
    bool normals_count = false;  ///< fits follow the normals, too
                                 ///< (slim/fit/notes/0007); left as it is as well

    Vec3d place(std::size_t i) const { return {x[i], y[i], z[i]}; }
    Vec3d normal(std::size_t i) const { return {nx[i], ny[i], nz[i]}; }
    std::size_t padded() const {
        constexpr std::size_t lanes = stdx::native_simd<T>::size();
        return (n + lanes - 1) / lanes * lanes;
    }
};

/// Fills `out` with the tree's points within `radius` of `center` (|p - c| < radius), in tree
/// order; as doubles to the last bit of the block's positions.
/// Cost: the buckets that meet the ball, 2 to 4 times its points.
template <class T>
void gather_ball(const PointTree& tree, const Vec3d& center, double radius, BallPoints<T>& out);

/// Bits of the points that are wanted, of the bucket whose first is the tree's first-th: bit k
/// stands for first + k.
using WantedOfBucket = std::function<std::uint64_t(std::size_t first)>;

/// The same of those of the ball's points that are wanted.
void gather_wanted(const PointTree& tree, const Vec3d& center, double radius,
                   const WantedOfBucket& wanted, BallPoints<double>& out);

/// Fills `out` with a disc: the points within `ball_radius` of the centre whose feet in the plane
/// normal to `normal` are within `radius` of it. Coordinates are over `radius` and may be beyond 1
/// along the normal; sq is that of the feet. Points whose own normals' cosine to the disc's is less
/// than `least_cos` are left out. Cost: the buckets that meet the ball.
void gather_disc(const PointTree& tree, const Vec3d& center, const Vec3d& normal, double radius,
                 double ball_radius, float least_cos, BallPoints<float>& out);

/// The points of a ball within a smaller radius about the same centre; `out` may be the ball
/// itself. Cost: a pass by lanes.
template <class T>
void shrink_ball(const BallPoints<T>& ball, double radius, BallPoints<T>& out);

/// Number of the tree's points in the ball, by their floats, at most `enough` counted.
std::size_t count_in_ball(const PointTree& tree, const Vec3d& center, double radius,
                          std::size_t enough);

}  // namespace slim
