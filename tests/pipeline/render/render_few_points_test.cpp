#include "pipeline/build/build_stage.h"
#include "tests/pipeline/render/render_test_support.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

namespace slim {
namespace {

class FewPoints : public test::RenderTest {
protected:
    /// Ten points along a bend, whose discs reach far beyond them.
    void build_bend() {
        std::ofstream(file("c.xyz")) << "0 0 0\n1 0.2 0.1\n2 0.1 -0.2\n3 0.6 0.3\n4 1.5 0\n"
                                        "4.6 2.4 0.2\n5 3.4 -0.1\n5.1 4.5 0.2\n5.2 5.5 0\n"
                                        "2.5 1.5 1.2\n";
        BuildConfig build;
        build.inputs = {file("c.xyz")}, build.output = file("m.slim");
        const FieldList fields = fields_of(build);
        StageContext context{reporter_, 1, true, "build", canonical_config(fields),
                             print_config(fields), ""};
        run_build(build, context);
    }
};

// The frame held the points: discs were cut on two to four sides.
TEST_F(FewPoints, NamedCamerasHoldTheirDiscs) {
    build_bend();
    for (const char* camera : {"front", "back", "left", "top", "iso"})
        for (const bool ortho : {false, true}) {
            RenderConfig c = config("p.png");
            c.size = "200x200", c.camera = camera, c.ortho = ortho, c.background = "transparent";
            const test::Margins m = test::margins(draw(c));
            EXPECT_GE(m.least(), 2) << camera << ortho;
            EXPECT_LE(m.least(), 6) << camera << ortho;  // 4 are asked for
            EXPECT_NEAR(m.left, m.right, 4) << camera << ortho;
            EXPECT_NEAR(m.top, m.bottom, 4) << camera << ortho;
        }
}

}  // namespace
}  // namespace slim
