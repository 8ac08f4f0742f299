#include "raytrace/lines/one_stroke.h"

#include "raytrace/lines/join.h"
#include "raytrace/lines/line_rests.h"
#include "raytrace/lines/line_runs.h"
#include "raytrace/lines/placed_lines.h"
#include "raytrace/lines/select.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>

namespace slim {
namespace {

constexpr float kFaces = 0.1f;  ///< N.v of a face that is turned to the eye
/// A crease is part of the outline, or is none between such parts, for as long: pixels of a picture
/// 1000 high.
constexpr float kOutline = 6;

/// Which points of a crease are part of the outline: along contours where a face is turned away.
std::vector<std::uint8_t> outline_points(FeatureLine& line, const PlacedLines& contours, float px) {
    std::vector<std::uint8_t> outline = shared_points(line, contours, true, px);
    for (std::size_t i = 0; i < outline.size(); ++i)
        if (line.points[i].facing > kFaces) outline[i] = 0;
    open_at_mark(line, outline);
    const auto is_brief = [&](const Run& run) {
        return length_of(line.points, run) < kOutline * px;
    };
    flip_runs(line, outline, [&](const Run& run, bool mark) {
        return !mark && is_between(line, run) && is_brief(run);
    });
    flip_runs(line, outline, [&](const Run& run, bool mark) { return mark && is_brief(run); });
    return outline;
}

/// The parts of a crease along contours where a face is turned away, as contours, and the others.
void divide_crease(FeatureLine line, const PlacedLines& contours, float px,
                   std::vector<FeatureLine>& outlines, std::vector<FeatureLine>& creases) {
    const std::vector<std::uint8_t> outline = outline_points(line, contours, px);
    const std::vector<Run> runs = runs_of(outline);
    const std::size_t n = outline.size();
    float weight = 0;
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
                if (const LinePoint* at = contours.nearest(p)) weight = at->weight;
                p.weight = weight, p.evidence = 1;
            }
        measure_line(part);
        if (part.points.size() > 1) (is_outline ? outlines : creases).push_back(std::move(part));
    }
}

/// Moves the ends of what is left of contours to those of the parts of creases that they go on as:
/// in space only where that is one place.
void meet_outlines(const std::vector<FeatureLine>& outlines, float px,
                   std::vector<FeatureLine>& rests) {
    PlacedLines ends(px, 2 * outlines.size());
    for (const FeatureLine& line : outlines) ends.add_ends(line);
    for (FeatureLine& rest : rests)
        for (const bool back : {false, true}) {
            const std::size_t i = back ? rest.points.size() - 1 : 0;
            const LinePoint& p = rest.points[i];
            move_end(rest, back, ends.at_one_place(p, course_at(rest, i)), ends.nearest(p), px);
        }
}

bool is_contour(LineKind kind) { return kind == LineKind::contour; }

/// Those of some kinds.
template <class Wanted>
PlacedLines placed(const std::vector<FeatureLine>& lines, float px, const Wanted& wanted) {
    std::size_t n = 0;
    for (const FeatureLine& line : lines) n += wanted(line.kind) ? line.points.size() : 0;
    PlacedLines out(px, n);
    for (const FeatureLine& line : lines)
        if (wanted(line.kind)) out.add(line);
    return out;
}

/// Contours, with the parts of creases that they follow, and the other parts of these.
struct Edges {
    std::vector<FeatureLine> contours, others;
};
Edges outlines_of(std::vector<FeatureLine> lines, float px) {
    const PlacedLines contours = placed(lines, px, is_contour),
                      creases = placed(lines, px, is_crease);
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
    std::erase_if(lines, [](const FeatureLine& line) { return line.points.size() < 2; });
    Edges edges = outlines_of(std::move(lines), px);
    const PlacedLines contours = placed(edges.contours, px, is_contour);
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
