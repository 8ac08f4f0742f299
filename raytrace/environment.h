#pragma once

#include "slim/base/vec.h"

#include <array>
#include <cstddef>
#include <vector>

namespace slim {

/// Light from all around, as a lat-long picture in linear Rec.709: its top row looks up, its middle
/// along -z of its axes, its right along +x.
///
/// Light that a diffuse surface sends back and light within a glossy lobe are summed once over the
/// whole picture, for 64 x 32 directions, and interpolated: within 0.5 % of the brightest of the
/// sums themselves (tests), of any map: nine spherical harmonics (Ramamoorthi and Hanrahan 2001)
/// ring about small bright lamps.
class Environment {
public:
    /// rgb: 3 width height values, rows from the top. `axes`: right, up and back of the picture in
    /// the world, unit; turned about up by turn_deg, counterclockwise seen from above. Averaged to
    /// at most 256 x 128 for the sums, and scaled so that its mean over all directions is 0.5 (no
    /// light at all stays dark).
    /// cost: 70 million products
    Environment(int width, int height, std::vector<float> rgb, const std::array<Vec3d, 3>& axes,
                double turn_deg);

    /// A built-in studio: a large lamp at the upper left of the front view, a smaller cool one at
    /// the right, a bright sky over a warm floor.
    static Environment studio(const std::array<Vec3d, 3>& axes, double turn_deg);

    /// All three take a unit direction in the world; of the picture itself bilinear.
    Vec3f radiance(const Vec3f& toward) const;
    Vec3f diffuse(const Vec3f& normal) const;  ///< irradiance / pi
    Vec3f glossy(const Vec3f& toward) const;   ///< mean over a cosine^32 lobe

private:
    struct Table {
        int width = 0, height = 0;
        std::vector<Vec3f> texels;
        Vec3f at(float u, float v) const;
    };
    void normalize();
    void sum_lobes();
    Vec3f look_up(const Table& table, const Vec3f& direction) const;

    Table map_, diffuse_, glossy_;
    std::array<Vec3f, 3> axes_;
};

}  // namespace slim
