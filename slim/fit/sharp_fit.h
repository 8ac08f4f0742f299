#pragma once

#include "slim/base/frame.h"
#include "slim/fit/ball_points.h"
#include "slim/fit/local_fit.h"
#include "slim/fit/sharp_joins.h"
#include "slim/model/surfel.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace slim {

/// Height fields joined by max and min, fitted to one ball (notes/0002).
struct SharpFit {
    std::size_t n_sheets = 0;
    std::array<Frame<double>, kMostSheets> frame;  ///< normal: as the file will give it back
    std::array<Polynomial<double>, kMostSheets> polynomial;
    Join outer = Join::max, inner = Join::max;
    int degree = 1;          ///< the highest of the sheets
    double sq_error = 0;     ///< eps^2 about the joined surface, unbiased as LocalFit's, length^2
    double n_effective = 0;  ///< (sum G)^2 / sum G^2
    int n_coefficients = 0;  ///< of all sheets
    std::size_t n_points = 0;
    /// points off the joined surface, or off the sheet whose normal they have
    std::size_t n_off = 0;

    Surfel surfel(const Vec3d& center, double radius) const;
};

/// Workspace of one thread.
template <class T>
struct SharpWork {
    BallPoints<T> part;              ///< the points of one sheet
    std::vector<std::uint8_t> sheets;  ///< of each point of the ball: bit i, it belongs to sheet i
    /// heights over each sheet, of points that belong to one
    std::vector<SheetHeights> heights;
    /// Of each point: its height over the joined surface, the sheet whose normal it has, and the
    /// cosine of its own to that.
    struct Beside {
        double height, cosine;
        std::size_t sheet;
    };
    std::vector<Beside> beside;
};

/// Fits `n_sheets` (2 to kMostSheets) height fields of up to `degree`, each to its own points:
/// clusters of normals at least 30 degrees apart, of flat faces 6 (points between two clusters, as
/// an edge's own vertices with averaged normals, belong to neither at first), then twice the points
/// that a sheet explains by place and normal. Joined in the way that the points follow best.
/// Nothing if the normals do not fall into so many clusters or a sheet has too few points for a
/// plane; whether the result is any good say sq_error and n_off. Cost: about ten passes over the
/// points; no allocation once the workspace has grown.
template <class T>
std::optional<SharpFit> fit_sharp(const BallPoints<T>& points, std::size_t n_sheets, int degree,
                                  double noise_variance, SharpWork<T>& work);

}  // namespace slim
