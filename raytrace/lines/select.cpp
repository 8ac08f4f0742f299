#include "raytrace/lines/select.h"

#include "raytrace/lines/point_grid.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace slim {
namespace {

/// Pieces of a line between crossings of too little evidence.
void cut_line(FeatureLine line, float least, std::vector<FeatureLine>& out) {
    const auto poor = [&](const LinePoint& p) { return !(p.evidence >= least); };
    const auto first = std::find_if(line.points.begin(), line.points.end(), poor);
    if (first == line.points.end()) {
        out.push_back(std::move(line));
        return;
    }
    // A loop is opened at its first poor point, so that no piece is cut in two at its seam.
    if (line.closed) std::rotate(line.points.begin(), first, line.points.end());
    FeatureLine piece;
    piece.kind = line.kind;
    const auto finish = [&] {
        if (piece.points.size() > 1) out.push_back(piece);
        piece.points.clear();
    };
    for (const LinePoint& p : line.points) {
        if (poor(p))
            finish();
        else
            piece.points.push_back(p);
    }
    finish();
}

float mean_evidence(const FeatureLine& line) {
    float sum = 0, px = 0;
    line.for_each_segment([&](const LinePoint& a, const LinePoint& b) {
        const float step = std::hypot(b.x - a.x, b.y - a.y);
        sum += step * 0.5f * (a.evidence + b.evidence), px += step;
    });
    return px > 0 ? sum / px : 0;
}

enum class Verdict : std::uint8_t { drop, weak, keep };

Verdict judge(const FeatureLine& line, const LineRules& rules) {
    if (line.length_px < rules.weak_px || line.strength < rules.weak_strength) return Verdict::drop;
    const bool strong = line.strength >= rules.strength && line.length_px >= rules.least_px;
    const float evidence = mean_evidence(line);
    const bool clear =
        evidence >= rules.strong_evidence && line.strength * evidence >= rules.sharpness;
    return strong && clear ? Verdict::keep : Verdict::weak;
}

/// Weak lines that continue kept ones, and those that continue these, become kept.
void spread(const std::vector<FeatureLine>& lines, const LineRules& rules,
            std::vector<Verdict>& verdicts) {
    constexpr float kReach = 3;
    constexpr std::uint8_t kBothEnds = 3;
    PointGrid weak(kReach, 2 * lines.size());
    std::vector<std::size_t> fresh;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (lines[i].closed && !rules.meets_anywhere) continue;
        if (verdicts[i] == Verdict::keep) fresh.push_back(i);
        if (verdicts[i] != Verdict::weak || lines[i].closed) continue;
        const LinePoint &first = lines[i].points.front(), &last = lines[i].points.back();
        weak.add(first.x, first.y, static_cast<std::uint32_t>(2 * i));
        weak.add(last.x, last.y, static_cast<std::uint32_t>(2 * i + 1));
    }
    std::vector<std::uint8_t> met(lines.size(), 0);
    while (!fresh.empty()) {
        const FeatureLine& kept = lines[fresh.back()];
        fresh.pop_back();
        const auto look = [&](const LinePoint& p) {
            weak.for_each(p.x, p.y, [&](std::uint32_t end, float) {
                const std::size_t i = end / 2;
                met[i] |= static_cast<std::uint8_t>(1u << end % 2);
                if (verdicts[i] != Verdict::weak || (rules.meets_anywhere && met[i] != kBothEnds))
                    return;
                verdicts[i] = Verdict::keep;
                fresh.push_back(i);
            });
        };
        if (rules.meets_anywhere)
            for (const LinePoint& p : kept.points) look(p);
        else
            look(kept.points.front()), look(kept.points.back());
    }
}

}  // namespace

float line_pixel(int picture_width, int picture_height) {
    return std::max(1.0f, static_cast<float>(std::min(picture_width, picture_height)) / 1000);
}

LineRules line_rules(LineKind kind, int picture_width, int picture_height) {
    const float scale = static_cast<float>(std::min(picture_width, picture_height)) / 1000;
    const auto px = [&](float at_1000) { return std::max(4.0f, at_1000 * scale); };
    switch (kind) {
        // Junctions with other contours cut a limb into pieces, some of a few pixels, which meet
        // these contours midway.
        case LineKind::contour:
            return {0, 0, 0, 0, px(10), 0, true};
        case LineKind::suggestive:
            return {.least_evidence = 0.1f,
                    .strong_evidence = 0.5f,
                    .strength = 1.2f,
                    .weak_strength = 0.5f,
                    .least_px = px(16),
                    .loop_px = px(64),  // about 20 across
                    .loop_strength = 6};
        case LineKind::ridge:
        case LineKind::valley:
            return {.strong_evidence = 0.3f,
                    .strength = 1.2f,
                    .weak_strength = 0.45f,
                    .least_px = px(12),
                    .sharpness = 1};
        case LineKind::parabolic:
            return {0.3f, 0.6f, 2, 0.8f, px(16)};
        case LineKind::reflection:
            return {0, 0, 0, 0, px(8)};
        // Strength is the angle by which the normal turns, degrees;
        // lengths are those of whole edges.
        case LineKind::convex_crease:
        case LineKind::concave_crease:
            return {0, 0, 30, 15, px(20), 1};
    }
    return {};
}

void measure_line(FeatureLine& line) {
    line.length = line.length_px = line.strength = 0;
    float turn = 0;
    line.for_each_segment([&](const LinePoint& a, const LinePoint& b) {
        const float step = slim::length(b.point - a.point), px = std::hypot(b.x - a.x, b.y - a.y);
        line.length += step, line.length_px += px;
        line.strength += step * 0.5f * (a.weight + b.weight);
        turn += px * 0.5f * (a.evidence + b.evidence);
    });
    if (is_crease(line.kind)) line.strength = line.length_px > 0 ? turn / line.length_px : 0;
}

std::vector<FeatureLine> select_lines(std::vector<FeatureLine> lines, const LineRules& rules) {
    std::vector<FeatureLine> pieces;
    for (FeatureLine& line : lines) cut_line(std::move(line), rules.least_evidence, pieces);
    std::vector<Verdict> verdicts;
    for (FeatureLine& piece : pieces) {
        measure_line(piece);
        verdicts.push_back(judge(piece, rules));
    }
    spread(pieces, rules, verdicts);
    std::vector<FeatureLine> kept;
    for (std::size_t i = 0; i < pieces.size(); ++i)
        if (verdicts[i] == Verdict::keep) kept.push_back(std::move(pieces[i]));
    return kept;
}

void smooth_line(FeatureLine& line, int passes) {
    const std::size_t n = line.points.size();
    if (n < 3) return;
    for (int pass = 0; pass < passes; ++pass) {
        const std::vector<LinePoint> old = line.points;
        for (std::size_t i = 0; i < n; ++i) {
            if (!line.closed && (i == 0 || i + 1 == n)) continue;
            const LinePoint &a = old[(i + n - 1) % n], &b = old[(i + 1) % n];
            LinePoint& p = line.points[i];
            p.x = 0.5f * p.x + 0.25f * (a.x + b.x);
            p.y = 0.5f * p.y + 0.25f * (a.y + b.y);
            p.point = p.point * 0.5f + (a.point + b.point) * 0.25f;
        }
    }
}

}  // namespace slim
