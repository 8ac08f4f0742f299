#pragma once

#include "raytrace/hillshade.h"
#include "raytrace/lines/line_scene.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
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
/// the same to the bit. What is kept is a piece of a line in a cell between four pixels, 16 bytes
/// each; while a level is linked, 16 more of its own, then 8 a point of its lines.
class HeightLineSearch {
public:
    /// Lines of more pieces are no drawing that programs open: 130 MB are kept of so many.
    static constexpr std::size_t kMostPieces = std::size_t{1} << 23;

    /// spacing of the lines, model units, > 0; every relief.index_every-th is an index contour
    HeightLineSearch(const Relief& relief, double spacing, std::size_t most = kMostPieces);

    /// Rows [rows.begin, rows.end) of the planes, which hold positions and normals and whose first
    /// column is one of the picture (32768 x 32768 at most: SLIM_CHECK). cost O(pixels)
    void add(const LineScene& scene, int first_column);

    /// The lines, by level and then from the top; none if they are of more than `most` pieces,
    /// which keep no memory either. What was found is gone then.
    std::optional<std::vector<HeightLine>> finish();

private:
    /// Where a line crosses an edge between two pixels.
    struct End {
        std::uint32_t edge;
        float along;  ///< share of the way from its left or upper pixel

        PicturePoint at() const;
    };
    struct Segment {
        End from, to;
    };
    struct Row;
    void add_cell(const LineScene& scene, const Row& upper, const Row& lower, std::size_t x);
    using Segments = std::deque<Segment>;  // grows without a copy of all
    static std::vector<std::uint32_t> partners(const Segments& segments);
    static void link(std::int64_t level, const Segments& segments, std::vector<HeightLine>& out);

    Vec3f up_;
    double base_, spacing_;
    int index_every_;
    std::size_t most_, n_pieces_ = 0;
    std::map<std::int64_t, Segments> segments_;
};

}  // namespace slim
