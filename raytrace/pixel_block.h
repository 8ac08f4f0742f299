#pragma once

#include "raytrace/renderer.h"
#include "raytrace/sample_mask.h"
#include "slim/base/simd.h"

#include <cstddef>
#include <functional>

namespace slim {

/// A packet has a block of pixels in its lanes: kPacketWidth x kPacketHeight, row by row.
inline constexpr int kPacketWidth = kLanes >= 4 ? 4 : kLanes;
inline constexpr int kPacketHeight = kLanes / kPacketWidth;

/// The pixels of a packet: those of a block of the whole picture that lie in a window. Blocks start
/// at multiples of their size in the picture, so that a window's pixels are in the packets that the
/// picture's are in.
struct PixelBlock {
    int x = 0, y = 0;  ///< first pixel, in the picture
    PixelWindow window;
    const SampleMask* only = nullptr;  ///< pixels that it leaves out are in no lane

    int x_of(int lane) const { return x + lane % kPacketWidth; }
    int y_of(int lane) const { return y + lane / kPacketWidth; }
    bool holds(int lane) const {
        const int px = x_of(lane) - window.x, py = y_of(lane) - window.y;
        return px >= 0 && py >= 0 && px < window.width && py < window.height &&
               (!only || only->has_sample(x_of(lane), y_of(lane)));
    }
    /// Entry of a lane's pixel in planes of the window.
    std::size_t index(int lane) const {
        return static_cast<std::size_t>(y_of(lane) - window.y) *
                   static_cast<std::size_t>(window.width) +
               static_cast<std::size_t>(x_of(lane) - window.x);
    }
};

/// Calls visit(row of blocks, block) for all blocks of a window; rows of blocks, which count from
/// 0, over threads. Of a mask only the blocks that hold a sample.
void for_blocks(const PixelWindow& window,
                const std::function<void(std::size_t, const PixelBlock&)>& visit,
                const SampleMask* only = nullptr);
std::size_t n_block_rows(const PixelWindow& window);

}  // namespace slim
