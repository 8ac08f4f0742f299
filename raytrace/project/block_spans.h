#pragma once

#include "raytrace/project/outline.h"
#include "raytrace/project/tile_buffers.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <cstdint>

namespace slim {

/// Where s and t lie on a tile: s = start_s + x / to_px, t = start_t + y / to_px, x and y counted from its first pixel.
struct TileGrid {
    float start_s, start_t, step;

    template <class Record>
    TileGrid(const Record& r, const TileBuffers& t)
        : start_s(r.base_x + (static_cast<float>(t.x0) - r.pixel_x) * r.step),
          start_t(r.base_y + (static_cast<float>(t.y0) - r.pixel_y) * r.step), step(r.step) {}
};

/// Columns [first, end) of the blocks that an outline touches, for each row of blocks of a tile.
class BlockSpans {
public:
    static constexpr int kRows = std::max(kBlockRows, kLanes);
    int row_0, row_1;  ///< rows of blocks [row_0, row_1)

    /// `rect` is in the tile's own pixels.
    [[gnu::always_inline]] BlockSpans(const Outline& o, const TileGrid& grid, const ScreenRect& rect)
        : row_0(rect.y0 / kBlockHeight), row_1((rect.y1 + kBlockHeight - 1) / kBlockHeight) {
        for (int row = row_0 / kLanes * kLanes; row < row_1; row += kLanes) fill(o, grid, rect, row);
    }

    /// Writes the blocks' numbers side by side and returns how many they are. `out` has room for all of a tile and a row more:
    /// a row is written whole, whatever its span, since a loop over spans costs more in wrong guesses of its end.
    int list(std::uint8_t* out) const {
        std::uint8_t* next = out;
        for (int row = row_0; row < row_1; ++row) {
            const int start = row * kBlockColumns + first[row];
            for (int k = 0; k < kBlockColumns; ++k) next[k] = static_cast<std::uint8_t>(start + k);
            next += std::max(0, end[row] - first[row]);
        }
        return static_cast<int>(next - out);
    }

private:
    alignas(64) int first[kRows], end[kRows];

    using Ints = stdx::rebind_simd_t<int, FloatV>;

    /// The most that the outline reaches to one side over some rows of pixels: where it is widest, or at the row nearest
    /// to there. Beyond the outline's own rows no column is in.
    struct Reach {
        FloatV middle, sq_half;
        [[gnu::always_inline]] Reach(const Outline& o, float widest, const FloatV& t_0, const FloatV& t_1) {
            const FloatV t = stdx::min(stdx::max(FloatV(widest), t_0), t_1);
            const FloatV b = o.b0 + o.b1 * t;
            middle = -b;
            sq_half = b * b - (o.c0 + t * (2.0f * o.c1 + o.c2 * t));
        }
        [[gnu::always_inline]] FloatV half() const { return stdx::sqrt(stdx::max(sq_half, FloatV(0.0f))); }
    };

    [[gnu::always_inline]] void fill(const Outline& o, const TileGrid& grid, const ScreenRect& rect, int row) {
        constexpr float kGuard = 0.01f;  // of a pixel, for the rounding of s
        const FloatV lane([](auto k) { return static_cast<float>(static_cast<int>(k) * kBlockHeight); });
        const FloatV y = lane + static_cast<float>(row * kBlockHeight);
        const FloatV t_0 = y * grid.step + grid.start_t, t_1 = t_0 + (kBlockHeight - 1) * grid.step;
        const Reach left(o, o.left_t, t_0, t_1), right(o, o.right_t, t_0, t_1);
        const float to_px = 1 / grid.step;
        const FloatV lo = (left.middle - left.half() - grid.start_s) * to_px + (1 - kGuard);
        FloatV hi = (right.middle + right.half() - grid.start_s) * to_px + kGuard;
        stdx::where(right.sq_half < 0.0f, hi) = -1.0f;
        // Bounded on both sides: a pixel far beyond the picture is no int. Where nothing is known
        // (NaN) all is in.
        const FloatV begin(static_cast<float>(rect.x0)), last(static_cast<float>(rect.x1 - 1));
        const auto x_0 = stdx::static_simd_cast<Ints>(stdx::min(stdx::max(begin, lo), last + 1.0f));
        const auto x_1 =
            stdx::static_simd_cast<Ints>(stdx::max(stdx::min(last, hi), begin - 1.0f) + 1.0f);
        (x_0 / kBlockWidth).copy_to(first + row, stdx::vector_aligned);
        ((x_1 + (kBlockWidth - 1)) / kBlockWidth).copy_to(end + row, stdx::vector_aligned);
    }
};

}  // namespace slim
