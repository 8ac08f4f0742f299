#include "pipeline/render/render_aov.h"

#include "pipeline/render/render_asked.h"
#include "pipeline/render/render_bands.h"
#include "pipeline/render/render_directions.h"
#include "pipeline/render/render_look.h"
#include "pipeline/render/render_maps.h"
#include "pipeline/render/render_shadings.h"
#include "pipeline/shape_name.h"
#include "slim/base/hash.h"
#include "slim/base/parallel.h"
#include "slim/shapes/foot_point.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace slim {
namespace {

constexpr std::size_t kPixelGrain = 1 << 12;
constexpr float kMapLightFloor = 0.5f;

NormalPlanes normal_planes(const GBuffer& b) { return {b.normal[0], b.normal[1], b.normal[2]}; }

bool is_direction(const std::string& aov) { return aov == "dir1" || aov == "dir2"; }

std::span<const float> plane_of(const std::string& aov, const RenderedFrame& frame) {
    const GBuffer& b = frame.buffer;
    return aov == "mean"       ? b.mean
           : aov == "gauss"    ? b.gauss
           : aov == "k1"       ? b.k1
           : aov == "k2"       ? b.k2
           : aov == "depth"    ? b.depth
           : aov == "error"    ? b.fit_error
           : aov == "coverage" ? b.coverage
           : aov == "level"    ? b.level
           : aov == "e1"       ? b.third[0]
           : aov == "dk1_dt2"  ? b.third[1]
           : aov == "dk2_dt1"  ? b.third[2]
           : aov == "e2"       ? b.third[3]
                               : frame.truth_distance;
}

/// Calls color(i) -> display-referred sRGB at every hit of some rows.
template <class Color>
Picture paint_hits(const GBuffer& b, const RowRange& rows, const Color& color) {
    Picture out(b.width, rows.end - rows.begin);
    const std::size_t first = b.index(0, rows.begin);
    parallel_blocks(out.n_pixels(), kPixelGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!b.hit[first + i]) continue;
            const Vec3f c = color(first + i);
            float* p = &out.rgba[4 * i];
            p[0] = linear_from_srgb(c.x), p[1] = linear_from_srgb(c.y);
            p[2] = linear_from_srgb(c.z), p[3] = 1;
        }
    });
    return out;
}

/// The rows of a plane that is painted as a map.
Picture paint_map(const GBuffer& b, const RowRange& rows, const Legend& legend,
                  std::span<const float> values) {
    const int n_rows = rows.end - rows.begin;
    const std::size_t first = b.index(0, rows.begin), n = b.index(0, n_rows);
    return paint(b.width, n_rows, *legend.map, legend.range, values.subspan(first, n),
                 std::span(b.hit).subspan(first, n));
}

Picture paint_normals(const GBuffer& b, const RowRange& rows) {
    return paint_hits(b, rows, [&](std::size_t i) {
        return Vec3f{b.normal[0][i], b.normal[1][i], b.normal[2][i]} * 0.5f +
               Vec3f{0.5f, 0.5f, 0.5f};
    });
}

/// Position over the model's bounds, each axis its own colour.
Picture paint_positions(const GBuffer& b, const Bbox& bounds, const RowRange& rows) {
    const Vec3f lo = to_float(bounds.lo), extent = to_float(bounds.extent());
    return paint_hits(b, rows, [&](std::size_t i) {
        Vec3f c;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const float from_lo = b.position[axis][i] - lo[axis];
            c[axis] = extent[axis] > 0 ? std::clamp(from_lo / extent[axis], 0.0f, 1.0f) : 0.5f;
        }
        return c;
    });
}

/// A colour per id that says nothing but "the same surfel": pleasant, and far from its neighbours'.
Vec3f color_of_id(std::uint32_t id) {
    const std::uint64_t hash = keyed_hash(0x69645f636f6c6f72, id);
    const double hue = 6 * unit_interval(hash), value = 0.55 + 0.4 * unit_interval(mix64(hash));
    const auto channel = [&](double shift) {
        const double h = std::fmod(hue + shift, 6.0);
        return static_cast<float>(value *
                                  (0.40 + 0.60 * std::clamp(std::abs(h - 3) - 1, 0.0, 1.0)));
    };
    return {channel(0), channel(4), channel(2)};
}

