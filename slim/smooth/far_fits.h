#pragma once

#include "slim/tree/ball_index.h"

#include <optional>
#include <vector>

namespace slim {

/// A fit made anew, and how far from its middle a point may be that has its foot there.
struct FarFit {
    Surfel surfel;
    double off = 0;  ///< along the normal, length: what its noise explains
};

/// Where points go that are outside the balls of all fits, as thick noise leaves them.
class FarFits {
public:
    struct Foot {
        Vec3d point, normal;  ///< the latter of the fit, in its middle
        double off = 0;       ///< FarFit::off of the fit
    };

    explicit FarFits(const std::vector<FarFit>& fits);

    /// Foot of a point on the nearest fit's surface along the fit's normal, of those that do not
    /// face away from `normal` (zero: any) and whose ball of radius hypot(support radius, off)
    /// holds it. Nothing if there is none.
    std::optional<Foot> foot(const Vec3d& p, const Vec3d& normal) const;

private:
    BallIndex balls_;
    std::vector<double> off_;  // of the fits, in the index's order
};

}  // namespace slim
