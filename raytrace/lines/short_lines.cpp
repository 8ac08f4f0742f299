#include "raytrace/lines/short_lines.h"

#include "raytrace/lines/join.h"
#include "raytrace/lines/point_grid.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

namespace slim {
namespace {

constexpr float kReach = 3;    ///< pixels, within which select_lines lets lines meet
constexpr float kWidth = 1.2f; ///< pixels of a picture 1000 high: mean width of the least part
constexpr float kBrief = 3;    ///< lengths that a line must have: longer loops are no crumbs

/// Points of the longer lines.
class LongLines {
public:
    struct Place {
        const LinePoint* at;
        std::size_t line;
        float way;  ///< along the line up to there, pixels
    };

    explicit LongLines(std::span<const FeatureLine> lines, float least_px)
        : lines_(lines), grid_(kReach, count(lines, least_px)) {
        for (std::size_t i = 0; i < lines.size(); ++i)
            if (lines[i].length_px >= least_px) add(i);
    }

    /// The nearest to p, within reach.
    std::optional<Place> near(const LinePoint& p) const {
        std::optional<Place> best;
        float least = std::numeric_limits<float>::infinity();
        grid_.for_each(p.x, p.y, [&](std::uint32_t place, float sq) {
            if (sq < least) least = sq, best = places_[place];
        });
        return best;
    }

    /// The way from one place to another along the line; infinite between lines.
    float way(const Place& a, const Place& b) const {
        if (a.line != b.line) return std::numeric_limits<float>::infinity();
        const FeatureLine& line = lines_[a.line];
        const float way = std::fabs(a.way - b.way);
        return line.closed ? std::min(way, line.length_px - way) : way;
    }

private:
    static std::size_t count(std::span<const FeatureLine> lines, float least_px) {
        std::size_t n = 0;
        for (const FeatureLine& line : lines)
            if (line.length_px >= least_px) n += line.points.size();
        return n;
    }
    void add(std::size_t i) {
        float way = 0;
        const LinePoint* before = nullptr;
        for (const LinePoint& p : lines_[i].points) {
            if (before) way += std::hypot(p.x - before->x, p.y - before->y);
            grid_.add(p.x, p.y, static_cast<std::uint32_t>(places_.size()));
            places_.push_back({&p, i, way});
            before = &p;
        }
    }

    std::span<const FeatureLine> lines_;
    PointGrid grid_;
    std::vector<Place> places_;
};

/// Whether there would be a gap without a short line.
bool is_bridge(const FeatureLine& line, const LongLines& others) {
    const auto a = others.near(line.points.front()), b = others.near(line.points.back());
    if (!a || !b) return false;
    const float apart = std::hypot(a->at->x - b->at->x, a->at->y - b->at->y);
    return apart > kReach && others.way(*a, *b) > 4 * std::max(line.length_px, apart);
}

/// Whether a loop goes round next to nothing: a step that is seen and at once no more.
bool is_sliver(const FeatureLine& line, const LineRules& rules, float px) {
    if (!line.closed || line.length_px > kBrief * rules.least_px) return false;
    float twice_area = 0;
    line.for_each_segment([&](const LinePoint& a, const LinePoint& b) {
        const LinePoint& o = line.points.front();
        twice_area += (a.x - o.x) * (b.y - o.y) - (b.x - o.x) * (a.y - o.y);
    });
    return std::fabs(twice_area) < kWidth * px * line.length_px;
}

/// Whether a loop is too small to tell of more than a dent of the fit.
bool is_dent(const FeatureLine& line, const LineRules& rules) {
    return line.length_px < rules.loop_px && line.strength < rules.loop_strength;
}

bool stays_as_loop(const FeatureLine& line, const LineRules& rules, float px) {
    return !is_dent(line, rules) && (!rules.meets_anywhere || !is_sliver(line, rules, px));
}

}  // namespace

std::vector<FeatureLine> link_short_lines(std::vector<FeatureLine> lines, const LineRules& rules,
                                          float px) {
    lines = join_ends(std::move(lines), px, rules.least_px);
    for (FeatureLine& line : lines) measure_line(line);
    const LongLines others(lines, rules.least_px);
    std::vector<std::uint8_t> stays;
    for (const FeatureLine& line : lines)
        stays.push_back(line.closed ? stays_as_loop(line, rules, px)
                                    : line.length_px >= rules.least_px ||
                                          (rules.meets_anywhere && is_bridge(line, others)));
    std::vector<FeatureLine> out;
    for (std::size_t i = 0; i < lines.size(); ++i)
        if (stays[i]) out.push_back(std::move(lines[i]));
    return out;
}

}  // namespace slim
