#include "raytrace/lines/one_stroke.h"

#include "raytrace/lines/join.h"
#include "raytrace/lines/line_runs.h"
#include "raytrace/lines/point_grid.h"
#include "raytrace/lines/select.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>

namespace slim {
namespace {

// Lengths in pixels of a picture 1000 high.
constexpr float kBeside = 2.5f;    ///< between strokes that are one
constexpr float kAlong = 1;        ///< beyond an end of a line nothing is beside it
constexpr float kShared = 6;       ///< lines that meet or cross are beside each other for less
constexpr float kMeet = 1.5f;     ///< between ends of lines that go on as each other
constexpr float kCrumb = 8;        ///< a rest as short, near the other line all along, goes too
constexpr float kParallel = 0.87f; ///< cosine between directions
constexpr float kFaces = 0.1f;     ///< N.v of a face that is turned to the eye
constexpr float kDepth = 8;        ///< of lines at one place: their gap in space over that seen
constexpr std::size_t kReach = 3;  ///< points to either side that tell the direction

using Direction = std::array<float, 2>;

/// The neighbour of point i so many points on, at an end the last one.
std::size_t moved(const FeatureLine& line, std::size_t i, std::ptrdiff_t by) {
    const auto n = static_cast<std::ptrdiff_t>(line.points.size());
    const std::ptrdiff_t to = static_cast<std::ptrdiff_t>(i) + by;
    return static_cast<std::size_t>(line.closed ? ((to % n) + n) % n
                                                : std::clamp<std::ptrdiff_t>(to, 0, n - 1));
}

/// Unit direction of a line at a point; 0 where it has none.
Direction direction_at(const FeatureLine& line, std::size_t i) {
    const LinePoint &a = line.points[moved(line, i, -static_cast<std::ptrdiff_t>(kReach))],
                    &b = line.points[moved(line, i, kReach)];
    const float dx = b.x - a.x, dy = b.y - a.y, px = std::hypot(dx, dy);
    return px > 0 ? Direction{dx / px, dy / px} : Direction{0, 0};
}

/// Length in space over that in the picture of the steps about a point.
float unit_per_px_at(const FeatureLine& line, std::size_t i) {
    const LinePoint &a = line.points[moved(line, i, -static_cast<std::ptrdiff_t>(kReach))],
                    &b = line.points[moved(line, i, kReach)];
    const float px = std::hypot(b.x - a.x, b.y - a.y);
    return px > 0 ? length(b.point - a.point) / px : 0;
}

/// The lines beside which others are looked for.
class Placed {
public:
    explicit Placed(float px) : px_(px), grid_(kBeside * px, 1024) {}

    void add(const FeatureLine& line) {
        ++n_lines_;
        for (std::size_t i = 0; i < line.points.size(); ++i) {
            grid_.add(line.points[i].x, line.points[i].y,
                      static_cast<std::uint32_t>(places_.size()));
            const bool is_end = !line.closed && (i == 0 || i + 1 == line.points.size());
            places_.push_back(
                {line.points[i], direction_at(line, i), unit_per_px_at(line, i), n_lines_, is_end});
        }
    }

    /// The nearest place beside point i of a line, at the same place in space if that is asked;
    /// null if there is none.
    const LinePoint* beside(const FeatureLine& line, std::size_t i, bool in_space) const {
        const LinePoint& p = line.points[i];
        const Direction d = direction_at(line, i);
        const float unit = unit_per_px_at(line, i);
        const auto is_beside = [&](const Place& at, float sq) {
            const float dx = p.x - at.p.x, dy = p.y - at.p.y;
            const float most = kDepth * std::max(std::sqrt(sq), px_) * std::max(unit, at.unit);
            return std::fabs(d[0] * at.d[0] + d[1] * at.d[1]) > kParallel &&
                   std::fabs(dx * at.d[0] + dy * at.d[1]) <= kAlong * px_ &&
                   (!in_space || length(p.point - at.p.point) <= most);
        };
        return point_of(nearest_place(p, is_beside));
    }
    /// The nearest point within reach, whatever its direction; null if there is none.
    const LinePoint* nearest(const LinePoint& p) const {
        return point_of(nearest_place(p, [](const Place&, float) { return true; }));
    }
    /// Whether a line passes p within reach, or turns into another one at a corner there, rather
    /// than ends.
    bool passes(const LinePoint& p) const {
        const Place* at = nearest_place(p, [](const Place&, float) { return true; });
        if (!at || !at->is_end) return at != nullptr;
        const float sq_meet = kMeet * kMeet * px_ * px_;
        return nearest_place(at->p, [&](const Place& other, float sq) {
                   return other.line != at->line && sq <= sq_meet;
               }) != nullptr;
    }

private:
    struct Place {
        LinePoint p;
        Direction d;
        float unit;
        std::uint32_t line;  ///< numbers from 1
        bool is_end;
    };
    template <class Wanted>
    const Place* nearest_place(const LinePoint& p, const Wanted& wanted) const {
        const Place* best = nullptr;
        float least = std::numeric_limits<float>::infinity();
        grid_.for_each(p.x, p.y, [&](std::uint32_t k, float sq) {
            if (sq < least && wanted(places_[k], sq)) least = sq, best = &places_[k];
        });
        return best;
    }
    static const LinePoint* point_of(const Place* at) { return at ? &at->p : nullptr; }

