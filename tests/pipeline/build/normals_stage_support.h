#pragma once

#include "formats/slice_file.h"
#include "pipeline/build/normals_stage.h"
#include "slim/base/hash.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <cstddef>

namespace slim::test {

class NormalsStage : public FitStages {
protected:
    PointBlock oriented(std::size_t slice = 0) {
        return read_slice(oriented_points_path(file("work"), slice).string());
    }
    Cloud with_flips(double share) {
        Cloud cloud = sampled("sphere", 10000);
        for (std::size_t i = 0; i < cloud.size(); ++i)
            if (unit_interval(keyed_hash(1, i)) < share) cloud.normals[i] = -cloud.normals[i];
        return cloud;
    }
    static std::size_t inwards(const PointBlock& block) {
        std::size_t n = 0;
        for (std::size_t i = 0; i < block.size(); ++i)
            n += dot(to_double(block.normal[i]), block.position[i] + block.origin) < 0;
        return n;
    }
};

}  // namespace slim::test
