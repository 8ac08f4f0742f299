#pragma once

#include "raytrace/pixel_block.h"
#include "slim/base/hash.h"
#include "slim/base/simd.h"

#include <array>
#include <cmath>
#include <cstdint>

namespace slim {

/// A key for the random numbers of each lane: of its pixel and of what they are for, so that
/// threads cannot change them; and the pixel's place in its 4 x 4 pixels.
struct LaneKeys {
    std::array<std::uint64_t, kLanes> key;
    std::array<std::uint32_t, kLanes> place;  ///< 0 to 15, far apart for neighbours

    LaneKeys(const PixelBlock& block, std::uint64_t purpose) {
        for (int lane = 0; lane < kLanes; ++lane) {
            const auto x = static_cast<std::uint64_t>(block.x_of(lane)),
                       y = static_cast<std::uint64_t>(block.y_of(lane));
            key[static_cast<std::size_t>(lane)] = keyed_hash(0x726179, y << 32 | x, purpose);
            place[static_cast<std::size_t>(lane)] = swapped(x ^ y) | swapped(x) << 2;
        }
    }

private:
    /// The last two bits, swapped.
    static std::uint32_t swapped(std::uint64_t v) {
        return static_cast<std::uint32_t>((v & 1) << 1 | (v >> 1 & 1));
    }
};

/// Samples of [0, 1]^2, one in each cell of a square grid: stratified, and alike in neighbouring
/// lanes, so that their rays keep together.
class SampleGrid {
public:
    /// interleaved: any 4 x 4 pixels have theirs in all sixteenths of a cell (Keller and Heidrich
    /// 2001), so that together they are a grid of 16 times the cells. For what is filtered over
    /// these pixels; else it shows as a screen of dots.
    enum class Pixels { independent, interleaved };

    /// At least n samples.
    explicit SampleGrid(int n, Pixels pixels = Pixels::independent)
        : side_(static_cast<int>(std::ceil(std::sqrt(static_cast<double>(n)) - 1e-9))),
          pixels_(pixels) {}

    int n() const { return side_ * side_; }
    void sample(int i, const LaneKeys& keys, FloatV& s, FloatV& t) const {
        const float size = 1 / static_cast<float>(side_);
        const auto column = static_cast<float>(i % side_), row = static_cast<float>(i / side_);
        const auto turn = static_cast<std::uint32_t>(mix64(static_cast<std::uint64_t>(i)) & 15u);
        FloatV a, b;
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const std::uint64_t hash = mix64(keys.key[lane] + static_cast<std::uint64_t>(i));
            a[lane] = low_bits(hash), b[lane] = low_bits(hash >> 32);
            if (pixels_ == Pixels::independent) continue;
            const std::uint32_t part = keys.place[lane] ^ turn;
            a[lane] = 0.25f * (static_cast<float>(part & 3u) + a[lane]);
            b[lane] = 0.25f * (static_cast<float>(part >> 2) + b[lane]);
        }
        s = (column + a) * size, t = (row + b) * size;
    }

private:
    static float low_bits(std::uint64_t x) { return static_cast<float>(x & 0xffffffu) * 0x1p-24f; }

    int side_;
    Pixels pixels_;
};

}  // namespace slim
