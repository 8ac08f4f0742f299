#include "raytrace/lines/label_place.h"

#include "raytrace/font.h"
#include "raytrace/legend.h"
#include "slim/base/check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace slim {
namespace {

constexpr float kCap = 12, kLeastCap = 7;     ///< a digit's height: thousandths of the side; pixels
constexpr float kLeastLength = 3, kEach = 15;  ///< of a line, in labels
constexpr float kApart = 5;                   ///< of equal heights, in labels
constexpr float kStraight = 0.33f;            ///< of a digit's height
constexpr float kSeenBeyond = 2;              ///< of an open line past a label, digits' heights
constexpr double kClear = 0.7;                ///< of the step between index contours
constexpr std::int64_t kMostLevels = 1000;    ///< a picture has no room for more

PicturePoint operator-(const PicturePoint& a, const PicturePoint& b) {
    return {a.x - b.x, a.y - b.y};
}
float length_of(const PicturePoint& p) { return std::hypot(p.x, p.y); }

/// A line in pixels of the picture with the way along it.
class MeasuredLine {
public:
    MeasuredLine(const HeightLine& line, float scale) : level(line.level), closed(line.closed) {
        for (const PicturePoint& p : line.points) points.push_back({p.x * scale, p.y * scale});
        if (line.closed) points.push_back(points.front());
        along.push_back(0);
        for (std::size_t i = 1; i < points.size(); ++i)
            along.push_back(along.back() + length_of(points[i] - points[i - 1]));
    }

    float length() const { return along.back(); }
    PicturePoint at(float way) const {
        const std::size_t i = segment_at(way);
        const float t = (way - along[i]) / std::max(along[i + 1] - along[i], 1e-6f);
        const PicturePoint d = points[i + 1] - points[i];
        return {points[i].x + t * d.x, points[i].y + t * d.y};
    }
    /// How far the line between two ways lies off the chord at most.
    float deviation(float from, float to) const {
        const PicturePoint a = at(from), d = at(to) - a;
        const float chord = length_of(d);
        if (!(chord > 0)) return std::numeric_limits<float>::infinity();
        float most = 0;
        for (std::size_t i = segment_at(from) + 1; i < points.size() && along[i] < to; ++i) {
            const PicturePoint p = points[i] - a;
            most = std::max(most, std::abs(p.x * d.y - p.y * d.x) / chord);
        }
        return most;
    }

    std::int64_t level;
    bool closed;
    std::vector<PicturePoint> points;

private:
    std::size_t segment_at(float way) const {
        const auto after = std::upper_bound(along.begin() + 1, along.end() - 1, way);
        return static_cast<std::size_t>(after - along.begin()) - 1;
    }

    std::vector<float> along;
};

/// The label's gap as a box along the picture's sides.
PixelBox box_of(const HeightLabel& l) {
    const float c = std::abs(std::cos(l.angle_rad)), s = std::abs(std::sin(l.angle_rad));
    const float x = l.half_length() * c + l.half_height() * s;
    const float y = l.half_length() * s + l.half_height() * c;
    return {l.x - x, l.y - y, l.x + x, l.y + y};
}

bool is_upside_down(const HeightLabel& label) { return std::cos(label.angle_rad) < -0.1f; }

/// Read from the picture's lower side, whichever way is uphill.
void set_upright(HeightLabel& label) {
    if (!is_upside_down(label)) return;
    constexpr float kHalfTurn = std::numbers::pi_v<float>;
    label.angle_rad += label.angle_rad > 0 ? -kHalfTurn : kHalfTurn;
}

bool overlap(const PixelBox& a, const PixelBox& b) {
    return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1;
}

class LabelPlacer {
public:
    LabelPlacer(const LineScene& frame, const Relief& relief, const LabelSheet& sheet)
        : frame_(frame),
          relief_(relief),
          sheet_(sheet),
          step_(relief.spacing * relief.index_every),
          scale_(static_cast<float>(sheet.width) / static_cast<float>(frame.buffer.width)),
          cap_(std::max(kLeastCap, kCap * text_unit(sheet.width, sheet.height))) {}

    std::vector<HeightLabel> place() {
        HeightLineSearch search(relief_, step_);
        search.add(frame_, 0);
        std::vector<MeasuredLine> lines;
        for (const HeightLine& line : search.finish().value_or(std::vector<HeightLine>{}))
            if (line.points.size() > 2) lines.emplace_back(line, scale_);
        if (lines.empty() || lines.back().level - lines.front().level > kMostLevels) return {};
        for (std::int64_t k = lines.front().level; k <= lines.back().level; ++k)
            heights_.push_back(static_cast<double>(k) * step_);
        std::stable_sort(lines.begin(), lines.end(), [](const auto& a, const auto& b) {
            return a.length() > b.length();
        });
        for (const MeasuredLine& line : lines) label(line);
        return std::move(labels_);
    }

private:
    void label(const MeasuredLine& line) {
        HeightLabel label;
        label.text = tick_label(static_cast<double>(line.level) * step_, heights_);
        if (!sheet_.unit.empty()) label.text += " " + sheet_.unit;
        label.cap_height = cap_;
        label.width = text_width(label.text, {.cap_height = cap_});
        const float length = line.length(), own = 2 * label.half_length();
        if (length < kLeastLength * own) return;
        const int n = std::max(1, static_cast<int>(std::round(length / (kEach * own))));
        const auto before = static_cast<std::ptrdiff_t>(labels_.size());
        for (int k = 0; k < n; ++k) {
            const float stretch = length / static_cast<float>(n);
            const auto best =
                best_place(line, label, stretch * static_cast<float>(k), stretch);
            if (best) labels_.push_back(*best);
        }
        if (!std::all_of(labels_.begin() + before, labels_.end(), is_upside_down))
            labels_.erase(std::remove_if(labels_.begin() + before, labels_.end(), is_upside_down),
                          labels_.end());
        std::for_each(labels_.begin() + before, labels_.end(), set_upright);
    }

