#pragma once

#include "raytrace/lines/line_scene.h"
#include "raytrace/lines/sheets.h"
#include "slim/base/parallel.h"
#include "slim/base/vec.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace slim {

/// Where a line crosses the edge between the centres of two neighbouring pixels a and b.
struct EdgeHit {
    float s = 0.5f;      ///< share of the way from a to b
    float weight = 0;    ///< |k| there, 1 / length: what strength integrates
    float evidence = 1;  ///< how clear the crossing is, dimensionless (see the kinds)
    enum class Side : std::uint8_t {
        both,
        a,
        b
    } surface = Side::both;  ///< whose surface it lies on
};

/// A crossing put into the picture.
struct Crossing {
    float x = 0, y = 0;  ///< picture, pixels; centres at +0.5
    Vec3f point;         ///< on the surface, frame of the job
    float weight = 0, evidence = 0;
    std::uint32_t pixel = 0;  ///< that its surface was seen in
    std::uint32_t edge = 0;   ///< twice the column of the edge's upper or
                              ///< left pixel, and 1 if it leads down
};

/// All crossings of one kind of line in the rows that are searched, in the order of rows, each
/// pixel's right edge before its lower one.
struct CrossingField {
    int width = 0, height = 0;  ///< height: number of rows
    std::vector<Crossing> crossings;
    std::vector<std::size_t> row_start;  ///< height + 1 offsets: those of edges that begin in a row
};

/// Crossings of some rows as they are found.
class RowCrossings {
public:
    RowCrossings(const LineScene& scene, std::size_t n_rows)
        : scene_(scene), row_start_(n_rows + 1) {}

    /// Row y, one after the other: find(a, b) -> optional<EdgeHit> for the pairs whose bit is set,
    /// right(x) and down(x) being those of pixels x, x + 1, ...
    /// with the next and with the one below.
    template <class Right, class Down, class Find>
    void look(std::size_t y, const Right& right, const Down& down, const Find& find) {
        const auto width = static_cast<std::size_t>(scene_.buffer.width);
        for (std::size_t x = 0; x < width; x += kLanes) {
            const std::uint32_t to_right = right(x), to_below = down(x);
            for_each_bit(to_right | to_below, [&](std::size_t k) {
                const std::size_t a = y * width + x + k;
                if (to_right >> k & 1) add(a, a + 1, find(a, a + 1));
                if (to_below >> k & 1) add(a, a + width, find(a, a + width));
            });
        }
        row_start_[++n_rows_] = crossings_.size();
    }

    friend CrossingField joined_rows(const LineScene& scene, std::vector<RowCrossings> bands);

private:
    void add(std::size_t a, std::size_t b, const std::optional<EdgeHit>& hit);

    const LineScene& scene_;
    std::vector<Crossing> crossings_;
    std::vector<std::size_t> row_start_;
    std::size_t n_rows_ = 0;
};

/// The crossings of all rows; bands of rows follow each other.
CrossingField joined_rows(const LineScene& scene, std::vector<RowCrossings> bands);

/// search(rows, begin, end) for bands of rows, in parallel; the same for any number of threads.
template <class Search>
CrossingField search_rows(const LineScene& scene, std::size_t grain, const Search& search) {
    const std::size_t first = scene.first_row(), height = scene.end_row() - first;
    std::vector<RowCrossings> bands;
    for (std::size_t y = 0; y < height; y += grain)
        bands.emplace_back(scene, std::min(height, y + grain) - y);
    parallel_blocks(height, grain, [&](std::size_t begin, std::size_t end) {
        search(bands[begin / grain], first + begin, first + end);
    });
    return joined_rows(scene, std::move(bands));
}

/// Asks find(a, b) -> optional<EdgeHit> for pairs of neighbours, b to the right of a or below it:
/// those that may(down, y, x) has bits for, of pixels x, x + 1, ... and their neighbours. Parallel
/// over rows. Cost: O(pixels).
template <class May, class Find>
CrossingField find_crossings(const LineScene& scene, const May& may, const Find& find) {
    constexpr std::size_t kGrain = 16;
    return search_rows(scene, kGrain, [&](RowCrossings& rows, std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y)
            rows.look(
                y, [&](std::size_t x) { return may(false, y, x); },
                [&](std::size_t x) { return may(true, y, x); }, find);
    });
}

/// The same for all pairs on one sheet.
template <class Find>
CrossingField find_on_sheets(const LineScene& scene, const Sheets& sheets, const Find& find) {
    const auto joined = [&](bool down, std::size_t y, std::size_t x) {
        return sheets.to(down).joined.at(static_cast<std::ptrdiff_t>(y),
                                         static_cast<std::ptrdiff_t>(x));
    };
    return find_crossings(scene, joined, find);
}

/// The crossings of each kind, by NUMERICS 5.4. Weights and evidence:
///
///     contour     1 / L; 1, and below 0.5 where a step that faces the eye is none that surfels
///                 which disagree would not make (contour.cpp)
///     suggestive  sqrt(D_w kappa_r); D_w kappa_r, which the search takes over the square of the
///                 view's typical curvature once it has seen all of it (line_search.h)
///     ridge       k1; 4 of an edge within a pixel, else 0 until the search has seen the whole
///                 picture and looks how k1 falls along t1 (crest_look.h)
///     valley      -k2; the same for -k2 along t2
///     parabolic   the curvature that does not vanish; 1 until the search has seen the whole
///                 picture and looks across the lines (parabolic_look.h)
///     reflection  1 / L; 1
CrossingField contour_crossings(const LineScene& scene, const Sheets& sheets);
CrossingField suggestive_crossings(const LineScene& scene, const Sheets& sheets);
CrossingField crest_crossings(const LineScene& scene, const Sheets& sheets, bool ridges);
CrossingField parabolic_crossings(const LineScene& scene, const Sheets& sheets);
CrossingField reflection_crossings(const LineScene& scene, const Sheets& sheets);

/// Adds the greater curvatures, without their sign, of some 200,000 pixels of a picture: those of
/// the rows that are searched, where they are hit.
void sample_curvature(const LineScene& scene, std::vector<float>& sample);
/// The curvature that half of a sample exceed: the scale of the view's shapes. 1 / diagonal at
/// least.
float typical_curvature(std::vector<float> sample, double diagonal);

}  // namespace slim
