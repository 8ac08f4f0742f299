#include "raytrace/lines/line_rests.h"

#include "raytrace/lines/line_runs.h"
#include "raytrace/lines/select.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace slim {
namespace {

// Lengths in pixels of a picture 1000 high.
constexpr float kShared = 6;  ///< lines that meet or cross are beside each other for less
constexpr float kCrumb = 8;   ///< a rest as short, near the other line all along, goes too
constexpr float kLean = 20;   ///< a line nears another one in space over as long

/// Where point i of a line, which is shared, meets the others.
struct Joint {
    const LinePoint *in_space, *in_picture;  ///< see move_end
};
Joint joint(const FeatureLine& line, std::size_t i, const PlacedLines& placed, bool in_space) {
    const LinePoint& p = line.points[i];
    const LinePoint* beside = placed.beside(p, course_at(line, i), in_space);
    return {in_space ? beside : nullptr, beside ? beside : placed.nearest(p)};
}

}  // namespace

std::vector<std::uint8_t> shared_points(FeatureLine& line, const PlacedLines& placed, bool in_space,
                                        float px) {
    std::vector<std::uint8_t> shared;
    for (std::size_t i = 0; i < line.points.size(); ++i)
        shared.push_back(placed.beside(line.points[i], course_at(line, i), in_space) ? 1 : 0);
    open_at_mark(line, shared);
    const auto is_passed = [&](const Run& run) {
        for (std::size_t i = run.begin; i < run.end; ++i)
            if (!placed.passes(line.points[i])) return false;
        return true;
    };
    const auto is_crumb = [&](const Run& run, bool mark) {
        return !mark && length_of(line.points, run) < kCrumb * px && is_passed(run);
    };
    flip_runs(line, shared, [&](const Run& run, bool mark) {
        return is_between(line, run) && is_crumb(run, mark);
    });
    flip_runs(line, shared, [&](const Run& run, bool mark) {
        return mark && length_of(line.points, run) < kShared * px;
    });
    flip_runs(line, shared, is_crumb);
    return shared;
}

void move_end(FeatureLine& line, bool back, const LinePoint* in_space, const LinePoint* in_picture,
              float px) {
    std::vector<LinePoint>& points = line.points;
    const std::size_t n = points.size();
    const auto at = [&](std::size_t k) -> LinePoint& { return points[back ? n - 1 - k : k]; };
    if (in_space) {
        const Vec3f gap = in_space->point - at(0).point;
        const float reach = std::min(kLean * px, length_of(points, {0, n}));
        float gone = 0;
        for (std::size_t k = 0; k < n && (k == 0 || gone < reach); ++k) {
            const LinePoint& p = at(k);
            at(k).point = p.point + gap * (k == 0 ? 1 : 1 - gone / reach);
            if (k + 1 < n) gone += std::hypot(at(k + 1).x - p.x, at(k + 1).y - p.y);
        }
    }
    if (const LinePoint* to = in_space ? in_space : in_picture) at(0).x = to->x, at(0).y = to->y;
}

bool add_rests(FeatureLine line, const PlacedLines& placed, bool in_space, float px,
               std::vector<FeatureLine>& out) {
    const std::vector<std::uint8_t> shared = shared_points(line, placed, in_space, px);
    const std::vector<Run> runs = runs_of(shared);
    if (runs.size() == 1 && !shared[0]) {
        out.push_back(std::move(line));
        return false;
    }
    const std::size_t n = shared.size();
    for (const Run& run : runs) {
        if (shared[run.begin]) continue;
        const bool begins = run.begin > 0, ends = run.end < n || line.closed;
        const std::size_t from = run.begin - (begins ? 1 : 0), next = run.end < n ? run.end : 0;
        FeatureLine rest;
        rest.kind = line.kind;
        rest.points.assign(line.points.begin() + static_cast<std::ptrdiff_t>(from),
                           line.points.begin() + static_cast<std::ptrdiff_t>(run.end));
        if (ends) rest.points.push_back(line.points[next]);
        if (rest.points.size() < 2) continue;
        if (begins) {
            const Joint at = joint(line, from, placed, in_space);
            move_end(rest, false, at.in_space, at.in_picture, px);
        }
        if (ends) {
            const Joint at = joint(line, next, placed, in_space);
            move_end(rest, true, at.in_space, at.in_picture, px);
        }
        measure_line(rest);
        out.push_back(std::move(rest));
    }
    return true;
}

}  // namespace slim
