#pragma once

#include "raytrace/intersect/pixel_record.h"
#include "raytrace/project/tile_buffers.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <cstddef>

namespace slim {

/// Columns [x0, x1) of a tile that a surfel's ball covers, for each row.
struct RowSpans {
    alignas(64) int x0[kTileSize], x1[kTileSize];

    void all(int first, int last) {
        std::fill_n(x0, kTileSize, first);
        std::fill_n(x1, kTileSize, last);
    }
};

/// The outline of a ball |q|^2 = n + m tau + l tau^2 < R^2 is m^2 = 4 l (n - R^2), a conic in (s, t):
/// n = N, m = 2 (a + k N), l = L + 2 k a + k^2 N with N = s^2 + t^2, a = X s + Y t,
/// L = 1 + X^2 + Y^2, so that (L - R^2 k^2) N < a^2 + 2 k R^2 a + R^2 L inside; along a row a quadratic in s.
/// The columns are those within [first, last) in it, with half a pixel to spare.
template <int Degree>
[[gnu::always_inline]] inline RowSpans row_spans(const PixelRecord<Degree>& r, float sq_radius, const TileBuffers& t,
                                                 int first, int last) {
    RowSpans spans;
    const float k = r.kappa, big_x = 0.5f * r.ball_s[1], big_y = 0.5f * r.row[1][r.kBall + 1];
    const float big_l = r.row[0][r.kBall + 2], inner_l = big_l - sq_radius * k * k;
    const float a2 = inner_l - big_x * big_x;
    const FloatV lane([](auto i) { return static_cast<float>(i); });
    const float to_px = 1 / r.step, origin = (r.pixel_x - static_cast<float>(t.x0)) - r.base_x * to_px;
    for (int y = 0; y < kTileSize; y += kLanes) {
        const FloatV row = (lane + static_cast<float>(t.y0 + y) - r.pixel_y) * r.step + r.base_y;
        // a2 s^2 - 2 h s - c < 0
        const FloatV h = big_x * (big_y * row + k * sq_radius);
        const FloatV c = row * (row * (big_y * big_y - inner_l) + 2 * k * sq_radius * big_y) + sq_radius * big_l;
        const FloatV disc = h * h + a2 * c;
        const FloatV middle = h * (1 / a2) * to_px + origin;
        const FloatV half = stdx::sqrt(stdx::max(disc, FloatV(0.0f))) * (to_px / a2) + 0.5f;
        const FloatV lo = stdx::max(middle - half, FloatV(static_cast<float>(first)));
        const FloatV hi = stdx::min(middle + half + 1.0f, FloatV(static_cast<float>(last)));
        using Ints = stdx::rebind_simd_t<int, FloatV>;
        const auto begin = stdx::static_simd_cast<Ints>(lo), end = stdx::static_simd_cast<Ints>(hi);
        begin.copy_to(spans.x0 + y, stdx::vector_aligned);
        stdx::max(begin, end).copy_to(spans.x1 + y, stdx::vector_aligned);
    }
    return spans;
}

}  // namespace slim
