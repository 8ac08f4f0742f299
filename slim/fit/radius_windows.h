#pragma once

#include "slim/fit/radius_ladder.h"

namespace slim {

/// The radius by the paper's windows of three radii (Ohtake 2005 sec. 2, eqs (4) and (5)),
/// for comparison with
/// RadiusLadder (notes/0006). The window of level k is rho_0 (g^(k+1), g^k, g^(k-1)) = (l, m, r):
///     E(l) > E(m) < E(r) and eps(l) < eps(m) < eps(r)      a leaf, at the minimum of E in the
///     window E(r) <= min(E(l), E(m)) (1 + 1e-3), coarsest window  a saturated leaf at r
///     fewer than 2 K points at l, or l below least_radius  a forced leaf at r
///     otherwise                                            the next finer window
/// Departs from the paper: a window first slides up while E falls that way, so that a point whose
/// minimum lies above the level at which it is looked at is not lost to the finest level
/// (NUMERICS 3.3).
class RadiusWindows {
public:
    /// As RadiusLadder; of the rules only `sample` counts.
    RadiusWindows(const PointPyramid& points, const MdlEnergy& energy, double root_radius,
                  double least_radius, int degree, const LadderRules& rules)
        : points_(points), energy_(energy), root_radius_(root_radius), least_radius_(least_radius),
          degree_(degree), sample_(rules.sample) {}

    /// first: the window to begin with, whose r is root_radius g^first.
    /// Cost: a fit of about rules.sample points a window, eight more for a leaf.
    RadiusChoice choose(const Vec3d& center, const Vec3d& normal, int first,
                        LadderWork& work) const;

private:
    class Search;

    const PointPyramid& points_;
    MdlEnergy energy_;
    double root_radius_, least_radius_;
    int degree_;
    std::size_t sample_;
};

}  // namespace slim
