#pragma once

#include "raytrace/lines/line_scene.h"
#include "raytrace/lines/sheet_blur.h"
#include "slim/base/parallel.h"
#include "slim/base/vec.h"

#include <cstddef>
#include <cstdint>
#include <optional>
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
};

/// All crossings of one kind of line, in the order of rows, each pixel's right edge before its
/// lower one.
struct CrossingField {
    int width = 0, height = 0;
    std::vector<Crossing> crossings;
    std::vector<std::int32_t> right, down;  ///< per pixel: crossing of that edge, -1 for none
};

/// Entry point of a found edge into the picture.
Crossing place_crossing(const LineScene& scene, std::size_t a, std::size_t b, const EdgeHit& hit);

/// Asks find(a, b) -> optional<EdgeHit> for every pair of neighbours, b to the right of a or below
/// it. Parallel over rows; the same for any number of threads. Cost: O(pixels).
template <class Find>
CrossingField find_crossings(const LineScene& scene, const Find& find) {
    const GBuffer& g = scene.buffer;
    const auto width = static_cast<std::size_t>(g.width),
               height = static_cast<std::size_t>(g.height);
    struct Found {
        Crossing crossing;
        std::size_t pixel;
        bool down;
    };
    std::vector<std::vector<Found>> rows(height);
    parallel_blocks(height, 1, [&](std::size_t y, std::size_t) {
        const auto look = [&](std::size_t a, std::size_t b, bool down) {
            if (const std::optional<EdgeHit> hit = find(a, b))
                rows[y].push_back({place_crossing(scene, a, b, *hit), a, down});
        };
        for (std::size_t x = 0; x < width; ++x) {
            const std::size_t a = y * width + x;
            if (x + 1 < width) look(a, a + 1, false);
            if (y + 1 < height) look(a, a + width, true);
        }
    });
    CrossingField field{g.width, g.height, {}, {}, {}};
    field.right.assign(g.n_pixels(), -1);
    field.down.assign(g.n_pixels(), -1);
    for (const auto& row : rows)
        for (const Found& f : row) {
            (f.down ? field.down : field.right)[f.pixel] =
                static_cast<std::int32_t>(field.crossings.size());
            field.crossings.push_back(f.crossing);
        }
    return field;
}

/// The crossings of each kind, by NUMERICS 5.4. Weights and evidence:
///
///     contour     1 / L; 1
///     suggestive  sqrt(D_w kappa_r); D_w kappa_r over the square of the view's typical curvature
///     ridge       k1; its sharpness -k1'' / k1^3 along t1: 3 (1 - b^2/a^2) at an ellipse's tip
///     valley      -k2; the same for -k2 along t2
///     parabolic   the curvature that does not vanish; 1
///     reflection  1 / L; 1
CrossingField contour_crossings(const LineScene& scene);
CrossingField suggestive_crossings(const LineScene& scene, const SheetBlur& blur);
CrossingField crest_crossings(const LineScene& scene, const SheetBlur& blur, bool ridges);
CrossingField parabolic_crossings(const LineScene& scene, const SheetBlur& blur);
CrossingField reflection_crossings(const LineScene& scene);

}  // namespace slim
