#pragma once

#include "formats/image_io.h"
#include "pipeline/measure/measure_stage.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace slim::test {

/// What measure does beside the errors of a cloud: the other way, per point, shapes and pictures.
class MeasureWays : public FitStages {
protected:
    using json = nlohmann::json;

    json measured(const std::string& model, const std::string& cloud,
                  const std::function<void(MeasureConfig&)>& change) {
        MeasureConfig c;
        c.model = model, c.cloud = cloud;
        change(c);
        return run_as("measure", c, run_measure, listener_);
    }
    json both_ways(const std::string& model, const std::string& cloud) {
        return measured(model, cloud,
                        [](MeasureConfig& c) { c.two_way = true, c.samples = 20000; });
    }
    void build_sphere(std::uint64_t n = 20000) {
        cloud_ = sampled("sphere", n);
        path_ = write(cloud_, "sphere.ply");
        build(build_config(path_, "m.slim"));
        model_ = file("m.slim");
    }
    std::string png(const std::string& name, std::vector<std::uint8_t> rgba) {
        write_png_srgb8(file(name), 2, 1, rgba);
        return file(name);
    }

    Cloud cloud_;
    std::string path_, model_;
};

}  // namespace slim::test
