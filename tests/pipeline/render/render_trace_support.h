#pragma once

#include "tests/pipeline/render/render_test_support.h"

#include <string>

namespace slim::test {

/// Small pictures by rays of a sphere, and of models beside it.
class RenderTrace : public RenderTest {
protected:
    RenderTrace() { write("m.slim", 1, {}); }

    /// A sphere model with the fit errors of a good fit.
    void write(const std::string& name, double radius, const Vec3d& origin) const {
        auto model = sphere_model(radius, 600);
        model.header.origin = origin;
        for (TreeNode& node : model.nodes) node.fit_error = 1e-4f;
        write_model(file(name), model, "{}");
    }

    RenderConfig traced(const std::string& output) const {
        RenderConfig c = config(output);
        c.mode = "raytrace";
        return c;
    }
};

}  // namespace slim::test
