#pragma once

#include "raytrace/hillshade.h"
#include "raytrace/lines/line_scene.h"

#include <cstdint>
#include <map>
#include <vector>

namespace slim {

/// A place in the picture, pixels; centres at +0.5.
struct PicturePoint {
    float x = 0, y = 0;
};

/// A line of one height: `level` times the spacing. A closed one does not repeat its first point.
struct HeightLine {
    std::int64_t level = 0;
    bool closed = false;
    std::vector<PicturePoint> points;
};

/// Traces the lines of equal height of a view: marching squares over the heights at the pixels'
/// centres, no line where the surface breaks off (so steps of buildings have no stack of lines, as
/// in paint_relief), nor where lines lie closer than an eighth of a pixel (index contours then stay
/// if they do not). Source: Lorensen and Cline 1987 in two dimensions; saddles by their mean.
///
/// The view may come band by band from the top, each with the row below its last: the lines are
/// the same to the bit.
class HeightLineSearch {
public:
    /// spacing of the lines, model units, > 0; every relief.index_every-th is an index contour
    HeightLineSearch(const Relief& relief, double spacing);

    /// Rows [rows.begin, rows.end) of the planes, which hold positions and normals and whose first
    /// column is one of the picture. cost O(pixels)
    void add(const LineScene& scene, int first_column);

    /// The lines, by level and then from the top. What was found is gone then.
    std::vector<HeightLine> finish();

private:
    struct End {
        std::uint64_t edge;  ///< between two pixels
        PicturePoint at;
    };
    struct Segment {
        End from, to;
    };
    struct Row;
    void add_cell(const LineScene& scene, const Row& upper, const Row& lower, std::size_t x);
    static void link(std::int64_t level, const std::vector<Segment>& segments,
                     std::vector<HeightLine>& out);

    Vec3f up_;
    double base_, spacing_;
    int index_every_;
    std::map<std::int64_t, std::vector<Segment>> segments_;
};

}  // namespace slim
