#pragma once

#include "raytrace/lines/feature_line.h"
#include "raytrace/lines/point_grid.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace slim {

/// How a line runs at one of its points, from three points before it to three after it.
struct Course {
    std::array<float, 2> direction{};  ///< unit, in the picture; 0 where it has none
    float unit_per_px = 0;             ///< length in space over that in the picture
};
Course course_at(const FeatureLine& line, std::size_t i);

/// Lines of a picture, beside which others are looked for: within 2.5 pixels of a picture 1000
/// high. Two places are one in space if their gap there is at most 8 times as long as that seen,
/// or as one that is a pixel wide.
///
/// cost     O(1) a point that is added or asked for, while lines do not crowd
class PlacedLines {
public:
    /// px       a pixel of a picture 1000 high, in pixels
    /// n_points about how many are added
    PlacedLines(float px, std::size_t n_points);

    void add(const FeatureLine& line);
    /// The two ends of an open line, nothing of a closed one.
    void add_ends(const FeatureLine& line);

    // Of points that are added; null if there is none within reach.

    /// The nearest one beside a point of another line: nearly parallel to it and not beyond an end;
    /// in_space: at one place in space, too.
    const LinePoint* beside(const LinePoint& p, const Course& course, bool in_space) const;
    /// The nearest one, in the picture, at one place in space, whatever its direction.
    const LinePoint* at_one_place(const LinePoint& p, const Course& course) const;
    /// The nearest one, whatever its direction and depth.
    const LinePoint* nearest(const LinePoint& p) const;

    /// Whether a line passes p within reach, or turns into another one at a corner there, rather
    /// than ends.
    bool passes(const LinePoint& p) const;

private:
    struct Place {
        LinePoint p;
        Course course;
        std::uint32_t line;  ///< numbers from 1
        bool is_end;
    };
    void add_point(const FeatureLine& line, std::size_t i);
    bool is_one_place(const LinePoint& p, const Course& course, const Place& at, float sq) const;

    template <class Wanted>
    const Place* nearest_place(const LinePoint& p, const Wanted& wanted) const {
        const Place* best = nullptr;
        float least = std::numeric_limits<float>::infinity();
        grid_.for_each(p.x, p.y, [&](std::uint32_t k, float sq) {
            if (sq < least && wanted(places_[k], sq)) least = sq, best = &places_[k];
        });
        return best;
    }

    float px_;
    PointGrid grid_;
    std::vector<Place> places_;
    std::uint32_t n_lines_ = 0;
};

}  // namespace slim
