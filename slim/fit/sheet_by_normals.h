#pragma once

#include "slim/base/frame.h"
#include "slim/fit/ball_points.h"
#include "slim/fit/local_fit.h"

#include <optional>

namespace slim {

/// The quadric of a sheet of too few points for one (notes/0013): weighted least squares of their
/// heights and, where they have normals, of the slopes that these give. A normal counts for two
/// points, so that five or six that a face has near an edge show how it curves.
/// points   with normals where they are the sheet's alone, zero elsewhere: an edge's own have the
///          mean of its faces'
/// returns  a fit of degree 2, eps^2 about the heights; nothing if heights and slopes together are
///          not enough for its coefficients (K + 2 effective ones, 6 points), have no rank,
///          or make it too steep
/// cost     two passes over the points
template <class T>
std::optional<LocalFit> fit_by_normals(const BallPoints<T>& points, const Frame<double>& frame);

}  // namespace slim
