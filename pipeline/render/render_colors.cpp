#include "pipeline/render/render_colors.h"

#include "pipeline/render/render_aov.h"
#include "slim/base/parallel.h"

namespace slim {

Picture paint_colors(const ColorBlend& colors, const RenderedFrame& frame, const RowRange& rows) {
    const GBuffer& b = frame.buffer;
    Picture out(b.width, rows.end - rows.begin);
    const std::size_t first = b.index(0, rows.begin);
    parallel_blocks(out.n_pixels(), 1 << 12, [&](std::size_t begin, std::size_t end) {
        std::vector<const Surfel*> found;
        for (std::size_t k = begin; k < end; ++k) {
            const std::size_t i = first + k;
            if (!b.hit[i]) continue;
            const Vec3d p{b.position[0][i], b.position[1][i], b.position[2][i]};
            const Vec3d n{b.normal[0][i], b.normal[1][i], b.normal[2][i]};
            const Vec3f c = colors.at(p, n, b.surfel_id[i], found);
            float* pixel = &out.rgba[4 * k];
            for (std::size_t channel = 0; channel < 3; ++channel)
                pixel[channel] = linear_from_srgb(c[channel]);
            pixel[3] = 1;
        }
    });
    return out;
}

}  // namespace slim
