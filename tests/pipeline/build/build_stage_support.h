#pragma once

#include "pipeline/build/build_stage.h"
#include "pipeline/scan_stage.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <cstdint>
#include <string>

namespace slim::test {

/// A cube's surface on a grid; vertices of edges and corners have the mean normal of their faces.
inline std::string cube_text(int n) {
    std::string text;
    for (int x = 0; x <= n; ++x)
        for (int y = 0; y <= n; ++y)
            for (int z = 0; z <= n; ++z) {
                const auto side = [n](int k) { return k == 0 ? -1.0 : k == n ? 1.0 : 0.0; };
                const Vec3d normal = normalized(Vec3d{side(x), side(y), side(z)});
                if (!(sq_length(normal) > 0)) continue;
                for (const double v :
                     {double(x), double(y), double(z), normal.x, normal.y, normal.z})
                    text += std::to_string(v) + ' ';
                text += '\n';
            }
    return text;
}

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
