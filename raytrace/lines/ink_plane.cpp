#include "raytrace/lines/ink_plane.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr std::size_t kRows = 32;

/// How much of what is behind a pixel it shows.
float shown_behind(const float* p) {
    const bool is_black = std::max({p[0], p[1], p[2]}) <= 0;
    return is_black ? 1 : std::clamp(1 - p[3], 0.0f, 1.0f);
}

/// The largest of a row's values within reach of each column [x0, x0 + out.size()).
void widen(const std::vector<float>& row, int x0, int reach, std::vector<float>& out) {
    const int end = static_cast<int>(row.size());
    for (int i = 0; i < static_cast<int>(out.size()); ++i) {
        const int from = std::max(0, x0 + i - reach), to = std::min(end, x0 + i + reach + 1);
        out[static_cast<std::size_t>(i)] =
            *std::max_element(row.begin() + from, row.begin() + to);
    }
}

/// Half the width of a disc `down` rows from its middle.
int half_width(int reach, int down) {
    const float r = static_cast<float>(reach) + 0.5f, d = static_cast<float>(down);
    return static_cast<int>(std::sqrt(r * r - d * d));
}

}  // namespace

int ink_reach(int width, int height) {
    const float scale = std::max(0.6f, static_cast<float>(std::min(width, height)) / 1000);
    return static_cast<int>(std::ceil(2.2f * scale));
}

std::vector<float> ink_plane(const Picture& drawn, const PixelWindow& inside, int whole_width,
                             int whole_height) {
    const int reach = ink_reach(whole_width, whole_height);
    const auto width = static_cast<std::size_t>(inside.width);
    std::vector<float> plane(width * static_cast<std::size_t>(inside.height));
    parallel_blocks(static_cast<std::size_t>(inside.height), kRows,
                    [&](std::size_t first, std::size_t last) {
        std::vector<float> row(static_cast<std::size_t>(drawn.width)), wide(width);
        for (std::size_t y = first; y < last; ++y)
            for (int down = -reach; down <= reach; ++down) {
                const int from = inside.y + static_cast<int>(y) + down;
                if (from < 0 || from >= drawn.height) continue;
                for (int x = 0; x < drawn.width; ++x)
                    row[static_cast<std::size_t>(x)] = shown_behind(drawn.pixel(x, from));
                widen(row, inside.x, half_width(reach, down), wide);
                for (std::size_t x = 0; x < width; ++x)
                    plane[y * width + x] = std::max(plane[y * width + x], wide[x]);
            }
    });
    return plane;
}

}  // namespace slim
