#pragma once

#include "slim/base/reporter.h"
#include "slim/shapes/shape.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace slim {

enum class NoiseModel { ray, isotropic };

/// What the virtual scanner does. Lengths are in model units of the shape, shares are of its
/// diagonal.
struct ScanSettings {
    std::uint64_t n_points = 500'000;
    int n_stations = 8;
    double noise = 0;  ///< standard deviation over the diagonal of the shape's bounds
    NoiseModel noise_model = NoiseModel::ray;  ///< along the ray, or per coordinate
    double outliers = 0;  ///< share of the returns with a random range
    double dropout = 0;   ///< share of the returns lost at grazing incidence, see return_lost
    std::uint64_t seed = 1;
};

/// Points of one band of scan lines, in scan order; all arrays have one entry per point.
struct ScanBlock {
    std::vector<Vec3d> positions;     ///< as measured, shape's frame
    std::vector<Vec3f> normals;       ///< the scanner's idea, unit, towards the scanner
    std::vector<SurfacePoint> truth;  ///< exact, of the foot point
    std::vector<std::uint16_t> scan_ids;
    std::size_t size() const { return positions.size(); }
};

using ScanSink = std::function<void(const ScanBlock&)>;

struct ScanSummary {
    std::uint64_t points = 0;
    std::uint64_t outliers = 0;  ///< among the points
    std::uint64_t rays = 0;      ///< cast, without the coarse pass
    double sigma = 0;            ///< of the noise, model units
    /// mean distance of rays in a scan at the shape's centre; 0: no scan
    double spacing = 0;
    std::vector<Vec3d> sensors;  ///< position of each scan id
};

/// Scans a shape from stations on a sphere about it and hands exactly n_points points to the sink,
/// in blocks, in an order and with values that depend on the settings alone (not on threads).
///
/// Each station sends a perspective grid of rays over the shape's bounds; all have one angular
/// pitch, found by a coarse pass such that about 3 % more rays return than asked; the surplus is
/// dropped at random, evenly over all bands. A ray that meets the back of an open shape returns
/// nothing. Truth: of the exact hit; with isotropic noise, of the foot point of the noisy position.
/// Normals: from the range grid, noisy as the ranges are (grid_normals.h).
/// throws  ConfigError if no ray returns at all
/// cost    1.03 rays per point over the share of rays that hit; memory for about 1M rays
ScanSummary scan_shape(const Shape& shape, const ScanSettings& settings, const ScanSink& sink,
                       Reporter& reporter);

/// Area-uniform random points instead: all crossings of random isotropic lines (Cauchy-Crofton),
/// with exact outward normals, those of the truth. Stations and dropout play no part; scan id 0.
/// Ray noise is along the line that found the point. Same contract otherwise.
ScanSummary sample_uniformly(const Shape& shape, const ScanSettings& settings,
                             const ScanSink& sink, Reporter& reporter);

}  // namespace slim
