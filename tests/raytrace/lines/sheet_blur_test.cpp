#include "raytrace/lines/sheet_blur.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim {
namespace {

/// A wall with a step at x = 30, seen head on.
struct Step {
    static constexpr int kSize = 700;  // a reach of 2 pixels
    Camera camera;
    PixelView view;
    GBuffer buffer;

    Step() {
        camera.orthographic = true, camera.width = kSize;
        camera.eye = {0, 0, 100};
        view = pixel_view(camera, kSize, kSize);
        buffer.reset(kSize, kSize, kPositionChannel | kNormalChannel);
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x) {
                const std::size_t i = buffer.index(x, y);
                buffer.hit[i] = x < 600;
                buffer.position[0][i] = static_cast<float>(x),
                buffer.position[1][i] = static_cast<float>(-y);
                buffer.position[2][i] = x < 30 ? 0.0f : 9.0f, buffer.normal[2][i] = 1;
            }
    }
};

TEST(SheetBlur, AveragesWithinASheetOnly) {
    const Step step;
    std::vector<float> plane(step.buffer.n_pixels());
    for (std::size_t i = 0; i < plane.size(); ++i) {
        const auto x = static_cast<float>(i % Step::kSize), y = static_cast<float>(i / Step::kSize);
        plane[i] = x < 30 ? x : x < 600 ? 100 + x + y * y : std::nanf("");
    }
    const std::vector<float> mean = blurred(Sheets({step.buffer, step.view, 1, 2}), plane);
    const auto at = [&](int x, int y) { return mean[step.buffer.index(x, y)]; };
    EXPECT_NEAR(at(10, 50), 10, 1e-3);
    EXPECT_NEAR(at(29, 50), 28, 1e-3);                   // of 27, 28, 29
    EXPECT_NEAR(at(0, 50), 1, 1e-3);                     // of 0, 1, 2
    EXPECT_NEAR(at(30, 50) - 50 * 50, 131 + 2, 1e-2);    // mean of y^2 over 5 rows: + 2
    EXPECT_NEAR(at(599, 0), 100 + 598 + 5.0 / 3, 1e-2);  // rows 0, 1, 2
    EXPECT_NEAR(at(300, 300) - 300 * 300, 402, 0.1);
}

}  // namespace
}  // namespace slim
