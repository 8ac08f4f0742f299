#pragma once

#include "slim/base/simd.h"
#include "slim/base/vec.h"
#include "slim/blend/curvature.h"
#include "slim/blend/ray_surfel.h"
#include "slim/model/surfel.h"

#include <optional>
#include <span>

namespace slim {

/// The highest derivatives that a blend is to sum.
enum class Derivatives { first, second, third };

/// Sums of eqs (6) and (7) (Ohtake 2005, sec. 3) along one ray, world axes.
struct BlendSums {
    double weight = 0;          ///< sum G
    double t = 0;               ///< sum G t
    Vec3d gradient;             ///< sum G grad f, f scaled by rho (|grad f| >= 1)
    SymmetricMatrix hessian{};  ///< sum G Hess f, same scale; 1 / length
    SymmetricTensor third{};    ///< sum G D3 f, same scale; 1 / length^2
    int count = 0;              ///< supporters that took part
};

/// Cosine that two gradients must have where an edge or a corner is near: less than the least angle
/// between the sheets of a surfel (slim/fit/sharp_clusters.h),
/// so that faces are not blended over their edge.
inline constexpr double kSharpGate = 0.866;

/// Which supporters belong to what is seen: those whose gradient agrees with this one (NUMERICS
/// 4.4), closely in models with sharp surfels: there the leaves of two faces meet at an edge, and
/// either may reach beyond it.
struct Gate {
    Vec3d gradient;
    bool close = false;  ///< within kSharpGate

    Gate(const Vec3d& g, bool closely = false) : gradient(g), close(closely) {}
    bool admits(const Vec3d& g) const {
        const double agreement = dot(g, gradient);
        return close ? agreement > kSharpGate * length(g) * length(gradient) : agreement > 0;
    }
};

/// Adds one surfel to the blend around the ray point of parameter t_guess. The surfel takes part if
/// the guess lies in its ball, if f has a root on the ray inside the *full* ball (the one nearest
/// the guess counts; of a sharp surfel on the joined surface) no farther than 0.3 rho from the
/// guess, and if the gate admits its gradient there, this side of its rim. G at |q_i - c_i| /
/// rho_i, less towards the rim. Returns whether it took part.
/// Departs from the paper, which blends any root: where a ball holds another sheet or its
/// polynomial runs out of its data, the mean was drawn far off (nefertiti, T 0.005: L2 4.0e-4 to
/// 3.3e-4 L, maximum 1.8e-2 to 4.6e-3; happy_stand_raw L2 7.9e-4 to 6.4e-4). The cover leaves such
/// points to others by the same measure.
bool add_supporter(const Ray& ray, double t_guess, const Gate& gate, const Surfel& surfel,
                   Derivatives wanted, BlendSums& sums);

/// Whether a first hit is in doubt: held by less weight than a covered point has, it lies where its
/// surfel's polynomial may overshoot a silhouette (raytrace/project/notes/0011).
/// weight: sum G of the blend.
template <class T>
[[gnu::always_inline]] inline auto is_in_doubt(const T& weight) {
    return weight < constant<T>(kCoverage);
}

/// Whether a first hit in doubt does not count: the surfels that the ray passes over weigh four
/// times what it is blended of, and more. passing: sum of their passing_weight.
template <class T>
[[gnu::always_inline]] inline auto is_outvoted(const T& weight, const T& passing) {
    return passing > constant<T>(4) * weight;
}

/// The weight with which a surfel says that the ray passes over it at t_guess, 0 if it does not:
/// the guess lies in its ball outside of its surface, f has no root there that add_supporter would
/// take for the guess, and the gate admits its gradient at the guess (of a sharp surfel that of one
/// of its sheets).
double passing_weight(const Ray& ray, double t_guess, const Gate& gate, const Surfel& surfel);

/// How often a hit that was outvoted gives way to the next one along the ray, at the most.
inline constexpr int kMostOutvoted = 16;

/// How far beyond a first hit that was outvoted the next one lies at least, in rho of its surfel.
inline constexpr double kNextHit = 1e-3;

/// First root of the surfel on the ray inside its ball shrunk by `trim` (stage 1 of the paper), at
/// t >= t_min; nothing if that lies beyond its rim. `gradient` receives that of f at the root
/// (world, times rho).
std::optional<double> first_hit(const Ray& ray, const Surfel& surfel, double t_min, double trim,
                                Vec3d& gradient);

/// A point put on the model.
struct Projection {
    Vec3d point;             ///< on the ray, frame of the job
    double t = 0;            ///< signed distance along the direction given
    Vec3d normal;            ///< unit, outwards
    Vec3d gradient;          ///< blended, over the weight
    double weight = 0;       ///< sum G, the coverage of the point
    int n_supporters = 0;
    Curvature curvature;     ///< only if asked; zeros otherwise
};

/// Projects p along the unit direction n onto the model (NUMERICS 5.5): t = sum G t_i / sum G over
/// the supporters, |p - c| < rho, whose root nearest t = 0 lies in their ball and whose gradient
/// there has n . grad f > 0; rims count unless they leave nobody. Where one of them is sharp, the
/// root nearest p says which face counts (Gate), of supporters with a weight of 0.002 and more if
/// there are any. `supporters` may hold more surfels than support p; order fixes the last bits.
/// Nothing if no surfel takes part (count the point as missed). Cost: O(supporters), no allocation.
std::optional<Projection> project_along(const Vec3d& p, const Vec3d& n,
                                        std::span<const Surfel* const> supporters,
                                        bool want_curvature = false);

/// The gradient of a surfel's function at p (of a sharp one that of the sheet that says its value),
/// times G at |p - c| / rho; zero outside its ball.
Vec3d weighted_gradient(const Surfel& surfel, const Vec3d& p);

/// The model's own outward unit normal around p: that of the sum of the supporters'
/// weighted_gradient. For points that bring no normal. Nothing if p has no supporter.
std::optional<Vec3d> normal_at(const Vec3d& p, std::span<const Surfel* const> supporters);

}  // namespace slim
