#include "raytrace/narrow_backs.h"

#include "raytrace/eye_surface.h"
#include "slim/base/parallel.h"

#include <algorithm>

namespace slim {
namespace {

constexpr float kNarrow = 1 / 6.0f, kWide = 0.4f;  ///< shares of the disc

/// Share of the places about a pixel that show a back.
float share_of_backs(const EyeSurface& surface, int x, int y, const Vec3f& eye) {
    int backs = 0;
    for (const auto& [dx, dy] : surface.frame.places)
        if (const auto there = surface.normal_near(x + dx, y + dy)) backs += dot(*there, eye) < 0;
    return static_cast<float>(backs) / static_cast<float>(EyeFrame::kPlaces);
}

}  // namespace

std::vector<float> narrow_backs(int width, int height, const ShadeView& view,
                                const NormalPlanes& normals, std::span<const std::uint8_t> hit) {
    check_planes(hit.size(), height, {0, height}, normals, hit);
    std::vector<float> out(hit.size(), 0.0f);
    const EyeFrame frame(view, width, height);
    const EyeSurface surface{width, height, frame, normals, hit};
    parallel_blocks(static_cast<std::size_t>(height), kShadedRows,
                    [&](std::size_t begin, std::size_t end) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
            for (int x = 0; x < width; ++x) {
                const std::size_t i = surface.index(x, y);
                if (!hit[i]) continue;
                const Vec3f eye =
                    frame.to_world(frame.toward_eye(frame.across(x), frame.upwards(y)));
                if (!(dot(Vec3f{normals.x[i], normals.y[i], normals.z[i]}, eye) < 0)) continue;
                const float share = share_of_backs(surface, x, y, eye);
                out[i] = std::clamp((kWide - share) / (kWide - kNarrow), 0.0f, 1.0f);
            }
    });
    return out;
}

}  // namespace slim
