#include "slim/scanner/range_grid.h"

#include "slim/scanner/noise.h"
#include "slim/shapes/foot_point.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr std::uint64_t kTile = 8;  // rays on a side that share the march to the shape's vicinity

/// Where all rays of a tile may begin: no ray of its cone meets the surface before.
double tile_start(const Shape& shape, const Station& station, std::uint64_t row,
                  std::uint64_t col) {
    const double half = 0.5 * static_cast<double>(kTile);
    const Ray middle = station.ray(static_cast<double>(row) + half - 0.5,
                                   static_cast<double>(col) + half - 0.5);
    // The plane at distance one meets the rays at distance >= 1, so pitch bounds the angle's
    // tangent.
    const double slope = std::sqrt(2.0) * half * station.pitch,
                 radius = 0.5 * shape.bounds.diagonal();
    const double width = slope * (length(shape.bounds.center() - station.position) + radius);
    if (width > 0.1 * radius) return 0;  // a coarse grid gains nothing
    const Interval ball = clip_to_ball(middle, shape.bounds.center(), radius + width);
    if (ball.empty() || shape.value(middle.at(ball.begin)) <= 0) return 0;
    return cone_clearance(shape, middle, ball, slope);
}

Interval ray_part(const Shape& shape, const Ray& ray, double start) {
    Interval part = clip_to_shape(ray, shape);
    part.begin = std::max(part.begin, start);
    return part;
}

void cast_tile(const Shape& shape, const ScanSettings& settings, const Station& station,
               std::uint64_t ray_key, std::uint64_t row, std::uint64_t col, RangeGrid& grid) {
    const double start = tile_start(shape, station, row, col);
    const std::uint64_t end_row = std::min(row + kTile, grid.first_row + grid.rows);
    const std::uint64_t end_col = std::min(col + kTile, grid.cols);
    for (std::uint64_t r = row; r < end_row; ++r)
        for (std::uint64_t c = col; c < end_col; ++c) {
            const Ray ray = station.ray(static_cast<double>(r), static_cast<double>(c));
            const Interval part = ray_part(shape, ray, start);
            const std::optional<Hit> hit = first_hit(shape, ray, part);
            Return& cell = grid.cells[(r - grid.first_row) * grid.cols + c];
            cell.valid = false;
            if (!hit) continue;
            const std::uint64_t key = ray_key + r * grid.cols + c;
            if (uniform_draw(settings.seed, key, Draw::dropout) <
                loss_probability(settings.dropout, hit->cos_incidence))
                continue;
            cell = measured_return(shape, settings, ray, *hit, clip_to_shape(ray, shape), key);
        }
}

}  // namespace

std::optional<Hit> first_hit(const Shape& shape, const Ray& ray, const Interval& part) {
    const std::optional<Crossing> crossing = next_crossing(shape, ray, part);
    if (!crossing || !crossing->entering) return std::nullopt;
    const SurfacePoint truth = surface_point(shape.jet(ray.at(crossing->t)));
    return Hit{crossing->t, truth, std::clamp(-dot(truth.normal, ray.direction), 0.0, 1.0)};
}

double loss_probability(double dropout, double cos_incidence) {
    return dropout * (1 - cos_incidence) * (1 - cos_incidence);
}

Return measured_return(const Shape& shape, const ScanSettings& settings, const Ray& ray,
                       const Hit& hit, const Interval& part, std::uint64_t key) {
    Return r{ray.at(hit.t), hit.t, hit.truth, true, false};
    if (uniform_draw(settings.seed, key, Draw::outlier) < settings.outliers) {
        const double place = uniform_draw(settings.seed, key, Draw::place);
        r.range = part.begin + place * (part.end - part.begin);
        r.position = ray.at(r.range);
        r.outlier = true;
        return r;
    }
    if (settings.noise == 0) return r;
    const double sigma = settings.noise * shape.bounds.diagonal();
    if (settings.noise_model == NoiseModel::ray) {
        r.range += sigma * gaussian_draw(settings.seed, key, Draw::range);
        r.position = ray.at(r.range);
        return r;
    }
    r.position += sigma * gaussian_vector(settings.seed, key);
    r.range = length(r.position - ray.origin);
    const FootPoint foot = foot_point(shape, r.position);
    if (foot.converged) r.truth = surface_point(shape.jet(foot.point));
    return r;
}

void cast_rows(const Shape& shape, const ScanSettings& settings, const Station& station,
               std::uint64_t ray_key, std::uint64_t first_row, std::uint64_t end_row,
               RangeGrid& grid) {
    grid.first_row = first_row;
    grid.rows = end_row - first_row;
    grid.cols = station.cols;
    grid.cells.resize(grid.rows * grid.cols);
    for (std::uint64_t row = first_row; row < end_row; row += kTile)
        for (std::uint64_t col = 0; col < grid.cols; col += kTile)
            cast_tile(shape, settings, station, ray_key, row, col, grid);
}

}  // namespace slim
