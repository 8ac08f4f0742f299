#include "raytrace/pixel_block.h"

#include "slim/base/parallel.h"

namespace slim {
namespace {

/// Where a row or column of blocks begins that holds pixel i (i >= 0).
int block_start(int i, int size) { return i / size * size; }

}  // namespace

std::size_t n_block_rows(const PixelWindow& w) {
    const int first = block_start(w.y, kPacketHeight);
    return static_cast<std::size_t>((w.y + w.height - first + kPacketHeight - 1) / kPacketHeight);
}

void for_blocks(const PixelWindow& w,
                const std::function<void(std::size_t, const PixelBlock&)>& visit,
                const SampleMask* only) {
    const int x0 = block_start(w.x, kPacketWidth), y0 = block_start(w.y, kPacketHeight);
    parallel_blocks(n_block_rows(w), 1, [&](std::size_t row, std::size_t) {
        const int y = y0 + static_cast<int>(row) * kPacketHeight;
        for (int x = x0; x < w.x + w.width; x += kPacketWidth)
            if (!only || only->any_sample({x, y, kPacketWidth, kPacketHeight}))
                visit(row, {x, y, w, only});
    });
}

}  // namespace slim
