#pragma once

#include "slim/scanner/scan.h"
#include "slim/scanner/station.h"

#include <cstdint>
#include <vector>

namespace slim {

/// How many returns to expect where: mean share of the cells of each coarse row of each station
/// that come back, from one coarse grid per station.
class ReturnEstimate {
public:
    static constexpr std::uint64_t kCoarse = 64;

    ReturnEstimate(const Shape& shape, const ScanSettings& settings,
                   const std::vector<Station>& stations);

    /// Sum over stations of frustum area times share: returns are this over the pitch squared.
    double returning_area() const { return area_; }
    /// Expected returns of rows [begin, end) of a station at its present pitch.
    double expected(const Station& station, std::uint64_t begin, std::uint64_t end) const;

private:
    std::vector<double> cumulative_;  ///< per station kCoarse + 1 sums of row shares
    double area_ = 0;
};

/// A run of scan lines of one station: the unit of work.
struct Band {
    std::size_t station = 0;
    std::uint64_t begin = 0, end = 0;
    std::uint64_t ray_key = 0;  ///< of the station's first cell in this pass
    double expected = 0;        ///< returns
};

/// One pass over all stations with the given pitch and place of the rays in their cells.
struct ScanPass {
    std::vector<Station> stations;
    std::vector<Band> bands;
    double expected = 0;  ///< over all bands
    std::uint64_t rays = 0;
};

/// Pass 0 sends rays through the cells' centres, later ones (to fill up) through other places.
/// first_key: of the pass' first ray.
ScanPass plan_pass(const ReturnEstimate& estimate, std::vector<Station> stations, double pitch,
                   std::uint64_t pass, std::uint64_t first_key);

}  // namespace slim
