#include "raytrace/lines/placed_lines.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

// Lengths in pixels of a picture 1000 high.
constexpr float kBeside = 2.5f;    ///< between strokes that are one
constexpr float kAlong = 1;        ///< beyond an end of a line nothing is beside it
constexpr float kMeet = 1.5f;      ///< between ends of lines that go on as each other
constexpr float kParallel = 0.87f; ///< cosine between directions
constexpr float kDepth = 8;        ///< of lines at one place: their gap in space over that seen
constexpr std::ptrdiff_t kReach = 3;  ///< points to either side that tell the course

/// The point of a line so many points on from point i, at an end the last one.
const LinePoint& moved(const FeatureLine& line, std::size_t i, std::ptrdiff_t by) {
    const auto n = static_cast<std::ptrdiff_t>(line.points.size());
    const std::ptrdiff_t to = static_cast<std::ptrdiff_t>(i) + by;
    return line.points[static_cast<std::size_t>(line.closed
                                                    ? ((to % n) + n) % n
                                                    : std::clamp<std::ptrdiff_t>(to, 0, n - 1))];
}

}  // namespace

Course course_at(const FeatureLine& line, std::size_t i) {
    const LinePoint &a = moved(line, i, -kReach), &b = moved(line, i, kReach);
    const float dx = b.x - a.x, dy = b.y - a.y, px = std::hypot(dx, dy);
    if (!(px > 0)) return {};
    return {{dx / px, dy / px}, length(b.point - a.point) / px};
}

PlacedLines::PlacedLines(float px, std::size_t n_points) : px_(px), grid_(kBeside * px, n_points) {
    places_.reserve(n_points);
}

void PlacedLines::add_point(const FeatureLine& line, std::size_t i) {
    const LinePoint& p = line.points[i];
    grid_.add(p.x, p.y, static_cast<std::uint32_t>(places_.size()));
    const bool is_end = !line.closed && (i == 0 || i + 1 == line.points.size());
    places_.push_back({p, course_at(line, i), n_lines_, is_end});
}

void PlacedLines::add(const FeatureLine& line) {
    ++n_lines_;
    for (std::size_t i = 0; i < line.points.size(); ++i) add_point(line, i);
}

void PlacedLines::add_ends(const FeatureLine& line) {
    if (line.closed || line.points.empty()) return;
    ++n_lines_;
    for (const std::size_t i : {std::size_t{0}, line.points.size() - 1}) add_point(line, i);
}

bool PlacedLines::is_one_place(const LinePoint& p, const Course& course, const Place& at,
                               float sq) const {
    return length(p.point - at.p.point) <=
           kDepth * std::max(std::sqrt(sq), px_) *
               std::max(course.unit_per_px, at.course.unit_per_px);
}

const LinePoint* PlacedLines::beside(const LinePoint& p, const Course& course,
                                     bool in_space) const {
    const std::array<float, 2>& d = course.direction;
    const Place* at = nearest_place(p, [&](const Place& place, float sq) {
        const std::array<float, 2>& e = place.course.direction;
        const float along = (p.x - place.p.x) * e[0] + (p.y - place.p.y) * e[1];
        return std::fabs(d[0] * e[0] + d[1] * e[1]) > kParallel &&
               std::fabs(along) <= kAlong * px_ &&
               (!in_space || is_one_place(p, course, place, sq));
    });
    return at ? &at->p : nullptr;
}

const LinePoint* PlacedLines::at_one_place(const LinePoint& p, const Course& course) const {
    const Place* at = nearest_place(p, [&](const Place& place, float sq) {
        return is_one_place(p, course, place, sq);
    });
    return at ? &at->p : nullptr;
}

const LinePoint* PlacedLines::nearest(const LinePoint& p) const {
    const Place* at = nearest_place(p, [](const Place&, float) { return true; });
    return at ? &at->p : nullptr;
}

bool PlacedLines::passes(const LinePoint& p) const {
    const Place* at = nearest_place(p, [](const Place&, float) { return true; });
    if (!at || !at->is_end) return at != nullptr;
    const float sq_meet = kMeet * kMeet * px_ * px_;
    return nearest_place(at->p, [&](const Place& other, float sq) {
               return other.line != at->line && sq <= sq_meet;
           }) != nullptr;
}

}  // namespace slim
