#pragma once

#include "slim/base/frame.h"
#include "slim/scanner/ray_crossing.h"

#include <cstdint>
#include <vector>

namespace slim {

/// A scanner position with its frustum: rays through a regular grid on the plane at distance one.
struct Station {
    std::uint16_t id = 0;
    Vec3d position;
    Frame<double> axes;  ///< normal: optical axis, to the shape's centre
    double u_lo = 0, v_lo = 0, u_hi = 0, v_hi = 0;  ///< on the plane at distance one
    double pitch = 0;
    std::uint64_t rows = 0, cols = 0;
    double row_shift = 0.5, col_shift = 0.5;  ///< place of a ray in its cell, 0..1

    double area() const { return (u_hi - u_lo) * (v_hi - v_lo); }
    /// Cells of that side over the whole frustum.
    void set_pitch(double new_pitch);
    /// Ray through a cell; fractions of a cell are welcome.
    Ray ray(double row, double col) const;
};

/// n stations on a sphere about the shape, of 1.5 times its diagonal, spread as a Fibonacci lattice
/// about the y axis from above to below; the frustum of each just holds the shape's bounds.
std::vector<Station> stations_around(const Bbox& bounds, int n);

}  // namespace slim
