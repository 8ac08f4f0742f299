#include "raytrace/lines/link.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <utility>

namespace slim {
namespace {

constexpr std::int32_t kNobody = -1;
constexpr float kNever = std::numeric_limits<float>::infinity();

/// Whether beyond a crossing there is nothing: it lies on the border of what is covered.
bool faces_nothing(const LineScene& scene, const Crossing& c) {
    const auto width = static_cast<std::uint32_t>(scene.buffer.width);
    const std::uint32_t row = static_cast<std::uint32_t>(c.y - 0.5f) -
                              static_cast<std::uint32_t>(scene.rows.top);
    const bool down = c.edge & 1;
    const std::uint32_t a = row * width + c.edge / 2, b = a + (down ? width : 1);
    return !scene.hit(c.pixel == a ? b : a);
}

/// What it costs to link two crossings of a cell: their squared distance; never across sheets. The
/// border of what is covered comes first, so that no flap that a surfel makes beside it takes a
/// part of it for a loop of its own.
/// Along a limb, where neighbours lie far off each other's tangent planes on one sheet too, only a
/// gap that no limb has counts as another sheet: the last pixel of one that bends by a radius of r
/// footprints lies up to sqrt(2 r) before the limb, and has about its normal.
float link_cost(const LineScene& scene, LineKind kind, const Crossing& a, const Crossing& b) {
    constexpr float kLimbGap = 16, kWideLimbGap = 64;  // footprints
    constexpr float kLimbTurn = 0.9f;
    const float sq = (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y);
    const bool is_border =
        kind == LineKind::contour && faces_nothing(scene, a) && faces_nothing(scene, b);
    const float rank = is_border ? -4.0f : 0.0f;  // before any other pair
    if (a.pixel == b.pixel || !breaks_off(scene, a.pixel, b.pixel)) return sq + rank;
    const bool alike = dot(scene.normal(a.pixel), scene.normal(b.pixel)) > kLimbTurn;
    const float most = (alike ? kWideLimbGap : kLimbGap) * scene.footprint(a.pixel);
    if (kind != LineKind::contour || sq_length(a.point - b.point) > most * most) return kNever;
    return is_border ? sq + rank : sq + 4;  // after any pair that is surely on one sheet
}

/// The crossings of one cell: top, left, right, bottom;
/// of the upper two this cell is the second one.
struct CellCrossings {
    std::array<std::int32_t, 4> id{};
    std::array<std::uint8_t, 4> slot{};
    std::size_t n = 0;
    void add(std::int32_t crossing, std::uint8_t own_slot) {
        if (crossing != kNobody) id[n] = crossing, slot[n] = own_slot, ++n;
    }
};

/// The crossings of a row's edges by column, and which of its cells have any.
class RowIndex {
public:
    explicit RowIndex(std::size_t width) : right(width + 1, kNobody), down(width + 1, kNobody) {}
    std::vector<std::int32_t> right, down;

    /// Puts in those of row y, after taking out those of the row that was there.
    void move_to(const CrossingField& field, std::size_t y) {
        for (const std::uint32_t edge : edges_) place(edge) = kNobody;
        edges_.clear();
        for (std::size_t i = field.row_start[y]; i < field.row_start[y + 1]; ++i) {
            const std::uint32_t edge = field.crossings[i].edge;
            place(edge) = static_cast<std::int32_t>(i);
            edges_.push_back(edge);
        }
    }
    std::span<const std::uint32_t> edges() const { return edges_; }

private:
    std::int32_t& place(std::uint32_t edge) { return (edge & 1 ? down : right)[edge / 2]; }
    std::vector<std::uint32_t> edges_;
};

class Linker {
public:
    Linker(const LineScene& scene, const CrossingField& field, LineKind kind)
        : scene_(scene),
          field_(field),
          kind_(kind),
          links_(field.crossings.size(), {kNobody, kNobody}) {}

