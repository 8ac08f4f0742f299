#pragma once

#include "raytrace/hillshade.h"
#include "raytrace/lines/line_scene.h"

#include <cmath>
#include <functional>

namespace slim::test {

/// A surface z = f(x, y) seen from above, one pixel a unit, x to the right and y upwards from the
/// picture's middle; nothing is hit where the height is no number.
struct ReliefScene {
    GBuffer buffer;
    PixelView view;
    Relief relief{{Vec3f{1, 0, 0}, Vec3f{0, 0, 1}, Vec3f{0, -1, 0}}, 0, 315, 45, 1, 5};

    ReliefScene(int width, int height, const std::function<double(double, double)>& f,
                double unit = 1) {
        buffer.reset(width, height, kNormalChannel | kPositionChannel);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const double px = unit * (x + 0.5 - width / 2.0),
                             py = unit * (height / 2.0 - y - 0.5);
                const double z = f(px, py);
                if (std::isnan(z)) continue;
                constexpr double kStep = 1e-3;
                const Vec3d n = normalized(Vec3d{-(f(px + kStep, py) - z) / kStep,
                                                 -(f(px, py + kStep) - z) / kStep, 1});
                const std::size_t i = buffer.index(x, y);
                buffer.hit[i] = 1;
                const Vec3d p{px, py, z};
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    buffer.position[axis][i] = static_cast<float>(p[axis]);
                    buffer.normal[axis][i] = static_cast<float>(n[axis]);
                }
            }
        Camera camera;
        camera.eye = {0, 0, 1000}, camera.target = {0, 0, 0}, camera.up = {0, 1, 0};
        camera.orthographic = true, camera.width = unit * width;
        view = pixel_view(camera, width, height);
    }

    LineScene scene(const SceneRows& rows = {}) const {
        return {.buffer = buffer, .view = view, .rows = rows};
    }
};

/// A cone that falls by `slope` a unit from its top over the middle.
inline auto cone(double top, double slope) {
    return [=](double x, double y) { return top - slope * std::hypot(x, y); };
}

}  // namespace slim::test