    float px_;
    PointGrid grid_;
    std::vector<Place> places_;
    std::uint32_t n_lines_ = 0;
};

/// Unmarks or marks the runs that `wanted` picks.
template <class Wanted>
void flip_runs(std::vector<std::uint8_t>& marked, const Wanted& wanted) {
    const std::vector<Run> runs = runs_of(marked);
    for (const Run& run : runs)
        if (runs.size() > 1 && wanted(run, marked[run.begin] != 0))
            std::fill(marked.begin() + static_cast<std::ptrdiff_t>(run.begin),
                      marked.begin() + static_cast<std::ptrdiff_t>(run.end),
                      marked[run.begin] ? std::uint8_t{0} : std::uint8_t{1});
}

/// Which points of a line have others beside them, crumbs between and beyond them included.
/// A closed line is cut open where that begins.
std::vector<std::uint8_t> shared_points(FeatureLine& line, const Placed& placed, bool in_space,
                                        float px) {
    std::vector<std::uint8_t> shared;
    for (std::size_t i = 0; i < line.points.size(); ++i)
        shared.push_back(placed.beside(line, i, in_space) ? 1 : 0);
    open_at_mark(line, shared);
    const auto is_passed = [&](const Run& run) {
        for (std::size_t i = run.begin; i < run.end; ++i)
            if (!placed.passes(line.points[i])) return false;
        return true;
    };
    const auto is_crumb = [&](const Run& run, bool mark) {
        return !mark && length_of(line.points, run) < kCrumb * px && is_passed(run);
    };
    flip_runs(shared, [&](const Run& run, bool mark) {
        return run.begin > 0 && run.end < shared.size() && is_crumb(run, mark);
    });
    flip_runs(shared, [&](const Run& run, bool mark) {
        return mark && length_of(line.points, run) < kShared * px;
    });
    flip_runs(shared, is_crumb);
    return shared;
}

/// The point of the other line at which a rest begins.
LinePoint joint(const LinePoint& own, const Placed& placed) {
    const LinePoint* at = placed.nearest(own);
    LinePoint p = own;
    if (at) p.x = at->x, p.y = at->y, p.point = at->point;
    return p;
}

/// What is left of a line beside those that are placed; returns whether that is less than all.
bool add_rests(FeatureLine line, const Placed& placed, bool in_space, float px,
               std::vector<FeatureLine>& out) {
    const bool closed = line.closed;
    const std::vector<std::uint8_t> shared = shared_points(line, placed, in_space, px);
    const std::vector<Run> runs = runs_of(shared);
    if (runs.size() == 1 && !shared[0]) {
        out.push_back(std::move(line));
        return false;
    }
    const std::size_t n = shared.size();
    for (const Run& run : runs) {
        if (shared[run.begin]) continue;
        FeatureLine rest;
        rest.kind = line.kind;
        if (run.begin > 0) rest.points.push_back(joint(line.points[run.begin - 1], placed));
        rest.points.insert(rest.points.end(),
                           line.points.begin() + static_cast<std::ptrdiff_t>(run.begin),
                           line.points.begin() + static_cast<std::ptrdiff_t>(run.end));
        if (run.end < n || closed)
            rest.points.push_back(joint(line.points[run.end < n ? run.end : 0], placed));
        measure_line(rest);
        if (rest.points.size() > 1) out.push_back(std::move(rest));
    }
    return true;
}

/// The parts of a crease along contours where a face is turned away, as contours, and the others.
void divide_crease(FeatureLine line, const Placed& contours, float px,
                   std::vector<FeatureLine>& outlines, std::vector<FeatureLine>& creases) {
    std::vector<std::uint8_t> outline = shared_points(line, contours, true, px);
    for (std::size_t i = 0; i < outline.size(); ++i)
        if (line.points[i].facing > kFaces) outline[i] = 0;
    flip_runs(outline, [&](const Run& run, bool mark) {
        return mark && length_of(line.points, run) < kShared * px;
    });
    const std::vector<Run> runs = runs_of(outline);
    const std::size_t n = outline.size();
    for (const Run& run : runs) {
        const bool is_outline = outline[run.begin] != 0;
        FeatureLine part;
        part.kind = is_outline ? LineKind::contour : line.kind;
        part.closed = line.closed && runs.size() == 1;
        // Each run goes on to the first point of the next.
        part.points.assign(line.points.begin() + static_cast<std::ptrdiff_t>(run.begin),
                           line.points.begin() +
                               static_cast<std::ptrdiff_t>(std::min(run.end + 1, n)));
        if (run.end == n && line.closed && !part.closed) part.points.push_back(line.points[0]);
        if (is_outline)
            for (LinePoint& p : part.points) {
                const LinePoint* at = contours.nearest(p);
                p.weight = at ? at->weight : 0, p.evidence = 1;
            }
        measure_line(part);
        if (part.points.size() > 1) (is_outline ? outlines : creases).push_back(std::move(part));
    }
}

/// Moves the ends of what is left of contours to those of the parts of creases that they go on as.
void meet_outlines(const std::vector<FeatureLine>& outlines, float px,
                   std::vector<FeatureLine>& rests) {
    PointGrid grid(kBeside * px, 2 * outlines.size());
    std::vector<const LinePoint*> ends;
    for (const FeatureLine& line : outlines)
        for (const LinePoint* end : {&line.points.front(), &line.points.back()}) {
            if (line.closed) continue;
            grid.add(end->x, end->y, static_cast<std::uint32_t>(ends.size()));
            ends.push_back(end);
        }
    for (FeatureLine& rest : rests)
        for (LinePoint* p : {&rest.points.front(), &rest.points.back()}) {
            const LinePoint* best = nullptr;
            float least = std::numeric_limits<float>::infinity();
            grid.for_each(p->x, p->y, [&](std::uint32_t k, float sq) {
                if (sq < least) least = sq, best = ends[k];
            });
            if (best) p->x = best->x, p->y = best->y, p->point = best->point;
        }
}

/// Contours, with the parts of creases that they follow, and the other parts of these.
struct Edges {
    std::vector<FeatureLine> contours, others;
};
Edges outlines_of(std::vector<FeatureLine> lines, float px) {
    Placed contours(px), creases(px);
    for (const FeatureLine& line : lines)
        if (line.kind == LineKind::contour)
            contours.add(line);
        else if (is_crease(line.kind))
            creases.add(line);
    Edges out;
    std::vector<FeatureLine> parts, rests;
    for (FeatureLine& line : lines) {
        if (is_crease(line.kind)) {
            divide_crease(std::move(line), contours, px, parts, out.others);
        } else if (line.kind == LineKind::contour) {
            std::vector<FeatureLine> left;
            const bool is_cut = add_rests(std::move(line), creases, true, px, left);
            auto& to = is_cut ? rests : out.contours;
            std::move(left.begin(), left.end(), std::back_inserter(to));
        } else {
            out.others.push_back(std::move(line));
        }
    }
    meet_outlines(parts, px, rests);
    std::move(rests.begin(), rests.end(), std::back_inserter(parts));
    for (FeatureLine& line : join_ends(std::move(parts), px)) {
        measure_line(line);
        out.contours.push_back(std::move(line));
    }
    return out;
}

bool yields_to_contours(LineKind kind) {
    return is_crease(kind) || kind == LineKind::ridge || kind == LineKind::valley ||
           kind == LineKind::suggestive;
}

}  // namespace

std::vector<FeatureLine> one_stroke(std::vector<FeatureLine> lines, float px) {
    std::vector<LineKind> order;
    for (const FeatureLine& line : lines)
        if (order.empty() || order.back() != line.kind) order.push_back(line.kind);
    if (std::find(order.begin(), order.end(), LineKind::contour) == order.end()) return lines;
    Edges edges = outlines_of(std::move(lines), px);
    Placed contours(px);
    for (const FeatureLine& line : edges.contours) contours.add(line);
    std::vector<FeatureLine> out;
    for (FeatureLine& line : edges.others)
        if (yields_to_contours(line.kind))
            add_rests(std::move(line), contours, false, px, out);
        else
            out.push_back(std::move(line));
    std::move(edges.contours.begin(), edges.contours.end(), std::back_inserter(out));
    const auto rank = [&](const FeatureLine& line) {
        return std::find(order.begin(), order.end(), line.kind);
    };
    std::stable_sort(out.begin(), out.end(), [&](const FeatureLine& a, const FeatureLine& b) {
        return rank(a) < rank(b);
    });
    return out;
}

}  // namespace slim
