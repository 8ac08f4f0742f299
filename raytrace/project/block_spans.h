#pragma once

#include "raytrace/project/block_mask.h"
#include "raytrace/project/outline.h"
#include "raytrace/project/tile_buffers.h"
#include "slim/base/lane_turns.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace slim {

/// The blocks of a tile that some outlines touch, worked out side by side.
class BlockSpans {
public:
    /// A surfel's in one lane; it stays where it is until find().
    [[gnu::always_inline]] void set(std::size_t lane, const Footprint& f) { rows_[lane] = &f; }

    /// Of all lanes.
    [[gnu::always_inline]] void find(const TileBuffers& t) {
        constexpr float kGuard = 0.01f;  // of a pixel, for the rounding of s
        const Columns n(rows_);
        const Curve o(n);
        // s = start_s + x step, t = start_t + y step, x and y counted from the tile's first pixel.
        const FloatV pixel_x = n[7], pixel_y = n[8], step = n[11], to_px = 1.0f / step;
        const FloatV start_s = n[9] + (static_cast<float>(t.x0) - pixel_x) * step;
        const FloatV start_t = n[10] + (static_cast<float>(t.y0) - pixel_y) * step;
        const Ints x_begin = stdx::max(n.side(0), Ints(t.clip.x0)) - t.x0,
                   y_begin = stdx::max(n.side(1), Ints(t.clip.y0)) - t.y0;
        const Ints x_end = stdx::min(n.side(2), Ints(t.clip.x1)) - t.x0,
                   y_end = stdx::min(n.side(3), Ints(t.clip.y1)) - t.y0;
        const auto empty = x_begin >= x_end;
        const FloatV begin = stdx::static_simd_cast<FloatV>(x_begin),
                     last = stdx::static_simd_cast<FloatV>(x_end) - 1.0f;
        for (int part = 0; part < kParts; ++part) {
            Ints bits(0);
            for (int k = 0; k < 4; ++k) {
                const int y = (4 * part + k) * kBlockHeight;
                const FloatV t_0 = static_cast<float>(y) * step + start_t,
                             t_1 = t_0 + (kBlockHeight - 1) * step;
                const Reach left(o, o.left_t, t_0, t_1), right(o, o.right_t, t_0, t_1);
                const FloatV lo = (left.middle - left.half() - start_s) * to_px + (1 - kGuard);
                FloatV hi = (right.middle + right.half() - start_s) * to_px + kGuard;
                stdx::where(right.sq_half < 0.0f, hi) = -1.0f;
                // Bounded on both sides: a pixel far beyond the picture is no int. Where nothing is
                // known (NaN) all is in.
                const auto x_0 =
                    stdx::static_simd_cast<Ints>(stdx::min(stdx::max(begin, lo), last + 1.0f));
                const auto x_1 = stdx::static_simd_cast<Ints>(
                    stdx::max(stdx::min(last, hi), begin - 1.0f) + 1.0f);
                const Ints first = x_0 >> kShift,
                           end = stdx::max(first, (x_1 + (kBlockWidth - 1)) >> kShift);
                Ints columns = (Ints(1) << end) - (Ints(1) << first);
                stdx::where(empty || y_begin >= y + kBlockHeight || y_end <= y, columns) = 0;
                bits |= columns << (8 * k);
            }
            bits.copy_to(bits_[static_cast<std::size_t>(part)].data(), stdx::vector_aligned);
        }
    }
    [[gnu::always_inline]] BlockMask blocks(std::size_t lane) const {
        BlockMask mask;
        for (std::size_t part = 0; part < kParts; ++part)
            mask.add(32 * part, static_cast<std::uint32_t>(bits_[part][lane]));
        return mask;
    }

private:
    using Ints = stdx::rebind_simd_t<int, FloatV>;
    static_assert(kBlockColumns == 8 && kBlockRows % 4 == 0);
    static constexpr int kParts = kBlockRows / 4,
                         kShift = std::countr_zero(static_cast<unsigned>(kBlockWidth));
    static constexpr std::size_t kMembers = sizeof(Footprint) / sizeof(float);
    static_assert(kMembers == 16 && kMembers % kLanes == 0 &&
                  offsetof(Footprint, rect) == 12 * sizeof(float));
    inline static const Footprint kNone{};
    using Rows = std::array<const Footprint*, kLanes>;

    Rows rows_ = [] {
        Rows rows;
        rows.fill(&kNone);
        return rows;
    }();
    alignas(64) std::array<std::array<int, kLanes>, kParts> bits_;  ///< four rows of blocks each

    /// Member k of all footprints.
    class Columns {
    public:
        [[gnu::always_inline]] explicit Columns(const Rows& rows) {
            for (std::size_t part = 0; part < kMembers / kLanes; ++part) {
                std::array<FloatV, kLanes> some;
                for (std::size_t lane = 0; lane < kLanes; ++lane)
                    std::memcpy(&some[lane],
                                reinterpret_cast<const char*>(rows[lane]) +
                                    part * sizeof(FloatV),
                                sizeof(FloatV));
                turn(some);
                std::copy_n(some.begin(), kLanes, columns_.begin() + part * kLanes);
            }
        }
        [[gnu::always_inline]] const FloatV& operator[](std::size_t k) const { return columns_[k]; }
        [[gnu::always_inline]] Ints side(std::size_t k) const {
            return std::bit_cast<Ints>(columns_[12 + k]);
        }

    private:
        std::array<FloatV, kMembers> columns_;
    };

    /// As in Outline.
    struct Curve {
        FloatV b0, b1, c0, c1, c2, left_t, right_t;
        [[gnu::always_inline]] explicit Curve(const Columns& n)
            : b0(n[0]), b1(n[1]), c0(n[2]), c1(n[3]), c2(n[4]), left_t(n[5]), right_t(n[6]) {}
    };
    /// The most that the outline reaches to one side over some rows of pixels: where it is widest,
    /// or at the row nearest to there. Beyond the outline's own rows no column is in.
    struct Reach {
        FloatV middle, sq_half;
        [[gnu::always_inline]] Reach(const Curve& o, const FloatV& widest, const FloatV& t_0,
                                     const FloatV& t_1) {
            const FloatV t = stdx::min(stdx::max(widest, t_0), t_1);
            const FloatV b = o.b0 + o.b1 * t;
            middle = -b;
            sq_half = b * b - (o.c0 + t * (2.0f * o.c1 + o.c2 * t));
        }
        /// To a few units in the last place, far below kGuard: exact roots would be a quarter of
        /// the work on a surfel's rows.
        [[gnu::always_inline]] FloatV half() const {
            const FloatV sq = stdx::max(sq_half, FloatV(1e-30f));
            return sq * inverse_sqrt(sq);
        }
    };
};

}  // namespace slim
