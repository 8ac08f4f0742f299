#pragma once

#include "slim/fit/mdl_energy.h"
#include "slim/fit/radius_ladder.h"
#include "slim/fit/sharp_fit.h"
#include "slim/neighbors/point_pyramid.h"

#include <optional>

namespace slim {

/// Share of contrary normals of a cloud up to which one of them says "edge".
inline constexpr double kCleanNormals = 1e-3;

/// Bytes of a surfel of so many sheets in the file over those of one sheet (quadratic; the other
/// degrees differ by less than a tenth).
double sharp_price(std::size_t n_sheets);

/// Largest eps^2 of sheets of a ball that explain its points, length^2.
double sq_roughest(double radius, double noise_variance);

/// Searches a radius at which joined sheets beat the single height field that the
/// ladder found (notes/0002): E = eps^2 + lambda (T L / rho)^2 price, at steps of sqrt(1/g) upwards
/// of the finest radius that holds enough points.
class SharpSearch {
public:
    struct Choice {
        double radius;
        std::size_t n_sheets;
    };

    /// typical_variance: noise of a typical place, length^2 (is_filled)
    SharpSearch(const PointPyramid& points, const MdlEnergy& energy, double typical_variance,
                double root_radius, int degree, const LadderRules& rules)
        : points_(points), energy_(energy), typical_variance_(typical_variance),
          root_radius_(root_radius), degree_(degree), rules_(rules) {}

    /// The largest radius whose energy is no higher than the least upper bound of all tried, if
    /// that is below the energy of the smooth choice. `work` is as RadiusLadder::choose left it,
    /// with look_for_edges. Cost: nothing where no edge is in sight, else about ten balls.
    std::optional<Choice> choose(const Vec3d& center, const RadiusChoice& smooth,
                                 LadderWork& work) const;

    /// For a forced leaf that no sheets can mend, beside an edge of a cloud with clean normals: its
    /// radius, cut down to the nearest point with a contrary normal (by g^2 at most; of a tip's own
    /// point, whose ball is of other faces, to a tenth of the way to the nearest), so that it does
    /// not stand out over the edge as a disc. Else the choice's own radius.
    double clear_radius(const Vec3d& center, const Vec3d& normal, const RadiusChoice& smooth,
                        LadderWork& work) const;

private:
    struct Rung {
        Choice choice;
        double energy, upper, sq_error;
    };
    std::optional<Rung> evaluate(double radius, std::size_t& level, const Vec3d& center,
                                 LadderWork& work) const;

    const PointPyramid& points_;
    MdlEnergy energy_;
    double typical_variance_;
    double root_radius_;
    int degree_;
    LadderRules rules_;
};

}  // namespace slim
