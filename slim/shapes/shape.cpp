#include "slim/shapes/shape.h"

#include "slim/base/error.h"
#include "slim/base/frame.h"
#include "slim/shapes/classic.h"
#include "slim/shapes/sculpture.h"

#include <array>
#include <cmath>

namespace slim {
namespace {

template <class F>
double value_at(const Vec3d& p) {
    return F::template value<double>(p);
}

template <class F>
Jet2 jet_at(const Vec3d& p) {
    return F::template value<Jet2>(
        {Jet2::variable(p.x, 0), Jet2::variable(p.y, 1), Jet2::variable(p.z, 2)});
}

using Foot = Vec3d (*)(const Vec3d&);

/// F's closed form; null without one.
template <class F>
constexpr Foot foot_of() {
    if constexpr (requires(const Vec3d& p) { F::foot(p); })
        return F::foot;
    else
        return nullptr;
}

Bbox box_of(const Vec3d& lo, const Vec3d& hi) {
    Bbox b;
    b.extend(lo);
    b.extend(hi);
    return b;
}

template <class F>
Shape closed(std::string_view name, const Vec3d& lo, const Vec3d& hi, double lipschitz,
             double band) {
    return {name, box_of(lo, hi), false, lipschitz, band, value_at<F>, jet_at<F>, foot_of<F>()};
}

template <class F>
Shape patch(std::string_view name, const Vec3d& lo, const Vec3d& hi, double lipschitz,
            double band) {
    return {name, box_of(lo, hi), true, lipschitz, band, value_at<F>, jet_at<F>, foot_of<F>()};
}

/// Sizes and bounds; the Lipschitz constants are checked by a test on samples of the ball.
std::array<Shape, 10> make_shapes() {
    return {patch<PlaneShape>("plane", {-1, -1, -0.1}, {1, 1, 0.1}, 1, 1),
            closed<SphereShape>("sphere", {-1, -1, -1}, {1, 1, 1}, 1, 0.9),
            closed<TorusShape>("torus", {-1.35, -1.35, -0.35}, {1.35, 1.35, 0.35}, 1, 0.3),
            closed<EllipsoidShape>("ellipsoid", {-1, -0.7, -0.4}, {1, 0.7, 0.4}, 1, 0.3),
            closed<CyclideShape>("cyclide", {-1.8, -1.5, -0.8}, {1.2, 1.5, 0.8}, 1.3, 0.2),
            patch<CylinderShape>("cylinder", {-1, -1, -1}, {1, 1, 1}, 1, 0.9),
            patch<ConeShape>("cone", {-1, -1, -1}, {1, 1, 1}, 1, 0.3),
            patch<MonkeyShape>("monkey", {-0.75, -0.75, -0.85}, {0.75, 0.75, 0.85}, 6.8, 1),
            closed<BumpyShape>("bumpy", {-1.016782, -1.048759, -1.00001},
                               {1.016782, 1.048759, 1.00001}, 1.25, 0.1),
            closed<SculptureShape>("sculpture", {-0.755, -1, -0.56}, {0.755, 1.2, 0.46}, 1.75,
                                    0.02)};
}

const std::array<Shape, 10>& shapes() {
    static const std::array<Shape, 10> table = make_shapes();
    return table;
}

}  // namespace

std::span<const Shape> all_shapes() { return shapes(); }

std::vector<std::string> shape_names() {
    std::vector<std::string> names;
    for (const Shape& s : shapes()) names.emplace_back(s.name);
    return names;
}

const Shape& find_shape(std::string_view name) {
    std::string known;
    for (const Shape& s : shapes()) {
        if (s.name == name) return s;
        known += known.empty() ? "" : " ";
        known += s.name;
    }
    throw ConfigError("shape \"" + std::string(name) +
                      "\" is not known; expected one of: " + known);
}

SurfacePoint surface_point(const Jet2& f) {
    const Vec3d g = f.gradient();
    const double len = length(g);
    if (!(len > 0) || !std::isfinite(len)) return {};
    // The shape operator is the Hessian in the tangent plane over |grad f|.
    const Frame<double> frame = frame_from_normal(g / len);
    const Vec3d hu = f.hessian_times(frame.u_axis), hv = f.hessian_times(frame.v_axis);
    const double uu = dot(frame.u_axis, hu) / len, uv = dot(frame.v_axis, hu) / len,
                 vv = dot(frame.v_axis, hv) / len;
    const double mean = 0.5 * (uu + vv), half = std::hypot(0.5 * (uu - vv), uv);
    return {g / len, mean + half, mean - half};
}

}  // namespace slim