    std::optional<HeightLabel> best_place(const MeasuredLine& line, HeightLabel label, float from,
                                          float stretch) const {
        constexpr float kUpsideDown = 10, kFromMiddle = 0.5f;
        const float half = label.half_length(), seen = line.closed ? 0 : kSeenBeyond * cap_;
        const float end = std::min(from + stretch, line.length() - seen) - half;
        std::optional<HeightLabel> best;
        float least = std::numeric_limits<float>::infinity();
        for (float way = std::max(from, seen) + half; way <= end; way += std::max(1.0f, cap_ / 4)) {
            const float bend = line.deviation(way - half, way + half) / cap_;
            if (bend > kStraight) continue;
            const float middle = std::abs(way - from - stretch / 2) / stretch;
            const float cost = bend / kStraight + kFromMiddle * middle;
            if (cost >= least) continue;
            turn_uphill(line, way, label);
            const float whole = cost + (is_upside_down(label) ? kUpsideDown : 0.0f);
            if (whole < least && has_room(line.level, label)) best = label, least = whole;
        }
        return best;
    }

    /// Puts the label on the chord of its stretch of the line, its head where the surface rises.
    void turn_uphill(const MeasuredLine& line, float way, HeightLabel& label) const {
        const PicturePoint a = line.at(way - label.half_length()),
                           b = line.at(way + label.half_length());
        const PicturePoint m = line.at(way);
        // The middle of the chord and the line's share it.
        label.x = (a.x + b.x + 2 * m.x) / 4, label.y = (a.y + b.y + 2 * m.y) / 4;
        label.angle_rad = std::atan2(b.y - a.y, b.x - a.x);
        const float reach = label.half_height();
        const float up_x = std::sin(label.angle_rad) * reach,
                    up_y = -std::cos(label.angle_rad) * reach;
        const auto above = level_at(label.x + up_x, label.y + up_y),
                   below = level_at(label.x - up_x, label.y - up_y);
        const bool flat = !above || !below || *above == *below;
        if (flat ? b.x < a.x : *above < *below)
            label.angle_rad = std::atan2(a.y - b.y, a.x - b.x);
    }

    /// Height in steps between index contours at a place of the picture; none beside the surface.
    std::optional<double> level_at(float x, float y) const {
        const int px = static_cast<int>(std::floor(x / scale_)),
                  py = static_cast<int>(std::floor(y / scale_));
        const GBuffer& b = frame_.buffer;
        if (px < 0 || py < 0 || px >= b.width || py >= b.height) return std::nullopt;
        const std::size_t i = b.index(px, py);
        if (!frame_.hit(i)) return std::nullopt;
        return (relief_.base + static_cast<double>(dot(relief_.axes[1], frame_.point(i)))) / step_;
    }

    bool has_room(std::int64_t level, const HeightLabel& label) const {
        const PixelBox box = box_of(label);
        if (box.x0 < cap_ || box.y0 < cap_ || box.x1 > static_cast<float>(sheet_.width) - cap_ ||
            box.y1 > static_cast<float>(sheet_.height) - cap_)
            return false;
        for (const PixelBox& taken : sheet_.taken)
            if (overlap(box, taken)) return false;
        for (const HeightLabel& other : labels_) {
            const float apart = std::hypot(label.x - other.x, label.y - other.y);
            if (overlap(box, box_of(other)) ||
                (other.text == label.text && apart < kApart * 2 * label.half_length()))
                return false;
        }
        return is_on_slope(level, label);
    }

    /// Whether all of the label lies on the surface, between the next index contours.
    bool is_on_slope(std::int64_t level, const HeightLabel& label) const {
        const float c = std::cos(label.angle_rad), s = std::sin(label.angle_rad);
        constexpr int kAlong = 6, kAcross = 2;
        for (int i = -kAlong; i <= kAlong; ++i)
            for (int k = -kAcross; k <= kAcross; ++k) {
                const float along = label.half_length() * static_cast<float>(i) / kAlong,
                            across = label.half_height() * static_cast<float>(k) / kAcross;
                const auto there = level_at(label.x + along * c - across * s,
                                            label.y + along * s + across * c);
                if (!there || std::abs(*there - static_cast<double>(level)) > kClear) return false;
            }
        return true;
    }

    const LineScene& frame_;
    const Relief& relief_;
    const LabelSheet& sheet_;
    double step_;  ///< between index contours
    float scale_;  ///< pixels of the picture in one of the frame
    float cap_;
    std::vector<double> heights_;
    std::vector<HeightLabel> labels_;
};

}  // namespace

std::vector<HeightLabel> place_height_labels(const LineScene& frame, const Relief& relief,
                                             const LabelSheet& sheet) {
    if (!(relief.spacing > 0) || !std::isfinite(relief.spacing * relief.index_every)) return {};
    SLIM_CHECK(frame.buffer.has(kPositionChannel | kNormalChannel), ==, true);
    return LabelPlacer(frame, relief, sheet).place();
}

}  // namespace slim
