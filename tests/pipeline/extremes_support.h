#pragma once

#include "formats/ply_writer.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <string>
#include <vector>

namespace slim::test {

/// Clouds of the extremes (NUMERICS section 6) through the stages.
class Extremes : public FitStages {
protected:
    nlohmann::json built(const std::string& cloud, const std::string& model = "m.slim") {
        return build(build_config(cloud, model));
    }
    static nlohmann::json fit_of(const nlohmann::json& result) {
        return result.at("stages").at("fit");
    }
    bool warned_of(const std::string& text) const {
        return std::any_of(listener_.warnings.begin(), listener_.warnings.end(),
                           [&](const auto& w) { return w.find(text) != std::string::npos; });
    }
    std::string write_text(const std::string& name, const std::vector<Vec3d>& points) const {
        std::string text;
        for (const Vec3d& p : points) text += fmt::format("{} {} {}\n", p.x, p.y, p.z);
        return folder_.write(name, text);
    }
    std::string write_floats(const std::string& name, const Cloud& cloud) const {
        PlyLayout layout;
        layout.normals = true;
        PlyWriter writer(file(name), layout);
        writer.write({cloud.positions, cloud.normals, {}, {}, {}});
        writer.commit();
        return file(name);
    }
};

}  // namespace slim::test
