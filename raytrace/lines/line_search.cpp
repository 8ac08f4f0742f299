#include "raytrace/lines/line_search.h"

#include "raytrace/lines/crossings.h"
#include "raytrace/lines/one_stroke.h"
#include "raytrace/lines/parabolic_look.h"
#include "raytrace/lines/select.h"
#include "raytrace/lines/short_lines.h"
#include "raytrace/lines/tidy.h"
#include "slim/base/check.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

namespace slim {
namespace {

/// Passes of smoothing: fewer of small loops, which each makes smaller
/// (8 one of 16 points by 27 %).
int smoothing_passes(const FeatureLine& line) {
    constexpr int kPasses = 8;
    const std::size_t n = line.points.size();
    return line.closed && n < 40 ? static_cast<int>(n * n / 200) : kPasses;
}

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

/// Of two that the bands above and below a row have found, which know a cell each.
void merge(std::array<std::int32_t, 2>& known, const std::array<std::int32_t, 2>& more) {
    for (std::size_t k = 0; k < 2; ++k)
        if (more[k] >= 0) known[k] = more[k];
}

/// Pixels of the picture within 2 pixels of creases, rising.
class CreasedPixels {
public:
    void add(std::span<const FeatureLine> creases) {
        constexpr int kReach = 2;
        for (const FeatureLine& line : creases)
            for (const LinePoint& p : line.points)
                for (int y = static_cast<int>(p.y) - kReach; y <= static_cast<int>(p.y) + kReach;
                     ++y)
                    for (int x = static_cast<int>(p.x) - kReach;
                         x <= static_cast<int>(p.x) + kReach; ++x)
                        numbers_.push_back(number(x, y));
    }
    void sort() {
        std::sort(numbers_.begin(), numbers_.end());
        numbers_.erase(std::unique(numbers_.begin(), numbers_.end()), numbers_.end());
    }
    bool hold(const LinePoint& p) const {
        return std::binary_search(numbers_.begin(), numbers_.end(),
                                  number(static_cast<int>(p.x), static_cast<int>(p.y)));
    }

private:
    static std::int64_t number(int x, int y) { return (static_cast<std::int64_t>(y) << 32) + x; }
    std::vector<std::int64_t> numbers_;
};

}  // namespace

LineSearch::LineSearch(std::span<const LineKind> kinds) : kinds_(kinds.begin(), kinds.end()) {
    for (const LineKind kind : kinds) {
        if (is_crease(kind))
            creases_.emplace_back(kind);
        else
            found_.emplace_back(kind);
    }
}

int line_margin(int picture_width, int picture_height) {
    // The blur of a pixel two rows on (slopes by differences), of the lower end of an edge, in the
    // row after the last.
    return static_cast<int>(blur_reach(picture_width, picture_height)) + 5;
}

void LineSearch::Found::append(const LineScene& scene, const CrossingField& field,
                               const LineLinks& own, bool is_last) {
    // The first row's were found before, with the cells above them.
    SLIM_CHECK(n_next, <=, own.size());
    const std::size_t known = points.size() - n_next;
    const auto moved = [&](std::array<std::int32_t, 2> link) {
        for (std::int32_t& to : link)
            if (to >= 0) to += static_cast<std::int32_t>(known);
        return link;
    };
    for (std::size_t i = 0; i < n_next; ++i) merge(links[known + i], moved(own[i]));
    for (std::size_t i = n_next; i < own.size(); ++i) {
        points.push_back(line_point(field.crossings[i]));
        links.push_back(moved(own[i]));
        if (is_crest())
            looks.push_back(crest_look(scene, field.crossings[i], kind == LineKind::ridge));
    }
    n_next = is_last ? 0 : field.crossings.size() - field.row_start[field.row_start.size() - 2];
}

/// The evidence of crest lines, of the whole picture.
void LineSearch::Found::look_around(const CurvatureSamples& around) {
    parallel_blocks(points.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (!(points[i].evidence > 0))
                points[i].evidence = around.sharpness(points[i], looks[i], kind == LineKind::ridge);
    });
    looks = {};
}

