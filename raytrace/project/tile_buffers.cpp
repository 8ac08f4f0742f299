#include "raytrace/project/tile_buffers.h"

#include "raytrace/project/surfel_lanes.h"
#include "slim/base/lane_turns.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace slim {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

void fill(TilePlane& plane, float value) { std::fill_n(plane.v, kTilePixels, value); }

/// +inf inside the window, -inf outside: no surfel is ever nearer there.
void fill_depth(TileBuffers& t) {
    const bool whole = t.clip.x1 - t.clip.x0 == kTileSize && t.clip.y1 - t.clip.y0 == kTileSize;
    fill(t.z, whole ? kInfinity : -kInfinity);
    if (whole) return;
    for (int y = t.clip.y0; y < t.clip.y1; ++y)
        for (int x = t.clip.x0; x < t.clip.x1; ++x)
            t.z.v[pixel_entry(x - t.x0, y - t.y0)] = kInfinity;
}

/// Of as many blocks as there are lanes.
std::array<FloatV, kLanes> depths_of(const TilePlane& z, std::size_t first_block) {
    std::array<FloatV, kLanes> depths;
    for (std::size_t k = 0; k < kLanes; ++k) depths[k] = z.load((first_block + k) * kLanes);
    return depths;
}

}  // namespace

void TileBuffers::start(const PixelView& view, const PixelWindow& window, int first_x, int first_y,
                        double reference_depth, const TileSums& sums) {
    x0 = first_x;
    y0 = first_y;
    clip = {std::max(x0, window.x), std::max(y0, window.y),
            std::min(x0 + kTileSize, window.x + window.width),
            std::min(y0 + kTileSize, window.y + window.height)};
    const double z_ref =
        view.orthographic ? reference_depth : std::max(reference_depth, view.near_plane);
    depths = {z_ref, view.orthographic ? 0 : 1 / z_ref, view.near_plane - z_ref};
    near_z = static_cast<float>(depths.near);
    fill_depth(*this);
    for (TilePlane* plane : {&weight, &sum_x, &sum_y, &sum_z}) fill(*plane, 0.0f);
    if (sums.depth) fill(offset, 0.0f);
    if (sums.count) fill(count, 0.0f);
    if (sums.hessian)
        for (TilePlane& plane : hessian) fill(plane, 0.0f);
    if (sums.third)
        for (TilePlane& plane : third) fill(plane, 0.0f);
    counts = {};
}

void TileBuffers::leave_out_others(const SampleMask& only) {
    constexpr int k = SampleMask::kSide;
    static_assert(kTileSize % k == 0 && kBlockWidth % k == 0 && kBlockHeight % k == 0);
    std::array<std::uint8_t, kTileSize / k> wanted;
    for (int y = 0; y < kTileSize; y += k) {
        only.copy_row(x0 / k, (y0 + y) / k, wanted);
        for (int x = 0; x < kTileSize; x += k) {
            if (wanted[static_cast<std::size_t>(x / k)]) continue;
            float* const first = &z.v[pixel_entry(x, y)];
            for (int v = 0; v < k; ++v) std::fill_n(first + v * kBlockWidth, k, -kInfinity);
        }
    }
}

/// Offsets from the axis are taken in doubles.
void TileBuffers::fill_directions(const PixelView& view) {
    constexpr std::size_t kHalf = DoubleV::size();
    static_assert(kLanes % kHalf == 0);
    const DoubleV lane([](auto k) { return static_cast<double>(static_cast<int>(k)); });
    const double per_px = view.orthographic ? 0 : 1 / view.focal_px;
    for (std::size_t part = 0; part < kLanes; part += kHalf) {  // of every block
        const DoubleV k = lane + static_cast<double>(part),
                      row = stdx::floor(k / double{kBlockWidth});
        const DoubleV x = k - row * double{kBlockWidth} + (x0 + 0.5 - view.center_x);
        const DoubleV y = row + (y0 + 0.5 - view.center_y);
        for (int block = 0; block < kTileBlocks; ++block) {
            const DoubleV ray_x = (x + double(block % kBlockColumns * kBlockWidth)) * per_px;
            const DoubleV ray_y = (y + double(block / kBlockColumns * kBlockHeight)) * per_px;
            const DoubleV len = stdx::sqrt(ray_x * ray_x + ray_y * ray_y + 1.0), share = 1.0 / len;
            const std::size_t i = static_cast<std::size_t>(block) * kLanes + part;
            floats_of(ray_x * share).copy_to(dx.v + i, stdx::element_aligned);
            floats_of(ray_y * share).copy_to(dy.v + i, stdx::element_aligned);
            floats_of(share).copy_to(dz.v + i, stdx::element_aligned);
            floats_of(len).copy_to(inv_dz.v + i, stdx::element_aligned);
        }
    }
}

float TileBuffers::bound_pixels() {
    FloatV most(-kInfinity);
    for (std::size_t k = 0; k < kTileBlocks; k += kLanes) {
        const FloatV of_block = reduce_each(
            depths_of(z, k), [](const FloatV& a, const FloatV& b) { return stdx::max(a, b); });
        of_block.copy_to(block_far + k, stdx::vector_aligned);
        most = stdx::max(most, of_block);
    }
    return stdx::hmax(most);
}

bool TileBuffers::bound_hits() {
    FloatV least(kInfinity), most(-kInfinity);
    for (std::size_t k = 0; k < kTileBlocks; k += kLanes) {
        auto depth = depths_of(z, k);
        for (FloatV& d : depth) d = select<FloatV>(has_hit(d), d, FloatV(kInfinity));
        const FloatV first =
            reduce_each(depth, [](const FloatV& a, const FloatV& b) { return stdx::min(a, b); });
        for (FloatV& d : depth) d = select<FloatV>(has_hit(d), d, FloatV(-kInfinity));
        const FloatV last =
            reduce_each(depth, [](const FloatV& a, const FloatV& b) { return stdx::max(a, b); });
        first.copy_to(block_near + k, stdx::vector_aligned),
            last.copy_to(block_far + k, stdx::vector_aligned);
        least = stdx::min(least, first), most = stdx::max(most, last);
    }
    near = stdx::hmin(least), far = stdx::hmax(most);
    return near <= far;
}

}  // namespace slim
