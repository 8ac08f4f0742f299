#include "raytrace/lines/extract.h"

#include "raytrace/lines/crossings.h"
#include "raytrace/lines/link.h"
#include "raytrace/lines/select.h"
#include "slim/base/check.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <iterator>

namespace slim {
namespace {

constexpr int kSmoothingPasses = 8;

CrossingField crossings_of(LineKind kind, const LineScene& scene, const Sheets& sheets) {
    switch (kind) {
        case LineKind::contour:
            return contour_crossings(scene, sheets);
        case LineKind::suggestive:
            return suggestive_crossings(scene, sheets);
        case LineKind::ridge:
            return crest_crossings(scene, sheets, true);
        case LineKind::valley:
            return crest_crossings(scene, sheets, false);
        case LineKind::parabolic:
            return parabolic_crossings(scene, sheets);
        case LineKind::reflection:
            break;
    }
    return reflection_crossings(scene, sheets);
}

std::vector<FeatureLine> lines_of(LineKind kind, const LineScene& scene, const Sheets& sheets) {
    std::vector<FeatureLine> lines =
        select_lines(link_crossings(scene, crossings_of(kind, scene, sheets), kind),
                     line_rules(kind, scene.buffer.width, scene.buffer.height));
    for (FeatureLine& line : lines) {
        smooth_line(line, kSmoothingPasses);
        measure_line(line);
    }
    return lines;
}

}  // namespace

std::vector<FeatureLine> extract_lines(const LineScene& scene, std::span<const LineKind> kinds) {
    SLIM_CHECK(scene.buffer.has(line_channels(kinds, scene.degree)), ==, true);
    if (kinds.empty()) return {};
    const Sheets sheets(scene);
    std::vector<std::vector<FeatureLine>> of(kinds.size());
    parallel_blocks(kinds.size(), 1, [&](std::size_t k, std::size_t) { of[k] = lines_of(kinds[k], scene, sheets); });
    std::vector<FeatureLine> out;
    for (auto& lines : of) std::move(lines.begin(), lines.end(), std::back_inserter(out));
    return out;
}

}  // namespace slim
