#include "raytrace/lines/link.h"

#include <algorithm>
#include <array>
#include <limits>

namespace slim {
namespace {

constexpr std::int32_t kNobody = -1;
constexpr float kNever = std::numeric_limits<float>::infinity();

/// The two neighbours of every crossing on its line.
using Links = std::vector<std::array<std::int32_t, 2>>;

void link(Links& links, std::int32_t a, std::int32_t b) {
    for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, a}}) {
        auto& own = links[static_cast<std::size_t>(from)];
        own[own[0] == kNobody ? 0 : 1] = to;
    }
}

/// What it costs to link two crossings of a cell: their squared distance; never across sheets.
/// Along a limb, where neighbours lie far off each other's tangent planes on one sheet too, only a
/// gap that no limb has counts as another sheet.
float link_cost(const LineScene& scene, LineKind kind, const Crossing& a, const Crossing& b) {
    constexpr float kLimbGap = 16;  // footprints
    const float sq = (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y);
    if (a.pixel == b.pixel || !breaks_off(scene, a.pixel, b.pixel)) return sq;
    const float most = kLimbGap * scene.footprint(a.pixel);
    if (kind != LineKind::contour || sq_length(a.point - b.point) > most * most) return kNever;
    return sq + 4;  // after any pair that is surely on one sheet
}

/// The crossings of one cell: top, left, right, bottom.
struct CellCrossings {
    std::array<std::int32_t, 4> id{};
    std::size_t n = 0;
    void add(std::int32_t crossing) {
        if (crossing != kNobody) id[n++] = crossing;
    }
};

class Linker {
public:
    Linker(const LineScene& scene, const CrossingField& field, LineKind kind)
        : scene_(scene),
          field_(field),
          kind_(kind),
          links_(field.crossings.size(), {kNobody, kNobody}) {}

    Links run() {
        const auto width = static_cast<std::size_t>(field_.width);
        for (std::size_t y = 0; y + 1 < static_cast<std::size_t>(field_.height); ++y)
            for (std::size_t x = 0; x + 1 < width; ++x) {
                const std::size_t i = y * width + x;
                CellCrossings cell;
                cell.add(field_.right[i]), cell.add(field_.down[i]);
                cell.add(field_.down[i + 1]), cell.add(field_.right[i + width]);
                if (cell.n >= 2) link_cell(cell);
            }
        return std::move(links_);
    }

private:
    float cost(const CellCrossings& c, std::size_t a, std::size_t b) const {
        return link_cost(scene_, kind_, field_.crossings[static_cast<std::size_t>(c.id[a])],
                         field_.crossings[static_cast<std::size_t>(c.id[b])]);
    }

    /// The cheapest pair, and of four the other two as well if they may be linked; the choice is by
    /// the sum where both pairs can be.
    void link_cell(const CellCrossings& c) {
        if (c.n == 4) return link_four(c);
        float best = kNever;
        std::size_t best_a = 0, best_b = 0;
        for (std::size_t a = 0; a < c.n; ++a)
            for (std::size_t b = a + 1; b < c.n; ++b)
                if (const float now = cost(c, a, b); now < best) best = now, best_a = a, best_b = b;
        if (best < kNever) link(links_, c.id[best_a], c.id[best_b]);
    }

    void link_four(const CellCrossings& c) {
        constexpr std::size_t kPairs[3][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2}};
        constexpr float kUnlinked = 100;  // of a pair: more than any distance within a cell
        std::size_t best = 0;
        float least = kNever;
        for (std::size_t p = 0; p < 3; ++p) {
            const float sum = std::min(cost(c, kPairs[p][0], kPairs[p][1]), kUnlinked) +
                              std::min(cost(c, kPairs[p][2], kPairs[p][3]), kUnlinked);
            if (sum < least) least = sum, best = p;
        }
        for (const std::size_t first : {0u, 2u}) {
            const std::size_t a = kPairs[best][first], b = kPairs[best][first + 1];
            if (cost(c, a, b) < kNever) link(links_, c.id[a], c.id[b]);
        }
    }

    const LineScene& scene_;
    const CrossingField& field_;
    LineKind kind_;
    Links links_;
};

LinePoint line_point(const Crossing& c) { return {c.x, c.y, c.point, c.weight, c.evidence}; }

/// Follows the links from a crossing on; marks what it passes.
FeatureLine follow(const CrossingField& field, const Links& links, std::int32_t start,
                   LineKind kind, std::vector<std::uint8_t>& used) {
    FeatureLine line;
    line.kind = kind;
    for (std::int32_t at = start; at != kNobody;) {
        const auto i = static_cast<std::size_t>(at);
        used[i] = 1;
        line.points.push_back(line_point(field.crossings[i]));
        at = kNobody;
        for (const std::int32_t next : links[i])
            if (next != kNobody && !used[static_cast<std::size_t>(next)] && at == kNobody)
                at = next;
    }
    return line;
}

}  // namespace

std::vector<FeatureLine> link_crossings(const LineScene& scene, const CrossingField& field,
                                        LineKind kind) {
    const Links links = Linker(scene, field, kind).run();
    std::vector<std::uint8_t> used(links.size(), 0);
    std::vector<FeatureLine> lines;
    // Open lines from their ends, then what is left: loops.
    for (const bool open : {true, false})
        for (std::size_t i = 0; i < links.size(); ++i) {
            if (used[i] || (open && links[i][1] != kNobody)) continue;
            FeatureLine line = follow(field, links, static_cast<std::int32_t>(i), kind, used);
            line.closed = !open && line.points.size() > 2;
            if (line.points.size() > 1) lines.push_back(std::move(line));
        }
    return lines;
}

}  // namespace slim
