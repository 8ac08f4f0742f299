#include "raytrace/lines/extract.h"

#include "raytrace/lines/creases.h"
#include "raytrace/lines/crossings.h"
#include "raytrace/lines/link.h"
#include "raytrace/lines/select.h"
#include "slim/base/check.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>
#include <optional>

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
        case LineKind::convex_crease:
        case LineKind::concave_crease:
            break;
    }
    return reflection_crossings(scene, sheets);
}

/// Pixels that creases pass within 2 pixels of.
std::vector<std::uint8_t> pixels_of(std::span<const FeatureLine> creases, const GBuffer& g) {
    constexpr int kReach = 2;
    std::vector<std::uint8_t> mask(g.n_pixels(), 0);
    for (const FeatureLine& line : creases)
        for (const LinePoint& p : line.points) {
            const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
            const int x0 = std::max(0, x - kReach), x1 = std::min(g.width - 1, x + kReach);
            for (int row = std::max(0, y - kReach); row <= std::min(g.height - 1, y + kReach); ++row)
                for (int column = x0; column <= x1; ++column) mask[g.index(column, row)] = 1;
        }
    return mask;
}

/// Crest lines end where the same edge is drawn as a crease.
void leave_to_creases(const std::vector<std::uint8_t>& creased, LineKind kind, CrossingField& field) {
    if (creased.empty() || (kind != LineKind::ridge && kind != LineKind::valley)) return;
    const auto width = static_cast<std::size_t>(field.width);
    for (Crossing& c : field.crossings)
        if (creased[static_cast<std::size_t>(c.y) * width + static_cast<std::size_t>(c.x)])
            c.evidence = std::numeric_limits<float>::quiet_NaN();
}

std::vector<FeatureLine> lines_of(LineKind kind, const LineScene& scene, const Sheets& sheets,
                                  const std::vector<std::uint8_t>& creased) {
    CrossingField field = crossings_of(kind, scene, sheets);
    leave_to_creases(creased, kind, field);
    std::vector<FeatureLine> lines =
        select_lines(link_crossings(scene, field, kind),
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
    std::optional<Sheets> sheets;
    if (!std::all_of(kinds.begin(), kinds.end(), is_crease)) sheets.emplace(scene);
    std::vector<std::vector<FeatureLine>> of(kinds.size());
    std::vector<FeatureLine> creases;
    for (std::size_t k = 0; k < kinds.size(); ++k) {
        if (!is_crease(kinds[k])) continue;
        of[k] = visible_creases(scene, kinds[k]);
        creases.insert(creases.end(), of[k].begin(), of[k].end());
    }
    std::vector<std::uint8_t> creased;
    if (!creases.empty()) creased = pixels_of(creases, scene.buffer);
    parallel_blocks(kinds.size(), 1, [&](std::size_t k, std::size_t) {
        if (!is_crease(kinds[k])) of[k] = lines_of(kinds[k], scene, *sheets, creased);
    });
    std::vector<FeatureLine> out;
    for (auto& lines : of) std::move(lines.begin(), lines.end(), std::back_inserter(out));
    return out;
}

}  // namespace slim
