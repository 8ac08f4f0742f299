#pragma once

#include "slim/base/vec.h"
#include "slim/normals/outside.h"

#include <algorithm>
#include <cmath>

namespace slim {

/// What a surface of scattered points with normals encloses, by the divergence theorem: the sum of
/// area times arm . normal is three times the volume, positive if normals face outwards, however
/// slender the shape is. Whether that is more than chance is asked of the sum's own scatter and of
/// what holes may hide (notes/0007).
class Enclosure {
public:
    /// First of all points: a length whose square is as the area that the point stands for.
    void measure(double size) { ++n_, size_sum_ += size; }

    /// Then of each again. arm: from a place that is the same for all
    void add(const Vec3d& arm, const Vec3d& normal, double size) {
        // What stands for 100 times the usual area is a stray far off.
        const double s = std::min(size, 10 * size_sum_ / n_), area = s * s;
        const double through = area * dot(arm, normal);
        area_ += area, sq_reach_ += area * sq_length(arm), normals_ += normal * area;
        flux_ += through, sq_flux_ += through * through;
    }

    /// Positive: normals face outwards; 0: it encloses nothing for sure.
    double clear_flux() const {
        const double hole = length(normals_);
        const bool is_closed = hole < kSmallHole * area_;
        const bool is_sure = std::abs(flux_) > kSure * std::sqrt(sq_flux_) &&
                             std::abs(flux_) * std::sqrt(area_) > hole * std::sqrt(sq_reach_);
        return is_closed && is_sure ? flux_ : 0;
    }

private:
    static constexpr double kSure = 4;  ///< standard deviations

    double n_ = 0, size_sum_ = 0;
    double area_ = 0, sq_reach_ = 0;  ///< the latter: of area times squared arm
    double flux_ = 0, sq_flux_ = 0;   ///< of area times arm . normal, and of its square
    Vec3d normals_;                   ///< of area times normal
};

}  // namespace slim
