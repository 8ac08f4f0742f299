#pragma once

#include "slim/base/bbox.h"
#include "slim/shapes/jet2.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace slim {

/// An analytic surface f = 0, negative inside, normal = gradient, outwards.
struct Shape {
    std::string_view name;
    /// Box that holds the surface; an open shape (plane, cylinder, ...) is cut off at it.
    Bbox bounds;
    bool open = false;
    /// |grad f| <= lipschitz wherever f > -band in the ball around `bounds`: a point there is at
    /// least min(|f|, band) / lipschitz away from the surface.
    double lipschitz = 1;
    double band = 0.05;
    double (*value)(const Vec3d&) = nullptr;
    Jet2 (*jet)(const Vec3d&) = nullptr;
    /// The nearest point of f = 0 (of an open shape: also beyond its box), where there is a closed
    /// form; else null.
    Vec3d (*foot)(const Vec3d&) = nullptr;
};

/// All shapes, in the order of the manual.
std::span<const Shape> all_shapes();
std::vector<std::string> shape_names();

/// The shape of that name; throws ConfigError listing the names.
const Shape& find_shape(std::string_view name);

/// What the surface through a point looks like: unit normal along the gradient and principal
/// curvatures k1 >= k2 in 1/length, positive where convex (sphere of radius r: +1/r).
struct SurfacePoint {
    Vec3d normal;
    double k1 = 0, k2 = 0;
};

/// From value, gradient and Hessian of f at a point of the surface (of the level set through any
/// other). At a vanishing gradient (cone apex) normal and curvatures are zero.
SurfacePoint surface_point(const Jet2& f);

}  // namespace slim
