#pragma once

#include "slim/base/frame.h"
#include "slim/fit/ball_normal.h"
#include "slim/fit/ball_points.h"
#include "slim/fit/local_fit.h"

#include <cstdint>
#include <span>

namespace slim {

/// What becomes of a sheet in a ball that also holds points of another side: at a fold it ends at a
/// line, beside another sheet it does not (slim/cover/notes/0017).
enum class SheetEnd : std::uint8_t {
    alone,     ///< no points of another side
    ends,      ///< in the ball, or its points are no sheet
    in_doubt,  ///< too few points to tell; a larger ball may
    goes_on,   ///< its points fill the disc and are explained
};

/// That of a straight border 0.35 rho off; 0.22 rho off it is twice as much.
inline constexpr double kLeanOfBorder = 0.04;

/// What is known of a fit to the points that face its way.
struct SheetFit {
    const Frame<double>& frame;
    const LocalFit& fit;
    double sq_explained;   ///< eps^2 that noise and price explain, length^2
    double tolerance;      ///< farther off it is another side's, length
    double contrary_share; ///< of normals that noise turns out of a height field
    double most_lean = kLeanOfBorder;  ///< of its points' mean off the centre, over rho
};

/// points: without those set aside, which the fit left out.
/// Cost: a pass over the points.
template <class T>
SheetEnd end_of_sheet(const BallPoints<T>& points, std::span<const SetAside<T>> aside,
                      const SheetFit& sheet);

}  // namespace slim
