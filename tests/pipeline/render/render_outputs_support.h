#pragma once

#include "slim/base/error.h"
#include "tests/pipeline/render/render_test_support.h"

#include <string>

namespace slim::test {

/// Models with curvature of every kind, and what a run leaves.
class RenderOutputs : public RenderTest {
protected:
    /// A torus about z, R = 1, r = 0.35.
    void write_torus(int degree) {
        write_model(file("m.slim"), torus_model(1, 0.35, 60, 24, degree), "{}");
    }

    /// A model whose front is smaller than its top.
    void write_flat() {
        auto model = sphere_model(1, 600);
        model.header.bounds.lo.z = -3, model.header.bounds.hi.z = 3;
        write_model(file("m.slim"), model, "{}");
    }

    ExrImage data_of(RenderConfig c) {
        c.output = file("data.exr");
        run(c, true);
        return read_exr(c.output);
    }

    std::string error_of(const RenderConfig& c) {
        try {
            run(c);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    }
};

}  // namespace slim::test
