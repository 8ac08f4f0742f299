#include "pipeline/build/build_stage.h"
#include "pipeline/scan_stage.h"
#include "raytrace/project/forward_renderer.h"
#include "tests/pipeline/render/render_test_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace slim {
namespace {

class LevelsOfDetail : public test::RenderTest {
protected:
    template <class Config>
    StageContext context(Config& config, const char* stage) {
        const FieldList fields = fields_of(config);
        return {reporter_, 1, true, stage, canonical_config(fields), print_config(fields), ""};
    }

    /// The sculpture, so fine that small pictures are of internal surfels.
    void build_sculpture() {
        ScanConfig scan;
        scan.shape = "sculpture", scan.points = 100000, scan.output = file("c.ply");
        StageContext scanning = context(scan, "scan");
        run_scan(scan, scanning);
        BuildConfig build;
        build.inputs = {file("c.ply")}, build.output = file("m.slim"), build.t_mdl = 1e-6;
        StageContext building = context(build, "build");
        run_build(build, building);
    }
};

/// Pixels of a picture that are two or more off its silhouette, and those of them that another one
/// does not see or sees farther off than all about them.
struct Holes {
    int inner = 0, holes = 0;
};
void add_holes(const GBuffer& full, const GBuffer& coarse, float depth, Holes& h) {
    constexpr int kReach = 2;
    for (int y = kReach; y < full.height - kReach; ++y)
        for (int x = kReach; x < full.width - kReach; ++x) {
            float farthest = 0;
            bool inner = true;
            for (int v = y - kReach; v <= y + kReach; ++v)
                for (int u = x - kReach; u <= x + kReach; ++u) {
                    inner = inner && full.hit[full.index(u, v)];
                    farthest = std::max(farthest, full.depth[full.index(u, v)]);
                }
            if (!inner) continue;
            const std::size_t i = full.index(x, y);
            ++h.inner;
            h.holes += !coarse.hit[i] || coarse.depth[i] > farthest + depth;
        }
}

// NUMERICS section 6, row 42. Cores of internal surfels leave gaps (3.3 % of these pixels were
// holes, or the far side seen through them); outlines may grow.
TEST_F(LevelsOfDetail, Row42ARealModelHasNoHolesAndItsSilhouetteStaysWithinTwoPixels) {
    build_sculpture();
    const ModelFile model = ModelFile::open(file("m.slim"));
    const SurfelTree tree = model.tree();
    Holes h;
    for (const int side : {24, 32, 40, 60, 80})
        for (const char* name : {"front", "iso", "right"}) {
            RenderRequest request;
            request.camera = named_camera(name, tree.header().bounds, 1);
            request.width = request.height = side;
            request.wanted = kDepthChannel;
            GBuffer full, coarse;
            request.lod_px = 0;
            const auto all = render_forward(tree, request, full);
            request.lod_px = 4;
            EXPECT_LT(render_forward(tree, request, coarse).surfels_drawn, all.surfels_drawn);
            add_holes(full, coarse, static_cast<float>(0.02 * tree.header().diagonal), h);
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) {
                    if (!coarse.hit[coarse.index(x, y)]) continue;
                    bool near = false;
                    for (int v = std::max(0, y - 2); v <= std::min(side - 1, y + 2); ++v)
                        for (int u = std::max(0, x - 2); u <= std::min(side - 1, x + 2); ++u)
                            near = near || full.hit[full.index(u, v)];
                    EXPECT_TRUE(near) << side << ' ' << name << ' ' << x << ' ' << y;
                }
        }
    EXPECT_GT(h.inner, 2000);
    EXPECT_LE(h.holes, h.inner / 100) << h.inner;
}

}  // namespace
}  // namespace slim
