#include "slim/tree/drawn_bounds.h"
#include "tests/pipeline/render/render_test_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace slim {
namespace {

using test::Margins, test::margins;

class RenderFraming : public test::RenderTest {
protected:
    /// The part of a sphere on the side of (1, 2, -1), far from the middle of its box.
    void write_part(const std::string& name, const Vec3d& origin) const {
        auto model = test::sphere_model(1, 2000);
        model.header.origin = origin;
        for (std::size_t i = 0; i < model.nodes.size(); ++i)
            if (dot(model.view().center(i), Vec3d{1, 2, -1}) < 1.2) model.nodes[i].flags |= kLoose;
        set_drawn_bounds(model);
        write_model(file(name), model, "{}");
    }
    RenderConfig view(const char* camera) const {
        RenderConfig c = config("x.png");
        c.camera = camera, c.size = "200x160", c.background = "transparent";
        return c;
    }
    static void expect_framed(const Margins& m, const std::string& what) {
        EXPECT_NEAR(m.left, m.right, 2) << what;
        EXPECT_NEAR(m.top, m.bottom, 2) << what;
        EXPECT_GE(std::min(m.left, m.top), 2) << what;
        EXPECT_LE(std::min(m.left, m.top), 7) << what;
    }
};

TEST_F(RenderFraming, WhatIsDrawnStandsInTheMiddleAndFillsThePicture) {
    write_part("m.slim", {});
    for (const bool ortho : {false, true})
        for (const char* camera : {"front", "back", "left", "right", "top", "bottom", "iso"}) {
            RenderConfig c = view(camera);
            c.ortho = ortho;
            expect_framed(margins(draw(c)), camera);
        }
}

TEST_F(RenderFraming, LooseSurfelsAreFramedIfTheyAreDrawn) {
    write_part("m.slim", {});
    RenderConfig c = view("iso");
    c.loose = true;
    expect_framed(margins(draw(c)), "loose");
}

TEST_F(RenderFraming, SoAreAddedModels) {
    write_part("m.slim", {1000, 0, 0});
    write_part("other.slim", {1002, 1, 0});
    RenderConfig c = view("iso");
    c.mode = "raytrace", c.add = {file("other.slim")};
    expect_framed(margins(draw(c)), "two");
}

TEST_F(RenderFraming, ModelsWithoutAHullAreFramedByTheirBoxes) {
    auto model = test::sphere_model(1, 2000);  // as older programs wrote it
    write_model(file("m.slim"), model, "{}");
    const Margins m = margins(draw(view("iso")));
    EXPECT_NEAR(m.left, m.right, 2);
    EXPECT_GE(std::min(m.left, m.top), 2);
    set_drawn_bounds(model);
    write_model(file("m.slim"), model, "{}");
    EXPECT_LT(margins(draw(view("iso"))).top, m.top);
}

}  // namespace
}  // namespace slim
