#include "raytrace/lines/join.h"

#include "raytrace/lines/point_grid.h"
#include "raytrace/lines/select.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

namespace slim {
namespace {

constexpr float kMeet = 6;       ///< pixels between ends that are joined
constexpr float kTouch = 1.5f;   ///< pixels: ends so near are joined round corners too
constexpr float kTouchShort = 3; ///< the same of short lines
constexpr float kOnward = 0.5f;  ///< cosine between the directions of two ends, and of the gap
constexpr float kSteepest = 16;  ///< depth of a gap over its width
constexpr std::size_t kEnd = 6;  ///< points that tell the direction of an end

float step_px(const LinePoint& a, const LinePoint& b) { return std::hypot(b.x - a.x, b.y - a.y); }

/// End k of line i has the number 2 i + k; k is 0 at its first point.
struct End {
    const LinePoint* at;
    std::array<float, 2> outwards;  ///< unit
    float unit_per_px;
    float length_px;  ///< of the line
};

End end_of(const FeatureLine& line, std::size_t k) {
    const std::size_t n = line.points.size(), in = std::min(kEnd, n - 1);
    const LinePoint &at = line.points[k == 0 ? 0 : n - 1],
                    &from = line.points[k == 0 ? in : n - 1 - in];
    const float px = step_px(from, at), scale = px > 0 ? 1 / px : 0;
    return {&at, {(at.x - from.x) * scale, (at.y - from.y) * scale},
            line.length_px > 0 ? line.length / line.length_px : 0, line.length_px};
}

/// What it costs to join two ends; infinity where they do not belong together.
float join_cost(const End& a, const End& b, float px, float short_px) {
    const float dx = b.at->x - a.at->x, dy = b.at->y - a.at->y, gap = std::hypot(dx, dy);
    const float deep = length(b.at->point - a.at->point);
    if (deep > kSteepest * std::max(gap, px) * std::max(a.unit_per_px, b.unit_per_px))
        return INFINITY;
    const float onward = -(a.outwards[0] * b.outwards[0] + a.outwards[1] * b.outwards[1]);
    const bool brief = std::min(a.length_px, b.length_px) < short_px;
    if (gap <= (brief ? kTouchShort : kTouch) * px)
        return onward > -kOnward ? gap + px * (1 - onward) : INFINITY;
    const float along = std::min(a.outwards[0] * dx + a.outwards[1] * dy,
                                 -b.outwards[0] * dx - b.outwards[1] * dy) /
                        gap;
    return onward > kOnward && along > kOnward ? gap + px * (2 - onward - along) : INFINITY;
}

constexpr std::uint32_t kNoEnd = UINT32_MAX;

/// The other end that each is joined to: cheapest pairs first.
std::vector<std::uint32_t> partners_of(std::span<const FeatureLine> lines, float px,
                                       float short_px) {
    std::vector<End> ends;
    PointGrid grid(kMeet * px, 2 * lines.size());
    for (std::size_t e = 0; e < 2 * lines.size(); ++e) {
        ends.push_back(end_of(lines[e / 2], e % 2));
        if (!lines[e / 2].closed)
            grid.add(ends[e].at->x, ends[e].at->y, static_cast<std::uint32_t>(e));
    }
    std::vector<std::pair<float, std::array<std::uint32_t, 2>>> pairs;
    for (std::uint32_t e = 0; e < ends.size(); ++e) {
        if (lines[e / 2].closed) continue;
        grid.for_each(ends[e].at->x, ends[e].at->y, [&](std::uint32_t other, float) {
            const bool own = other / 2 == e / 2;
            if (other <= e || (own && lines[e / 2].length_px < 4 * kMeet * px)) return;
            if (const float cost = join_cost(ends[e], ends[other], px, short_px);
                cost < INFINITY)
                pairs.push_back({cost, {e, other}});
        });
    }
    std::sort(pairs.begin(), pairs.end());
    std::vector<std::uint32_t> partner(ends.size(), kNoEnd);
    for (const auto& [cost, pair] : pairs)
        if (partner[pair[0]] == kNoEnd && partner[pair[1]] == kNoEnd)
            partner[pair[0]] = pair[1], partner[pair[1]] = pair[0];
    return partner;
}

/// The line that begins with end `first` and goes on over joined ends.
FeatureLine chain_from(std::span<const FeatureLine> lines, std::span<const std::uint32_t> partner,
                       std::uint32_t first, std::vector<std::uint8_t>& used) {
    FeatureLine out;
    out.kind = lines[first / 2].kind, out.closed = lines[first / 2].closed;
    for (std::uint32_t at = first; at != kNoEnd;) {
        if (used[at / 2]) {
            out.closed = true;
            break;
        }
        used[at / 2] = 1;
        const std::vector<LinePoint>& points = lines[at / 2].points;
        if (at % 2 == 0)
            out.points.insert(out.points.end(), points.begin(), points.end());
        else
            out.points.insert(out.points.end(), points.rbegin(), points.rend());
        at = partner[at ^ 1u];
    }
    return out;
}

}  // namespace

std::vector<FeatureLine> join_ends(std::vector<FeatureLine> lines, float px, float short_px) {
    for (FeatureLine& line : lines) measure_line(line);
    const std::vector<std::uint32_t> partner = partners_of(lines, px, short_px);
    std::vector<std::uint8_t> used(lines.size(), 0);
    std::vector<FeatureLine> out;
    // Open chains from their ends, then what is left: loops.
    for (const bool open : {true, false})
        for (std::uint32_t e = 0; e < partner.size(); ++e)
            if (!used[e / 2] && (!open || partner[e] == kNoEnd))
                out.push_back(chain_from(lines, partner, e, used));
    return out;
}

}  // namespace slim