    /// Cells in parallel by rows: each writes its own links.
    LineLinks run() {
        constexpr std::size_t kGrain = 32;
        const auto height = static_cast<std::size_t>(field_.height);
        const std::size_t n_rows = height > 0 ? height - 1 : 0;  // of cells
        parallel_blocks(n_rows, kGrain, [&](std::size_t begin, std::size_t end) {
            const auto width = static_cast<std::size_t>(field_.width);
            RowIndex top(width), bottom(width);
            bottom.move_to(field_, begin);
            for (std::size_t y = begin; y < end; ++y) {
                std::swap(top, bottom);
                bottom.move_to(field_, y + 1);
                link_row(top, bottom);
            }
        });
        return std::move(links_);
    }

private:
    /// Every cell with two crossings or more once: from its upper edge, or else its left,
    /// or else its right one.
    void link_row(const RowIndex& top, const RowIndex& bottom) {
        const auto width = static_cast<std::size_t>(field_.width);
        const auto look = [&](std::size_t x) {
            if (x + 1 >= width) return;
            CellCrossings cell;
            cell.add(top.right[x], 1), cell.add(top.down[x], 1);
            cell.add(top.down[x + 1], 0), cell.add(bottom.right[x], 0);
            if (cell.n >= 2) link_cell(cell);
        };
        for (const std::uint32_t edge : top.edges()) {
            const std::size_t x = edge / 2;
            const bool down = edge & 1;
            if (!down || top.right[x] == kNobody) look(x);
            if (down && x > 0 && top.right[x - 1] == kNobody && top.down[x - 1] == kNobody)
                look(x - 1);
        }
    }

    void link(const CellCrossings& c, std::size_t a, std::size_t b) {
        const auto of = [&](std::size_t k) -> std::int32_t& {
            return links_[static_cast<std::size_t>(c.id[k])][c.slot[k]];
        };
        of(a) = c.id[b], of(b) = c.id[a];
    }

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
        if (best < kNever) link(c, best_a, best_b);
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
            if (cost(c, a, b) < kNever) link(c, a, b);
        }
    }

    const LineScene& scene_;
    const CrossingField& field_;
    LineKind kind_;
    LineLinks links_;
};

/// Follows the links from a crossing on; marks what it passes.
FeatureLine follow(std::span<const LinePoint> crossings, const LineLinks& links, std::int32_t start,
                   LineKind kind, std::vector<std::uint8_t>& used) {
    FeatureLine line;
    line.kind = kind;
    for (std::int32_t at = start; at != kNobody;) {
        const auto i = static_cast<std::size_t>(at);
        used[i] = 1;
        line.points.push_back(crossings[i]);
        at = kNobody;
        for (const std::int32_t next : links[i])
            if (next != kNobody && !used[static_cast<std::size_t>(next)] && at == kNobody)
                at = next;
    }
    return line;
}

}  // namespace

LinePoint line_point(const Crossing& c) { return {c.x, c.y, c.point, c.weight, c.evidence}; }

LineLinks link_cells(const LineScene& scene, const CrossingField& field, LineKind kind) {
    return Linker(scene, field, kind).run();
}

std::vector<FeatureLine> follow_links(std::span<const LinePoint> crossings, const LineLinks& links,
                                      LineKind kind) {
    std::vector<std::uint8_t> used(links.size(), 0);
    std::vector<FeatureLine> lines;
    // Open lines from their ends, then what is left: loops.
    for (const bool open : {true, false})
        for (std::size_t i = 0; i < links.size(); ++i) {
            if (used[i] || (open && links[i][0] != kNobody && links[i][1] != kNobody)) continue;
            FeatureLine line = follow(crossings, links, static_cast<std::int32_t>(i), kind, used);
            line.closed = !open && line.points.size() > 2;
            if (line.points.size() > 1) lines.push_back(std::move(line));
        }
    return lines;
}

std::vector<FeatureLine> link_crossings(const LineScene& scene, const CrossingField& field,
                                        LineKind kind) {
    std::vector<LinePoint> points;
    for (const Crossing& c : field.crossings) points.push_back(line_point(c));
    return follow_links(points, link_cells(scene, field, kind), kind);
}

}  // namespace slim
