#include "raytrace/project/tile_buffers.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slim {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

void fill(TilePlane& plane, float value) { std::fill_n(plane.v, kTilePixels, value); }

/// +inf inside the window, -inf outside: no surfel is ever nearer there.
void fill_depth(TileBuffers& t) {
    fill(t.z, -kInfinity);
    for (int y = t.clip.y0; y < t.clip.y1; ++y)
        std::fill_n(t.z.v + (y - t.y0) * kTileSize + (t.clip.x0 - t.x0), t.clip.x1 - t.clip.x0,
                    kInfinity);
}

}  // namespace

void TileBuffers::start(const PixelView& view, const PixelWindow& window, int first_x, int first_y,
                        double reference_depth, const TileSums& sums) {
    x0 = first_x;
    y0 = first_y;
    clip = {std::max(x0, window.x), std::max(y0, window.y),
            std::min(x0 + kTileSize, window.x + window.width),
            std::min(y0 + kTileSize, window.y + window.height)};
    z_ref = reference_depth;
    near_z = static_cast<float>(view.near_plane - z_ref);
    fill_depth(*this);
    for (TilePlane* plane : {&weight, &sum_x, &sum_y, &sum_z}) fill(*plane, 0.0f);
    if (sums.depth) fill(offset, 0.0f);
    if (sums.count) fill(count, 0.0f);
    if (sums.hessian)
        for (TilePlane& plane : hessian) fill(plane, 0.0f);
    if (sums.third)
        for (TilePlane& plane : third) fill(plane, 0.0f);
    for (int strip = 0; strip < kStrips; ++strip)
        for (int x = 0; x < kTileSize; x += kLanes) update_strip(strip, x);
    counts = {};
}

/// Offsets from the axis are taken in doubles.
void TileBuffers::fill_directions(const PixelView& view) {
    for (int y = 0; y < kTileSize; ++y)
        for (int x = 0; x < kTileSize; ++x) {
            const auto i = static_cast<std::size_t>(y * kTileSize + x);
            double ray_x = 0, ray_y = 0, len = 1;
            if (!view.orthographic) {
                ray_x = (x0 + x + 0.5 - view.center_x) / view.focal_px;
                ray_y = (y0 + y + 0.5 - view.center_y) / view.focal_px;
                len = std::sqrt(ray_x * ray_x + ray_y * ray_y + 1);
            }
            dx.v[i] = static_cast<float>(ray_x / len);
            dy.v[i] = static_cast<float>(ray_y / len);
            dz.v[i] = static_cast<float>(1 / len);
            inv_dz.v[i] = static_cast<float>(len);
        }
}

bool TileBuffers::bound_hits() {
    FloatV::mask_type any(false);
    for (int strip = 0; strip < kStrips; ++strip)
        for (int x = 0; x < kTileSize; x += kLanes) {
            FloatV near(kInfinity), far(-kInfinity);
            for (int row = 0; row < kStripRows; ++row) {
                const FloatV depth =
                    z.load(static_cast<std::size_t>((strip * kStripRows + row) * kTileSize + x));
                const auto hit = has_hit(depth);
                any = any || hit;
                near = stdx::min(near, select<FloatV>(hit, depth, near));
                far = stdx::max(far, select<FloatV>(hit, depth, far));
            }
            near.copy_to(strip_near + strip * kTileSize + x, stdx::vector_aligned);
            far.copy_to(strip_far + strip * kTileSize + x, stdx::vector_aligned);
        }
    return stdx::any_of(any);
}

}  // namespace slim
