#include "raytrace/lines/height_line.h"

#include "slim/base/check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace slim {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kMostSteps = 1e15;  ///< beyond, a double no longer tells a line from the next
constexpr double kMostInCell = 8;
constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kMostSide = 1u << 15;

std::uint32_t edge_of(std::uint32_t x, std::uint32_t y, bool down) {
    return (y * kMostSide + x) * 2 + (down ? 1 : 0);
}

/// Where a level lies between the left or upper end of an edge, 0, and the other, 1.
float crossing(double from, double to, double level) {
    return static_cast<float>((level - from) / (to - from));
}

/// The first level above a height that is a multiple of `every`.
double first_level(double above, double every) { return (std::floor(above / every) + 1) * every; }

}  // namespace

/// Heights of a row of pixels in steps of the spacing; none where nothing is hit.
struct HeightLineSearch::Row {
    std::size_t first;  ///< entry of the planes
    std::uint32_t x, y;  ///< of its first pixel in the picture
    std::vector<double> steps;

    Row(const HeightLineSearch& search, const LineScene& s, int row, int first_column)
        : first(s.buffer.index(0, row)),
          x(static_cast<std::uint32_t>(first_column)),
          y(static_cast<std::uint32_t>(row + s.rows.top)),
          steps(static_cast<std::size_t>(s.buffer.width), kNone) {
        for (std::size_t k = 0; k < steps.size(); ++k) {
            if (!s.hit(first + k)) continue;
            const auto height = static_cast<double>(dot(search.up_, s.point(first + k)));
            const double in_steps = (search.base_ + height) / search.spacing_;
            if (std::abs(in_steps) < kMostSteps) steps[k] = in_steps;
        }
    }
};

/// Pixel centres at +0.5.
PicturePoint HeightLineSearch::End::at() const {
    const auto x = static_cast<float>(edge / 2 % kMostSide) + 0.5f,
               y = static_cast<float>(edge / 2 / kMostSide) + 0.5f;
    return edge % 2 == 0 ? PicturePoint{x + along, y} : PicturePoint{x, y + along};
}

HeightLineSearch::HeightLineSearch(const Relief& relief, double spacing, std::size_t most)
    : up_(relief.axes[1]),
      base_(relief.base),
      spacing_(spacing),
      index_every_(relief.index_every),
      most_(most) {}

void HeightLineSearch::add(const LineScene& scene, int first_column) {
    if (n_pieces_ > most_) return;
    SLIM_CHECK(first_column + scene.buffer.width, <=, static_cast<int>(kMostSide));
    SLIM_CHECK(scene.picture_height(), <=, static_cast<int>(kMostSide));
    const int last = std::min(static_cast<int>(scene.end_row()), scene.buffer.height - 1);
    Row upper(*this, scene, scene.rows.begin, first_column);
    for (int y = scene.rows.begin; y < last; ++y) {
        Row lower(*this, scene, y + 1, first_column);
        for (std::size_t x = 0; x + 1 < upper.steps.size(); ++x) {
            const double a = std::floor(upper.steps[x]), b = std::floor(upper.steps[x + 1]),
                         c = std::floor(lower.steps[x + 1]), d = std::floor(lower.steps[x]);
            // What is not hit differs, from itself as well.
            if (a != b || b != c || c != d) add_cell(scene, upper, lower, x);
        }
        upper = std::move(lower);
    }
    if (n_pieces_ > most_) segments_.clear();
}

