#pragma once

#include "raytrace/project/block_mask.h"
#include "raytrace/project/outline.h"
#include "raytrace/project/tile_buffers.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <cstddef>
#include <type_traits>

namespace slim {

/// Where s and t lie on a tile: s = start_s + x / to_px, t = start_t + y / to_px, x and y counted from its first pixel.
struct TileGrid {
    float start_s, start_t, step;

    template <class Record>
    TileGrid(const Record& r, const TileBuffers& t)
        : start_s(r.base_x + (static_cast<float>(t.x0) - r.pixel_x) * r.step),
          start_t(r.base_y + (static_cast<float>(t.y0) - r.pixel_y) * r.step), step(r.step) {}
};

/// The blocks of a tile that an outline touches; lanes are rows of blocks.
class BlockSpans {
public:
    /// `rect` is in the tile's own pixels.
    [[gnu::always_inline]] BlockSpans(const Outline& o, const TileGrid& grid, const ScreenRect& rect) {
        const int row_0 = rect.y0 / kBlockHeight, row_1 = (rect.y1 + kBlockHeight - 1) / kBlockHeight;
        for (int row = row_0 / kRows * kRows; row < row_1; row += kRows) {
            const Ints at = Ints([](auto k) { return static_cast<int>(k); }) + row;
            const auto outside = at < row_0 || at >= row_1;
            Ints bits = columns(o, grid, rect, static_cast<float>(row));
            stdx::where(outside, bits) = 0;
            put(static_cast<std::size_t>(row), bits);
        }
    }
    const BlockMask& blocks() const { return blocks_; }

private:
    using Lanes = std::conditional_t<kBlockRows <= kLanes / 2, LanesOfDouble<float>, FloatV>;
    using Ints = stdx::rebind_simd_t<int, Lanes>;
    static constexpr int kRows = static_cast<int>(Lanes::size());
    static_assert(kBlockRows % kRows == 0);
    BlockMask blocks_;

    /// The most that the outline reaches to one side over some rows of pixels: where it is widest, or at the row nearest
    /// to there. Beyond the outline's own rows no column is in.
    struct Reach {
        Lanes middle, sq_half;
        [[gnu::always_inline]] Reach(const Outline& o, float widest, const Lanes& t_0, const Lanes& t_1) {
            const Lanes t = stdx::min(stdx::max(Lanes(widest), t_0), t_1);
            const Lanes b = o.b0 + o.b1 * t;
            middle = -b;
            sq_half = b * b - (o.c0 + t * (2.0f * o.c1 + o.c2 * t));
        }
        [[gnu::always_inline]] Lanes half() const { return stdx::sqrt(stdx::max(sq_half, Lanes(0.0f))); }
    };

    /// Bits of the columns of blocks in some rows of blocks.
    [[gnu::always_inline]] static Ints columns(const Outline& o, const TileGrid& grid, const ScreenRect& rect, float row) {
        constexpr float kGuard = 0.01f;  // of a pixel, for the rounding of s
        const Lanes lane([](auto k) { return static_cast<float>(static_cast<int>(k) * kBlockHeight); });
        const Lanes y = lane + row * kBlockHeight;
        const Lanes t_0 = y * grid.step + grid.start_t, t_1 = t_0 + (kBlockHeight - 1) * grid.step;
        const Reach left(o, o.left_t, t_0, t_1), right(o, o.right_t, t_0, t_1);
        const float to_px = 1 / grid.step;
        const Lanes lo = (left.middle - left.half() - grid.start_s) * to_px + (1 - kGuard);
        Lanes hi = (right.middle + right.half() - grid.start_s) * to_px + kGuard;
        stdx::where(right.sq_half < 0.0f, hi) = -1.0f;
        // Bounded on both sides: a pixel far beyond the picture is no int. Where nothing is known
        // (NaN) all is in.
        const Lanes begin(static_cast<float>(rect.x0)), last(static_cast<float>(rect.x1 - 1));
        const auto x_0 = stdx::static_simd_cast<Ints>(stdx::min(stdx::max(begin, lo), last + 1.0f));
        const auto x_1 = stdx::static_simd_cast<Ints>(stdx::max(stdx::min(last, hi), begin - 1.0f) + 1.0f);
        const Ints first = x_0 / kBlockWidth, end = stdx::max(first, (x_1 + (kBlockWidth - 1)) / kBlockWidth);
        return (Ints(1) << end) - (Ints(1) << first);
    }
    [[gnu::always_inline]] void put(std::size_t row, const Ints& bits) {
#ifdef __AVX512VL__
        if constexpr (kRows == 8) {
            const __m128i bytes = _mm256_cvtepi32_epi8(static_cast<__m256i>(bits));
            blocks_.add(row * 8, static_cast<std::uint64_t>(_mm_cvtsi128_si64(bytes)));
            return;
        }
#endif
        for (std::size_t k = 0; k < static_cast<std::size_t>(kRows); ++k)
            blocks_.add((row + k) * 8, static_cast<std::uint64_t>(static_cast<int>(bits[k])));
    }
};

}  // namespace slim
