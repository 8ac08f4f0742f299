#include "pipeline/render/render_colors.h"

#include "pipeline/render/render_aov.h"
#include "slim/base/parallel.h"

namespace slim {
namespace {

/// Calls color(k, linear colour) at the hits of n pixels from `first` on, in parallel.
template <class Color>
void for_scan_colors(const ColorBlend& colors, const GBuffer& b, std::size_t first, std::size_t n,
                     const Color& color) {
    parallel_blocks(n, 1 << 12, [&](std::size_t begin, std::size_t end) {
        std::vector<const Surfel*> found;
        for (std::size_t k = begin; k < end; ++k) {
            const std::size_t i = first + k;
            if (!b.hit[i]) continue;
            const Vec3d p{b.position[0][i], b.position[1][i], b.position[2][i]};
            const Vec3d normal{b.normal[0][i], b.normal[1][i], b.normal[2][i]};
            const Vec3f c = colors.at(p, normal, b.surfel_id[i], found);
            color(k, Vec3f{linear_from_srgb(c.x), linear_from_srgb(c.y), linear_from_srgb(c.z)});
        }
    });
}

}  // namespace

Picture paint_colors(const ColorBlend& colors, const RenderedFrame& frame, const RowRange& rows) {
    const GBuffer& b = frame.buffer;
    Picture out(b.width, rows.end - rows.begin);
    for_scan_colors(colors, b, b.index(0, rows.begin), out.n_pixels(),
                    [&](std::size_t k, const Vec3f& c) {
                        float* const pixel = &out.rgba[4 * k];
                        pixel[0] = c.x, pixel[1] = c.y, pixel[2] = c.z, pixel[3] = 1;
                    });
    return out;
}

std::vector<Vec3f> scan_colors(const ColorBlend& colors, const RenderedFrame& frame) {
    std::vector<Vec3f> out(frame.buffer.n_pixels());
    for_scan_colors(colors, frame.buffer, 0, out.size(),
                    [&](std::size_t k, const Vec3f& c) { out[k] = c; });
    return out;
}

}  // namespace slim
