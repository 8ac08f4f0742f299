#include "pipeline/render_aov.h"

#include "pipeline/render_maps.h"
#include "slim/base/error.h"
#include "slim/base/hash.h"
#include "slim/base/parallel.h"
#include "slim/shapes/foot_point.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace slim {
namespace {

constexpr std::size_t kPixelGrain = 1 << 12;
constexpr float kMapLightFloor = 0.5f;

const std::map<std::string, Channels>& channel_table() {
    static const std::map<std::string, Channels> table{
        {"shaded", kNormalChannel},      {"mean", kCurvatureChannel},
        {"gauss", kCurvatureChannel},    {"k1", kCurvatureChannel},
        {"k2", kCurvatureChannel},       {"normal", kNormalChannel},
        {"depth", kDepthChannel},        {"position", kPositionChannel},
        {"id", kSurfelIdChannel},        {"error", kFitErrorChannel},
        {"level", kLevelChannel},        {"coverage", kCoverageChannel},
        {"truth_distance", kPositionChannel},
    };
    return table;
}

NormalPlanes normal_planes(const GBuffer& b) { return {b.normal[0], b.normal[1], b.normal[2]}; }

std::span<const float> plane_of(const std::string& aov, const RenderedFrame& frame) {
    const GBuffer& b = frame.buffer;
    return aov == "mean"       ? b.mean
           : aov == "gauss"    ? b.gauss
           : aov == "k1"       ? b.k1
           : aov == "k2"       ? b.k2
           : aov == "depth"    ? b.depth
           : aov == "error"    ? b.fit_error
           : aov == "coverage" ? b.coverage
                               : frame.truth_distance;
}

/// Calls color(i) -> display-referred sRGB at every hit.
template <class Color>
Picture paint_hits(const GBuffer& b, const Color& color) {
    Picture out(b.width, b.height);
    parallel_blocks(b.n_pixels(), kPixelGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!b.hit[i]) continue;
            const Vec3f c = color(i);
            float* p = &out.rgba[4 * i];
            p[0] = linear_from_srgb(c.x), p[1] = linear_from_srgb(c.y);
            p[2] = linear_from_srgb(c.z), p[3] = 1;
        }
    });
    return out;
}

Picture draw_normals(const GBuffer& b) {
    return paint_hits(b, [&](std::size_t i) {
        return Vec3f{b.normal[0][i], b.normal[1][i], b.normal[2][i]} * 0.5f + Vec3f{0.5f, 0.5f, 0.5f};
    });
}

/// Position over the model's bounds, each axis its own colour.
Picture draw_positions(const GBuffer& b, const Bbox& bounds) {
    const Vec3f lo = to_float(bounds.lo), extent = to_float(bounds.extent());
    return paint_hits(b, [&](std::size_t i) {
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
        return static_cast<float>(value * (0.40 + 0.60 * std::clamp(std::abs(h - 3) - 1, 0.0, 1.0)));
    };
    return {channel(0), channel(4), channel(2)};
}

Picture draw_ids(const GBuffer& b) {
    return paint_hits(b, [&](std::size_t i) { return color_of_id(b.surfel_id[i]); });
}

AovPicture draw_levels(const GBuffer& b) {
    const ValueRange levels = full_range(b.level, b.hit);
    const double lo = std::round(levels.lo);
    // At least five steps, so that the legend's ticks are whole numbers.
    const int n = std::max(5, static_cast<int>(std::round(levels.hi) - lo) + 1);
    AovPicture out;
    out.own_map = std::make_shared<const ColorMap>(stepped_viridis(n));
    const ValueRange range{lo - 0.5, lo + n - 0.5};
    out.picture = paint(b.width, b.height, *out.own_map, range, b.level, b.hit);
    out.legend = Legend{"level", "1: coarsest", out.own_map.get(), range, "", ""};
    return out;
}

AovPicture draw_map(const RenderConfig& config, const std::string& aov, const RenderedFrame& frame,
                    double diagonal) {
    const GBuffer& b = frame.buffer;
    const std::span<const float> values = plane_of(aov, frame);
    const ValueRange range = map_range(config, aov, values, b.hit, diagonal);
    AovPicture out;
    out.legend = make_legend(config, aov, range, values, b.hit);
    out.picture = paint(b.width, b.height, *out.legend->map, range, values, b.hit);
    if (config.light_maps && channel_table().at(aov) == kCurvatureChannel)
        light_picture(frame.view, normal_planes(b), b.hit, kMapLightFloor, out.picture);
    return out;
}

Vec3d shape_offset(const RenderConfig& config) {
    if (config.offset.empty()) return {};
    if (config.offset.size() != 3)
        throw ConfigError("offset: expected three numbers x,y,z, found " +
                          std::to_string(config.offset.size()));
    return {config.offset[0], config.offset[1], config.offset[2]};
}

}  // namespace

std::vector<std::string> wanted_aovs(const RenderConfig& config) {
    std::vector<std::string> aovs;
    const auto add = [&](const std::string& aov) {
        if (std::find(aovs.begin(), aovs.end(), aov) == aovs.end()) aovs.push_back(aov);
    };
    for (const std::string& aov : config.aov) {
        if (aov != "all") add(aov);
        else
            for (const char* each : {"shaded", "mean", "gauss", "k1", "k2", "normal", "depth",
                                     "position", "id", "error", "level", "coverage"})
                add(each);
    }
    if (aovs.empty()) throw ConfigError("aov: expected at least one");
    const bool truth = std::find(aovs.begin(), aovs.end(), "truth_distance") != aovs.end();
    if (truth && config.truth_shape.empty())
        throw ConfigError("aov truth_distance needs a truth_shape to measure against");
    if (!truth && !config.truth_shape.empty())
        throw ConfigError("truth_shape is for the aov truth_distance, which is not asked for");
    if (!truth && !config.offset.empty())
        throw ConfigError("offset is for the aov truth_distance, which is not asked for");
    return aovs;
}

Channels channels_of(const std::vector<std::string>& aovs, bool light_maps) {
    Channels channels = 0;
    for (const std::string& aov : aovs) {
        const Channels own = channel_table().at(aov);
        channels |= own;
        if (light_maps && own == kCurvatureChannel) channels |= kNormalChannel;
    }
    return channels;
}

bool is_filterable(const std::string& aov) {
    return aov != "id" && aov != "level" && aov != "truth_distance";
}

std::vector<float> truth_distances(const RenderConfig& config, const Vec3d& model_origin,
                                   const GBuffer& b) {
    const Shape& shape = find_shape(config.truth_shape);
    const Vec3d shift = model_origin - shape_offset(config);
    std::vector<float> distances(b.n_pixels(), 0.0f);
    parallel_blocks(b.n_pixels(), kPixelGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!b.hit[i]) continue;
            const Vec3d p{b.position[0][i], b.position[1][i], b.position[2][i]};
            distances[i] = static_cast<float>(signed_distance(shape, p + shift));
        }
    });
    return distances;
}

AovPicture draw_aov(const RenderConfig& config, const std::string& aov, const RenderedFrame& frame,
                    const Bbox& bounds) {
    AovPicture out;
    if (aov == "shaded") out.picture = frame.shaded;
    else if (aov == "normal") out.picture = draw_normals(frame.buffer);
    else if (aov == "position") out.picture = draw_positions(frame.buffer, bounds);
    else if (aov == "id") out.picture = draw_ids(frame.buffer);
    else if (aov == "level") out = draw_levels(frame.buffer);
    else out = draw_map(config, aov, frame, bounds.diagonal());
    return out;
}

}  // namespace slim
