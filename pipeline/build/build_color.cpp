#include "pipeline/build/build_color.h"

#include "formats/model_file.h"
#include "formats/point_source.h"
#include "slim/base/error.h"
#include "slim/color/color_fit.h"

#include <algorithm>

namespace slim {
namespace {

constexpr std::size_t kPiece = 1 << 16;

/// Adds a cloud's points to the fit; false if it has no colours.
bool add_cloud(const std::string& path, const Vec3d& origin, StageContext& context, ColorFit& fit,
               std::uint64_t& n) {
    const auto source = open_colored_cloud(path);
    if (!source) return false;
    PointChunk chunk;
    while (source->read(chunk, kPiece)) {
        context.reporter.progress("colours", source->bytes_read(), source->info().file_size);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            if (!is_finite(chunk.position[i]) || !is_finite(chunk.color[i])) continue;
            chunk.position[kept] = chunk.position[i] - origin, chunk.color[kept] = chunk.color[i];
            if (!chunk.normal.empty()) chunk.normal[kept] = chunk.normal[i];
            ++kept;
        }
        const auto first = [&](const auto& values) {
            return std::span(values).first(std::min(kept, values.size()));
        };
        fit.add(first(chunk.position), first(chunk.normal), first(chunk.color));
        n += kept;
    }
    return true;
}

[[noreturn]] void refuse_colorless(const std::string& path) {
    throw DataError(path +
                    ": --color: expected a PLY with properties red, green and blue, found none");
}

}  // namespace

void require_colors(const std::vector<std::string>& clouds) {
    const auto has_colors = [](const std::string& cloud) { return !!open_colored_cloud(cloud); };
    if (!clouds.empty() && std::none_of(clouds.begin(), clouds.end(), has_colors))
        refuse_colorless(clouds[0]);
}

nlohmann::json add_colors(const std::string& path, const std::vector<std::string>& clouds,
                          StageContext& context) {
    std::uint64_t n = 0, lost = 0;
    std::vector<PackedColor> packed;
    {
        const ModelFile model = ModelFile::open(path);
        const SurfelTree tree = model.tree();
        ColorFit fit(tree);
        bool any = false;
        for (const std::string& cloud : clouds) {
            const bool has = add_cloud(cloud, tree.header().origin, context, fit, n);
            if (!has && clouds.size() > 1)
                context.reporter.warn(
                    cloud + ": has no colours (a PLY with red, green and blue): left out of them");
            any |= has;
        }
        if (!any) refuse_colorless(clouds.empty() ? path : clouds[0]);
        for (const SurfelColor& color : fit.finish()) packed.push_back(pack(color));
        lost = fit.n_lost();
    }
    write_model_colors(path, packed);
    return {{"points", n}, {"lost", lost}};
}

}  // namespace slim