std::vector<FeatureLine> LineSearch::Found::lines(int width, int height, double diagonal,
                                                  const CurvatureSamples& around) {
    if (kind == LineKind::suggestive) {
        const float scale = typical_curvature(std::move(curvatures), diagonal),
                    per_sq = 1 / (scale * scale);
        for (LinePoint& p : points) p.evidence *= per_sq;
    }
    std::vector<FeatureLine> lines = follow_links(points, links, kind);
    points = {}, links = {};
    const float px = line_pixel(width, height);
    const LineRules rules = line_rules(kind, width, height);
    if (kind == LineKind::parabolic) look_across_parabolic(lines, around, diagonal, px);
    if (kind == LineKind::contour) lines = tidy_contours(std::move(lines), px);
    lines = link_short_lines(select_lines(std::move(lines), rules), rules, px);
    for (FeatureLine& line : lines) {
        smooth_line(line, smoothing_passes(line));
        measure_line(line);
    }
    return lines;
}

void LineSearch::add(const LineScene& scene) {
    if (kinds_.empty()) return;
    const int end = scene.rows.top + static_cast<int>(scene.end_row());
    SLIM_CHECK(scene.rows.top + static_cast<int>(scene.first_row()), ==, next_row_);
    width_ = scene.buffer.width, height_ = scene.picture_height(), next_row_ = end,
    diagonal_ = scene.diagonal;
    const bool is_last = end == height_;
    for (CreaseSearch& creases : creases_) creases.add(scene);
    if (found_.empty()) return;
    if (looks_far()) samples_.add(scene);
    const Sheets sheets(scene);
    LineScene with_next = scene;  // cells of the last row take the crossings of the next
    with_next.rows.end = static_cast<int>(scene.end_row()) + (is_last ? 0 : 1);
    parallel_blocks(found_.size(), 1, [&](std::size_t k, std::size_t) {
        Found& found = found_[k];
        SLIM_CHECK(scene.buffer.has(line_channels(std::array{found.kind}, scene.degree)), ==, true);
        const CrossingField field = crossings_of(found.kind, with_next, sheets);
        found.append(scene, field, link_cells(scene, field, found.kind), is_last);
        if (found.kind == LineKind::suggestive) sample_curvature(scene, found.curvatures);
    });
}

bool LineSearch::has_crests() const {
    return std::any_of(found_.begin(), found_.end(), [](const Found& f) { return f.is_crest(); });
}

bool LineSearch::looks_far() const {
    return has_crests() || std::any_of(found_.begin(), found_.end(), [](const Found& f) {
               return f.kind == LineKind::parabolic;
           });
}

/// Crest lines end where the same edge is drawn as a crease.
void LineSearch::leave_to_creases(std::span<const FeatureLine> elsewhere) {
    if (!has_crests()) return;
    CreasedPixels creased;
    creased.add(elsewhere);
    for (const CreaseSearch& search : creases_) creased.add(search.lines());
    creased.sort();
    for (Found& found : found_) {
        if (!found.is_crest()) continue;
        for (LinePoint& p : found.points)
            if (creased.hold(p)) p.evidence = std::numeric_limits<float>::quiet_NaN();
    }
}

std::vector<FeatureLine> LineSearch::finish(std::span<const FeatureLine> creases) {
    SLIM_CHECK(next_row_, ==, height_);
    for (Found& found : found_)
        if (found.is_crest()) found.look_around(samples_);
    leave_to_creases(creases);
    std::vector<std::vector<FeatureLine>> of(found_.size());
    parallel_blocks(found_.size(), 1, [&](std::size_t k, std::size_t) {
        of[k] = found_[k].lines(width_, height_, diagonal_, samples_);
    });
    std::vector<FeatureLine> out;
    std::size_t n_found = 0, n_creases = 0;
    for (const LineKind kind : kinds_) {
        const std::vector<FeatureLine>& lines =
            is_crease(kind) ? creases_[n_creases++].lines() : of[n_found++];
        out.insert(out.end(), lines.begin(), lines.end());
    }
    return one_stroke(std::move(out), line_pixel(width_, height_));
}

}  // namespace slim
