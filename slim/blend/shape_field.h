#pragma once

#include "slim/model/height_hessian.h"
#include "slim/model/planar_tensor.h"
#include "slim/model/polynomial.h"

namespace slim {

/// The shape operator of a leaf's surface over its ball, times rho: mean + slopes (u, v) at (u, v),
/// in the frame that the shortest turn brings from the leaf's normal to the surface's there.
struct ShapeField {
    PlanarTensor<2> mean{};
    PlanarTensor<3> slopes{};
};

/// The mean under G of the shape operator of w = P(u, v): by four places at the radius whose square
/// is the mean square of G's. Cost: 200 operations.
PlanarTensor<2> mean_shape_of(const Polynomial<double>& p);

/// The second derivatives that P would have with that shape operator and its own slopes, each a
/// quadric in u and v: by three places on either axis and four beside them (Gauss and Hermite's
/// places for the weight G).
HeightHessian hessian_of(const ShapeField& shape, const Polynomial<double>& p);

}  // namespace slim
