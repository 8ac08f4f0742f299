#pragma once

#include "pipeline/build/build_stage.h"
#include "pipeline/scan_stage.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <cstdint>
#include <string>

namespace slim::test {

/// Builds of scanned spheres.
class BuildStage : public FitStages {
protected:
    std::string scanned_sphere(std::uint64_t n) {
        ScanSettings s;
        s.n_points = n;
        s.n_stations = 6;
        return write(scanned("sphere", s), "sphere.ply");
    }
};

}  // namespace slim::test
