#include "raytrace/project/tile_buffers.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slim {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

void fill(TilePlane& plane, float value) { std::fill_n(plane.v, kTilePixels, value); }

/// Unit directions of a tile's rays; offsets from the axis are taken in doubles.
void fill_directions(TileBuffers& t, const PixelView& view) {
    for (int y = 0; y < kTileSize; ++y)
        for (int x = 0; x < kTileSize; ++x) {
            const auto i = static_cast<std::size_t>(y * kTileSize + x);
            double dx = 0, dy = 0, len = 1;
            if (!view.orthographic) {
                dx = (t.x0 + x + 0.5 - view.center_x) / view.focal_px;
                dy = (t.y0 + y + 0.5 - view.center_y) / view.focal_px;
                len = std::sqrt(dx * dx + dy * dy + 1);
            }
            t.dx.v[i] = static_cast<float>(dx / len);
            t.dy.v[i] = static_cast<float>(dy / len);
            t.dz.v[i] = static_cast<float>(1 / len);
            t.inv_dz.v[i] = static_cast<float>(len);
        }
}

/// +inf inside the window, -inf outside: no surfel is ever nearer there.
void fill_depth(TileBuffers& t) {
    fill(t.z, -kInfinity);
    for (int y = t.clip.y0; y < t.clip.y1; ++y)
        std::fill_n(t.z.v + (y - t.y0) * kTileSize + (t.clip.x0 - t.x0), t.clip.x1 - t.clip.x0,
                    kInfinity);
}

}  // namespace

void TileBuffers::start(const PixelView& view, const PixelWindow& window, int first_x, int first_y,
                        double reference_depth, bool want_hessian, bool want_third) {
    x0 = first_x;
    y0 = first_y;
    clip = {std::max(x0, window.x), std::max(y0, window.y),
            std::min(x0 + kTileSize, window.x + window.width),
            std::min(y0 + kTileSize, window.y + window.height)};
    z_ref = reference_depth;
    near_z = static_cast<float>(view.near_plane - z_ref);
    fill_directions(*this, view);
    fill_depth(*this);
    fill(winner, -1.0f);
    for (TilePlane* plane : {&gx, &gy, &gz, &weight, &offset, &count, &sum_x, &sum_y, &sum_z})
        fill(*plane, 0.0f);
    if (want_hessian)
        for (TilePlane& plane : hessian) fill(plane, 0.0f);
    if (want_third)
        for (TilePlane& plane : third) fill(plane, 0.0f);
    counts = {};
}

float TileBuffers::farthest() const {
    FloatV far(-kInfinity);
    for (std::size_t i = 0; i < kTilePixels; i += kLanes) far = stdx::max(far, z.load(i));
    return stdx::hmax(far);
}

bool TileBuffers::update_group_ranges() {
    bool any = false;
    for (std::size_t g = 0; g < kGroups; ++g) {
        const FloatV depth = z.load(g * kLanes);
        const auto hit = winner.load(g * kLanes) >= 0.0f;
        any = any || stdx::any_of(hit);
        group_near[g] = stdx::hmin(select<FloatV>(hit, depth, FloatV(kInfinity)));
        group_far[g] = stdx::hmax(select<FloatV>(hit, depth, FloatV(-kInfinity)));
    }
    return any;
}

}  // namespace slim
