#pragma once

#include "slim/fit/ball_points.h"
#include "slim/fit/fitted_sheets.h"
#include "slim/fit/sharp_fit.h"

namespace slim {

/// Fills in what a joined fit is worth: sq_error over the points whose normal some sheet has,
/// n_effective, n_points and n_off. noise: of the points, over the radius.
/// cost  two passes over the points; no allocation once the workspace has grown
template <class T>
void measure_sharp(const BallPoints<T>& points, double noise, FittedSheets& sheets,
                   SharpWork<T>& work);

}  // namespace slim
