#include "raytrace/lines/crease_choice.h"

#include "raytrace/lines/select.h"

#include <cmath>
#include <limits>
#include <map>

namespace slim {
namespace {

/// Length in the picture as if nothing hid it, picture borders included; mean turn over the edge.
struct EdgeSize {
    double length_px = 0, turn_deg = 0;
};

EdgeSize size_of(const PixelView& view, const SharpEdge& edge) {
    EdgeSize out;
    double length_sum = 0;
    const std::size_t n = edge.points.size();
    for (std::size_t i = 0; i + (edge.closed ? 0 : 1) < n; ++i) {
        const EdgePoint &a = edge.points[i], &b = edge.points[i + 1 == n ? 0 : i + 1];
        const Vec3d ca = view.camera_from_local(a.point), cb = view.camera_from_local(b.point);
        const double step = length(b.point - a.point);
        length_sum += step,
            out.turn_deg += step * 0.5 * static_cast<double>(a.turn_deg() + b.turn_deg());
        if (!view.orthographic && !(ca.z > view.near_plane && cb.z > view.near_plane)) continue;
        const double sa = view.orthographic ? view.px_per_unit : view.focal_px / ca.z;
        const double sb = view.orthographic ? view.px_per_unit : view.focal_px / cb.z;
        out.length_px += std::hypot(sb * cb.x - sa * ca.x, sb * cb.y - sa * ca.y);
    }
    if (length_sum > 0) out.turn_deg /= length_sum;
    return out;
}

}  // namespace

std::vector<std::uint8_t> chosen_edges(const LineScene& s) {
    const LineRules rules = line_rules(LineKind::convex_crease, s.buffer.width, s.picture_height());
    const std::size_t n = s.edges.size();
    std::vector<std::uint8_t> keep(n, 0), weak(n, 0);
    std::multimap<std::uint32_t, std::size_t> at_corner;
    std::vector<std::size_t> fresh;
    for (std::size_t i = 0; i < n; ++i) {
        const EdgeSize size = size_of(s.view, s.edges[i]);
        const bool ends = s.edges[i].closed || s.edges[i].n_leaves > 1;
        weak[i] = size.length_px >= static_cast<double>(rules.weak_px) &&
                  size.turn_deg >= static_cast<double>(rules.weak_strength);
        keep[i] = weak[i] && ends && size.length_px >= static_cast<double>(rules.least_px) &&
                  size.turn_deg >= static_cast<double>(rules.strength);
        if (keep[i]) fresh.push_back(i);
        for (const std::uint32_t corner : s.edges[i].corner)
            if (corner != kNoCorner) at_corner.emplace(corner, i);
    }
    while (!fresh.empty()) {
        const std::size_t kept = fresh.back();
        fresh.pop_back();
        for (const std::uint32_t corner : s.edges[kept].corner) {
            if (corner == kNoCorner) continue;
            const auto [begin, end] = at_corner.equal_range(corner);
            for (auto at = begin; at != end; ++at)
                if (const std::size_t i = at->second; weak[i] && !keep[i])
                    keep[i] = 1, fresh.push_back(i);
        }
    }
    return keep;
}

}  // namespace slim
