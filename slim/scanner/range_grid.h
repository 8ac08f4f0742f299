#pragma once

#include "slim/scanner/scan.h"
#include "slim/scanner/station.h"

#include <cstdint>
#include <vector>

namespace slim {

/// What one ray brought back.
struct Return {
    Vec3d position;      ///< as measured; without meaning if not valid
    double range = 0;    ///< measured distance from the scanner
    SurfacePoint truth;  ///< at the exact hit, or at the foot point (scan.h)
    bool valid = false;
    bool outlier = false;
};

/// Rows [first_row, first_row + rows) of a station's scan, row-major.
struct RangeGrid {
    std::uint64_t first_row = 0, rows = 0, cols = 0;
    std::vector<Return> cells;

    const Return& at(std::uint64_t row, std::uint64_t col) const {
        return cells[(row - first_row) * cols + col];
    }
};

/// Position on the surface where a ray first meets the front of a shape.
struct Hit {
    double t = 0;
    SurfacePoint truth;
    double cos_incidence = 1;  ///< between the normal and the way back to the scanner, > 0
};

/// First hit within the interval; none if the ray misses or meets the back side.
std::optional<Hit> first_hit(const Shape& shape, const Ray& ray, const Interval& part);

/// Probability that a return is lost: dropout * (1 - cos)^2, nothing at normal incidence, `dropout`
/// at the silhouette.
double loss_probability(double dropout, double cos_incidence);

/// Casts rows [first_row, end_row) of a station. `ray_key` is the key of the station's cell (0, 0)
/// in this pass: a ray's random numbers hang on ray_key + row * cols + col alone. Resizes and fills
/// `grid`.
void cast_rows(const Shape& shape, const ScanSettings& settings, const Station& station,
               std::uint64_t ray_key, std::uint64_t first_row, std::uint64_t end_row,
               RangeGrid& grid);

/// Noise, in place: `hit` along `ray` becomes what the scanner says.
Return measured_return(const Shape& shape, const ScanSettings& settings, const Ray& ray,
                       const Hit& hit, const Interval& part, std::uint64_t key);

}  // namespace slim
