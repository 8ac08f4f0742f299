#include "tests/pipeline/render/render_test_support.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace slim {
namespace {

using RenderSupersample = test::RenderTest;

TEST_F(RenderSupersample, FineFramesAreAveragedAlikeInBandsAndAtOnce) {
    RenderConfig c = config("x.png");
    c.size = "90x300", c.aov = {"normal", "mean", "shaded"}, c.legend = false;
    c.background = "transparent", c.range = {"3"}, c.light_maps = true;
    run(c);
    const auto once = [&](const char* aov) {
        return read_png(file(std::string("x.") + aov + ".png"));
    };
    const PngImage plain[] = {once("normal"), once("mean"), once("shaded")};
    c.supersample = 2, c.output = file("y.png");
    run(c);
    int k = 0;
    for (const char* aov : {"normal", "mean", "shaded"}) {
        const PngImage fine = read_png(file(std::string("y.") + aov + ".png"));
        int n_far = 0;
        for (std::size_t i = 0; i < fine.rgba.size(); i += 4) {
            const auto& p = plain[k].rgba;
            if (p[i + 3] == 0 || fine.rgba[i + 3] < 255) continue;  // the silhouette is averaged
            for (std::size_t channel = 0; channel < 3; ++channel)
                n_far += std::abs(p[i + channel] - fine.rgba[i + channel]) > 12;
        }
        EXPECT_LE(n_far, 60) << aov;
        ++k;
    }
}

}  // namespace
}  // namespace slim
