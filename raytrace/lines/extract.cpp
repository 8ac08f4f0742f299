#include "raytrace/lines/extract.h"

#include "raytrace/lines/crossings.h"
#include "raytrace/lines/link.h"
#include "raytrace/lines/select.h"
#include "slim/base/check.h"

namespace slim {
namespace {

constexpr int kSmoothingPasses = 8;

CrossingField crossings_of(const LineScene& scene, LineKind kind) {
    switch (kind) {
        case LineKind::contour:
            return contour_crossings(scene);
        case LineKind::suggestive:
            return suggestive_crossings(scene);
        case LineKind::ridge:
            return crest_crossings(scene, true);
        case LineKind::valley:
            return crest_crossings(scene, false);
        case LineKind::parabolic:
            return parabolic_crossings(scene);
        case LineKind::reflection:
            break;
    }
    return reflection_crossings(scene);
}

}  // namespace

std::vector<FeatureLine> extract_lines(const LineScene& scene, std::span<const LineKind> kinds) {
    SLIM_CHECK(scene.buffer.has(line_channels(kinds, scene.degree)), ==, true);
    std::vector<FeatureLine> out;
    for (const LineKind kind : kinds) {
        std::vector<FeatureLine> lines =
            select_lines(link_crossings(scene, crossings_of(scene, kind), kind),
                         line_rules(kind, scene.buffer.width, scene.buffer.height));
        for (FeatureLine& line : lines) {
            smooth_line(line, kSmoothingPasses);
            measure_line(line);
            out.push_back(std::move(line));
        }
    }
    return out;
}

}  // namespace slim
