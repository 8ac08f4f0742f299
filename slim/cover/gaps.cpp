#include "slim/cover/gaps.h"

#include "slim/base/bbox.h"
#include "slim/base/parallel.h"
#include "slim/cover/drawn_part.h"
#include "slim/cover/leaf_balls.h"
#include "slim/cover/leaves_along_curve.h"
#include "slim/cover/leaves_meeting.h"
#include "slim/fit/ball_points.h"
#include "slim/model/rim.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <utility>

namespace slim {
namespace {

using Leaves = std::vector<const Surfel*>;

constexpr std::size_t kPiece = 256;   // leaves of a task, at most
constexpr double kLeastCos = 0.5;     // of normals of one sheet
constexpr std::size_t kAbout = 10;    // points about a place that are asked
constexpr std::size_t kLeast = 5;     // of them on its sheet
constexpr double kOff = 0.6;          // times the points' spacing: off the leaf's sheet
constexpr double kWidest = 0.8 * std::numbers::pi;  // between directions to points on all sides

/// The widest angle between directions that follow each other; sorts them. angles: at least one
double widest_between(std::vector<double>& angles) {
    std::sort(angles.begin(), angles.end());
    double widest = angles.front() + 2 * std::numbers::pi - angles.back();
    for (std::size_t i = 1; i < angles.size(); ++i)
        widest = std::max(widest, angles[i] - angles[i - 1]);
    return widest;
}

class GapSearch {
public:
    explicit GapSearch(const PointTree& points) : points_(points) {}

    void look(std::span<const Surfel* const> leaves, const LeafBalls& others,
              std::vector<Gap>& out) {
        for_leaves_together(leaves, others,
                            [&](std::size_t, std::span<const Surfel* const> some,
                                const LeafBalls& near) {
                                for (const Surfel* s : some)
                                    if (!s->sharp) look_about(*s, near, out);
                            });
    }

private:
    void look_about(const Surfel& s, const LeafBalls& others, std::vector<Gap>& out) {
        near_.clear();
        radius_ = s.support_radius / 4;
        append_meeting(s, others, near_);
        for (int k = 0; k < kRimDirections; ++k) {
            const auto [u, v] = rim_direction(k);
            const Vec3d x = s.center + place_beyond(s, u, v) * s.support_radius;
            if (!is_drawn_by_others(x, s.frame.normal)) ask_points(s, x, out);
        }
    }

    /// Those that draw one place come first at the next one, which mostly is theirs too.
    bool is_drawn_by_others(const Vec3d& x, const Vec3d& normal) {
        for (std::size_t i = 0; i < near_.size(); ++i)
            if (is_drawn_at(*near_[i], x, normal)) {
                std::swap(near_[i], near_.front());
                return true;
            }
        return false;
    }

    /// Whether a leaf has its centre there already.
    bool is_center(const Vec3d& p, const Surfel& s) const {
        return p == s.center || std::any_of(near_.begin(), near_.end(), [&](const Surfel* t) {
                   return p == t->center;
               });
    }

    /// Some points about a place: a ball as large as at the place before, unless that is too small
    /// or too large.
    void gather_about(const Surfel& s, const Vec3d& x) {
        gather_ball(points_, x, radius_, ball_);
        while (ball_.n < kAbout && radius_ < s.support_radius)
            gather_ball(points_, x, radius_ *= 1.4, ball_);
        if (ball_.n <= 2 * kAbout) return;
        radius_ *= std::sqrt(1.5 * kAbout / static_cast<double>(ball_.n));
        shrink_ball(ball_, radius_, ball_);
    }

    /// Whether points of the leaf's sheet lie about a place on all sides: the nearest is added.
    void ask_points(const Surfel& s, const Vec3d& x, std::vector<Gap>& out) {
        gather_about(s, x);
        if (ball_.n < kLeast) return;
        const double off = kOff * std::sqrt(std::numbers::pi / static_cast<double>(ball_.n));
        const Vec3d at = s.frame.local_from_world((x - s.center) / s.support_radius);
        const double scale = radius_ / s.support_radius;
        angles_.clear();
        double least = INFINITY;
        std::uint32_t nearest = 0;
        for (std::size_t i = 0; i < ball_.n; ++i) {
            if (dot(ball_.normal(i), s.frame.normal) < kLeastCos) continue;
            const Vec3d away = s.frame.local_from_world(ball_.place(i));
            const Vec3d p = at + away * scale;
            if (std::abs(p.z - s.polynomial.value(p.x, p.y)) > off * scale) continue;
            angles_.push_back(std::atan2(away.y, away.x));
            if (ball_.sq[i] < least && !is_center(points_.position(ball_.index[i]), s))
                least = ball_.sq[i], nearest = ball_.index[i];
        }
        if (angles_.size() < kLeast || std::isinf(least)) return;
        if (widest_between(angles_) < kWidest) out.push_back({x, s.frame.normal, nearest});
    }

    const PointTree& points_;
    Leaves near_;
    double radius_ = 0;  // of the last ball about a place of this leaf
    BallPoints<double> ball_;
    std::vector<double> angles_;  // of directions to points of its sheet
};

/// The gaps about leaves that lie together, halves of many at the same time.
std::vector<Gap> gaps_about(const PointTree& points, std::span<const Surfel* const> leaves,
                            const LeafBalls& others) {
    std::vector<Gap> out;
    if (leaves.size() <= kPiece) {
        GapSearch(points).look(leaves, others, out);
        return out;
    }
    const LeafBalls near = meeting(leaves, others);
    const std::size_t half = leaves.size() / 2;
    std::vector<Gap> rest;
    run_both([&] { out = gaps_about(points, leaves.first(half), near); },
             [&] { rest = gaps_about(points, leaves.subspan(half), near); });
    out.insert(out.end(), rest.begin(), rest.end());
    return out;
}

Bbox box_of(const PointTree& points) {
    Bbox box;
    for (std::size_t i = 0; i < points.size(); i += PointTree::kBucket) {
        const Bbox bucket = points.bucket_box(i);
        box.extend(bucket.lo), box.extend(bucket.hi);
    }
    return box;
}

}  // namespace

std::vector<Gap> find_gaps(const PointTree& points, const Leaves& leaves) {
    // of a slice's points: few of the coarse ones are there
    const Leaves ordered = leaves_along_curve(
        leaves_meeting(box_of(points), leaves), [](const Surfel& s) -> const Surfel& { return s; });
    return gaps_about(points, ordered, LeafBalls(ordered));
}

}  // namespace slim
