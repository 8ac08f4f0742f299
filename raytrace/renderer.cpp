#include "raytrace/renderer.h"

#include "slim/base/error.h"

#include <string>

namespace slim {

PixelWindow RenderRequest::resolved_window() const {
    PixelWindow w = window;
    if (w.width == 0 && w.height == 0) w = {0, 0, width, height};
    if (w.x < 0 || w.y < 0 || w.width < 1 || w.height < 1 || w.width > width - w.x ||
        w.height > height - w.y)
        throw ConfigError("window " + std::to_string(w.width) + "x" + std::to_string(w.height) +
                          "+" + std::to_string(w.x) + "+" + std::to_string(w.y) +
                          " is not inside the picture of " + std::to_string(width) + "x" +
                          std::to_string(height));
    return w;
}

}  // namespace slim