void HeightLineSearch::add_cell(const LineScene& scene, const Row& upper, const Row& lower,
                                std::size_t x) {
    const double a = upper.steps[x], b = upper.steps[x + 1], c = lower.steps[x + 1],
                 d = lower.steps[x];
    if (std::isnan(a + b + c + d)) return;
    const std::size_t u = upper.first + x, l = lower.first + x;
    if (breaks_off(scene, u, u + 1) || breaks_off(scene, u + 1, l + 1) ||
        breaks_off(scene, l, l + 1) || breaks_off(scene, u, l))
        return;
    const auto [lo, hi] = std::minmax({a, b, c, d});
    const double every = hi - lo <= kMostInCell ? 1 : index_every_;
    if (hi - lo > kMostInCell * every) {  // not drawn, but too many all the same
        n_pieces_ += static_cast<std::size_t>((hi - lo) / every);
        return;
    }
    const std::uint32_t px = upper.x + static_cast<std::uint32_t>(x), py = upper.y;
    for (double level = first_level(lo, every); level <= hi; level += every) {
        std::array<End, 4> ends;  // in turn: top, right, bottom, left
        std::array<bool, 4> has{(a >= level) != (b >= level), (b >= level) != (c >= level),
                                (d >= level) != (c >= level), (a >= level) != (d >= level)};
        ends[0] = {edge_of(px, py, false), crossing(a, b, level)};
        ends[1] = {edge_of(px + 1, py, true), crossing(b, c, level)};
        ends[2] = {edge_of(px, py + 1, false), crossing(d, c, level)};
        ends[3] = {edge_of(px, py, true), crossing(a, d, level)};
        if (++n_pieces_ > most_) return;
        Segments& found = segments_[static_cast<std::int64_t>(level)];
        if (has[0] && has[1] && has[2] && has[3]) {
            ++n_pieces_;
            const bool joins_a = ((a + b + c + d) / 4 >= level) == (a >= level);
            found.push_back(joins_a ? Segment{ends[0], ends[1]} : Segment{ends[3], ends[0]});
            found.push_back(joins_a ? Segment{ends[2], ends[3]} : Segment{ends[1], ends[2]});
            continue;
        }
        const auto first = static_cast<std::size_t>(std::find(has.begin(), has.end(), true) -
                                                    has.begin());
        std::size_t second = 3;
        while (!has[second]) --second;
        found.push_back({ends[first], ends[second]});
    }
}

std::optional<std::vector<HeightLine>> HeightLineSearch::finish() {
    if (n_pieces_ > most_) return std::nullopt;
    std::vector<HeightLine> lines;
    while (!segments_.empty()) {
        const auto level = segments_.extract(segments_.begin());
        link(level.key(), level.mapped(), lines);
    }
    n_pieces_ = 0;
    return lines;
}

/// Of each end (twice a segment's number, one more of its `to`) the other one at its edge, which is
/// an end of at most two segments.
std::vector<std::uint32_t> HeightLineSearch::partners(const Segments& segments) {
    const auto edge_at = [&](std::uint32_t e) {
        return e % 2 == 0 ? segments[e / 2].from.edge : segments[e / 2].to.edge;
    };
    std::vector<std::uint32_t> order(2 * segments.size()), partner(order.size(), kNobody);
    for (std::uint32_t e = 0; e < order.size(); ++e) order[e] = e;
    std::sort(order.begin(), order.end(), [&](std::uint32_t p, std::uint32_t q) {
        return std::pair(edge_at(p), p) < std::pair(edge_at(q), q);
    });
    for (std::size_t i = 0; i + 1 < order.size(); ++i)
        if (edge_at(order[i]) == edge_at(order[i + 1]))
            partner[order[i]] = order[i + 1], partner[order[i + 1]] = order[i];
    return partner;
}

/// Chains from their free ends first, then rings.
void HeightLineSearch::link(std::int64_t level, const Segments& segments,
                            std::vector<HeightLine>& out) {
    const auto point_at = [&](std::uint32_t e) {
        return (e % 2 == 0 ? segments[e / 2].from : segments[e / 2].to).at();
    };
    const std::vector<std::uint32_t> partner = partners(segments);
    std::vector<char> used(segments.size(), 0);
    const auto walk = [&](std::uint32_t from, bool closed) {
        HeightLine line{level, closed, {point_at(from)}};
        for (std::uint32_t e = from;;) {
            used[e / 2] = 1;
            const std::uint32_t far = e ^ 1, next = partner[far];
            if (next == from) break;  // round
            line.points.push_back(point_at(far));
            if (next == kNobody) break;
            e = next;
        }
        out.push_back(std::move(line));
    };
    for (std::uint32_t e = 0; e < partner.size(); ++e)
        if (partner[e] == kNobody && !used[e / 2]) walk(e, false);
    for (std::uint32_t e = 0; e < partner.size(); e += 2)
        if (!used[e / 2]) walk(e, true);
}

}  // namespace slim
