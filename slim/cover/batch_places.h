#pragma once

#include "slim/base/vec.h"

#include <cstddef>
#include <vector>

namespace slim {

/// Where the centres of a batch stand, and which of them are near one before them.
class BatchPlaces {
public:
    explicit BatchPlaces(double least_distance) : sq_(least_distance * least_distance) {}
    /// Adds p; false if it is nearer than the distance to one that is there. Cost: a pass by lanes.
    bool add(const Vec3d& p) {
        unsigned n_near = 0;
        for (std::size_t i = 0; i < x_.size(); ++i) {
            const double dx = x_[i] - p.x, dy = y_[i] - p.y, dz = z_[i] - p.z;
            n_near += dx * dx + dy * dy + dz * dz < sq_ ? 1u : 0u;
        }
        x_.push_back(p.x), y_.push_back(p.y), z_.push_back(p.z);
        return n_near == 0;
    }

private:
    double sq_;
    std::vector<double> x_, y_, z_;
};

}  // namespace slim
