#include "slim/cover/sound_normal.h"

#include "slim/fit/ball_normal.h"

#include <algorithm>

namespace slim {
namespace {

constexpr double kAgree = 0.85;  // length of the mean of unit normals from which on they agree
constexpr double kFewest = 4;    // others that there must be

}  // namespace

Vec3d sound_normal(const PointTree& points, std::uint32_t place) {
    const Vec3d given = to_double(points.normal(place));
    if (!(sq_length(given) > 0)) return {};
    const Vec3d own = normalized(given);
    const std::size_t first = place / PointTree::kBucket * PointTree::kBucket,
                      end = std::min(first + PointTree::kBucket, points.size());
    Vec3d sum;
    double n = 0;
    for (std::size_t i = first; i < end; ++i) {
        const Vec3d other = to_double(points.normal(i));
        if (i == place || !(sq_length(other) > 0)) continue;
        sum += normalized(other), ++n;
    }
    if (n < kFewest || !(length(sum) > kAgree * n)) return own;
    const Vec3d mean = normalized(sum);
    const double cos = dot(own, mean);
    const bool is_across = cos >= static_cast<double>(kOtherSideCos) &&
                           cos < static_cast<double>(kLeastCos);
    return is_across ? mean : own;
}

}  // namespace slim
