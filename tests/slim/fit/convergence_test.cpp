#include "slim/shapes/foot_point.h"
#include "tests/slim/extremes/extremes_support.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace slim::test {
namespace {

/// Root mean square errors of fits of one radius: position, normal, mean curvature, its third-order
/// e1.
struct FitErrors {
    double position = 0, normal = 0, mean = 0, third = 0;
};

/// dk1/dt1 of a shape at a point of it by central differences along the surface.
double true_e1(const Shape& shape, const Vec3d& p, const Vec3d& t1) {
    constexpr double step = 1e-4;  // error step^2 times fifth derivatives, rounding 1e-15 / step
    const auto k1 = [&](double s) {
        return surface_point(shape.jet(foot_point(shape, p + t1 * s).point)).k1;
    };
    return (k1(step) - k1(-step)) / (2 * step);
}

/// Adds the squared errors of a surfel at one place (u, v) of its ball.
void add_errors(const Shape& shape, const Surfel& s, double u, double v, FitErrors& sum) {
    const auto sq = [](double x) { return x * x; };
    const Vec3d local{u, v, s.polynomial.value(u, v)};
    const Vec3d p = s.center + s.frame.world_from_local(local) * s.support_radius;
    const FootPoint foot = foot_point(shape, p);
    const SurfacePoint truth = surface_point(shape.jet(foot.point));
    const ThirdOrder found = third_order(height_jet(s, u, v));
    sum.position += sq(foot.signed_distance);
    sum.normal += sq_length(s.frame.world_from_local(found.normal) - truth.normal);
    sum.mean += sq((found.k1 + found.k2 - truth.k1 - truth.k2) / 2);
    sum.third += sq(found.e1 - true_e1(shape, foot.point, s.frame.world_from_local(found.t1)));
}

/// Errors at random places of random balls on the bumpy sphere, whose curvatures are of size 1
/// to 3.
FitErrors errors_of(int degree, double radius) {
    const Shape& shape = find_shape("bumpy");
    constexpr std::uint64_t n_balls = 24, n_places = 12;
    const Cloud centers = sampled("bumpy", n_balls, 3);
    FitErrors sum;
    for (std::uint64_t i = 0; i < n_balls; ++i) {
        const Surfel s = patch_surfel(shape, centers.positions[i], radius, degree, 1500, i);
        EXPECT_EQ(s.degree, degree);
        for (std::uint64_t k = 0; k < n_places; ++k)
            add_errors(shape, s, 0.6 * random_at(i, 1000 + 2 * k), 0.6 * random_at(i, 1001 + 2 * k),
                       sum);
    }
    const double n = n_balls * n_places;
    return {std::sqrt(sum.position / n), std::sqrt(sum.normal / n), std::sqrt(sum.mean / n),
            std::sqrt(sum.third / n)};
}

TEST(Convergence, OrdersOfAFitAreThoseOfItsDegree) {
    // NUMERICS section 8: position d + 1, normal d, mean curvature d - 1, third derivatives d - 2,
    // at a generic place of the ball. At radii 0.08 and 0.02 of a surface with features of size 0.3
    // the next term of the error adds up to (0.08 / 0.3)^2 = 7 %, or log(1.07) / log(4) = 0.05 of
    // the exponent.
    for (int degree = 1; degree <= 3; ++degree) {
        SCOPED_TRACE(degree);
        const FitErrors coarse = errors_of(degree, 0.08), fine = errors_of(degree, 0.02);
        const auto order = [](double a, double b) { return std::log(a / b) / std::log(4.0); };
        EXPECT_NEAR(order(coarse.position, fine.position), degree + 1, 0.1);
        EXPECT_NEAR(order(coarse.normal, fine.normal), degree, 0.1);
        EXPECT_NEAR(order(coarse.mean, fine.mean), degree - 1, 0.1);
        if (degree == 1) continue;  // no third derivative, no second one either
        EXPECT_NEAR(order(coarse.third, fine.third), degree - 2, 0.1);
    }
}

}  // namespace
}  // namespace slim::test