Picture paint_ids(const GBuffer& b, const RowRange& rows) {
    return paint_hits(b, rows, [&](std::size_t i) { return color_of_id(b.surfel_id[i]); });
}

/// Openness as light: white clay under an even sky.
Picture paint_openness(const RenderedFrame& frame, const RowRange& rows) {
    return paint_hits(frame.buffer, rows, [&](std::size_t i) {
        const float display = srgb_from_linear(frame.open[i]);
        return Vec3f{display, display, display};
    });
}

/// The pixels of a part that a picture of that size has of the frame.
PictureSize part_size(const RenderedFrame& frame, const PictureSize& size) {
    const int factor = frame.size.width / size.width;
    return {frame.buffer.width / factor, frame.buffer.height / factor};
}

}  // namespace

std::vector<float> truth_distances(const RenderConfig& config, const Vec3d& model_origin,
                                   const GBuffer& b, std::uint64_t* n_unknown) {
    const Shape& shape = find_shape(config.truth_shape);
    const Vec3d shift = model_origin - shape_offset(config.offset);
    std::vector<float> distances(b.n_pixels(), 0.0f);
    std::atomic<std::uint64_t> unknown{0};
    parallel_blocks(b.n_pixels(), kPixelGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!b.hit[i]) continue;
            const Vec3d p{b.position[0][i], b.position[1][i], b.position[2][i]};
            const auto foot = nearest_point(shape, p + shift);
            if (foot) distances[i] = static_cast<float>(foot->signed_distance);
            else ++unknown;
        }
    });
    if (n_unknown) *n_unknown = unknown;
    return distances;
}

MapValues map_values(const std::string& aov, const RenderedFrame& frame) {
    MapValues out{plane_of(aov, frame), {}};
    if (!is_third_order(aov)) return out;
    out.magnitudes.resize(out.plane.size());
    std::transform(out.plane.begin(), out.plane.end(), out.magnitudes.begin(),
                   [](float v) { return std::abs(v); });
    return out;
}

Picture draw_aov(const RenderConfig& config, const std::string& aov, const AovLook& look,
                 const ShadingInputs& shadings, const RenderedFrame& frame, const Bbox& bounds,
                 const PictureSize& size) {
    const GBuffer& b = frame.buffer;
    const PictureSize part = part_size(frame, size);
    const auto painted = [&](const auto& paint_rows) {
        return paint_in_bands({b.width, b.height}, part, paint_rows);
    };
    if (aov == "shaded") return frame.shaded;
    if (aov == "lines") return Picture(part.width, part.height);
    if (is_shading(aov))
        return painted([&](const RowRange& r) {
            Picture band = paint_shading(aov, shadings, frame, r, look.heights,
                                         frame.size.width / size.width);
            if (aov == "color" && config.light_maps)
                light_picture(frame.view, normal_planes(b), b.hit, kMapLightFloor, band, r.begin);
            return band;
        });
    if (is_direction(aov)) {
        const PixelDiagonals diagonals = frame.diagonals.empty()
                                             ? PixelDiagonals(bounds.diagonal())
                                             : PixelDiagonals(frame.diagonals, frame.traced.model);
        return painted(
            [&](const RowRange& r) { return paint_directions(b, diagonals, aov == "dir2", r); });
    }
    if (aov == "normal") return painted([&](const RowRange& r) { return paint_normals(b, r); });
    if (aov == "position")
        return painted([&](const RowRange& r) { return paint_positions(b, bounds, r); });
    if (aov == "id") return painted([&](const RowRange& r) { return paint_ids(b, r); });
    if (aov == "ao") return painted([&](const RowRange& r) { return paint_openness(frame, r); });
    const MapValues values = map_values(aov, frame);
    const bool lit = config.light_maps && is_curvature(aov);
    return painted([&](const RowRange& rows) {
        Picture band = paint_map(b, rows, *look.legend, values.span());
        if (lit)
            light_picture(frame.view, normal_planes(b), b.hit, kMapLightFloor, band, rows.begin);
        return band;
    });
}

}  // namespace slim
