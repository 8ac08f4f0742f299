#include "slim/base/frame.h"
#include "slim/base/parallel.h"
#include "slim/scanner/noise.h"
#include "slim/scanner/range_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slim {
namespace {

constexpr std::uint64_t kLinesPerBlock = 256, kMostBlocks = 1024;  // a batch: 1024 blocks at most

struct UniformBlock {
    ScanBlock points;
    std::vector<bool> outlier;
};

/// Line `id` of the isotropic uniform lines that meet the ball around the shape's bounds.
Ray random_line(const Shape& shape, std::uint64_t seed, std::uint64_t id) {
    const std::uint64_t h = keyed_hash(seed, id, static_cast<std::uint64_t>(Draw::line));
    const double z = 2 * unit_interval(h) - 1, level = std::sqrt(1 - z * z);
    const double around = 2 * std::numbers::pi * unit_interval(mix64(h));
    const Vec3d direction{level * std::cos(around), level * std::sin(around), z};
    const Frame<double> frame = frame_from_normal(direction);
    const double radius = 0.5 * shape.bounds.diagonal();
    const double r = radius * std::sqrt(unit_interval(mix64(h + 1)));
    const double turn = 2 * std::numbers::pi * unit_interval(mix64(h + 2));
    const Vec3d foot = shape.bounds.center() + frame.u_axis * (r * std::cos(turn)) +
                       frame.v_axis * (r * std::sin(turn));
    return {foot - direction * radius, direction};
}

void add_point(const Shape& shape, const ScanSettings& settings, const Ray& ray, double t,
               const Interval& part, std::uint64_t key, UniformBlock& block) {
    const Hit hit{t, surface_point(shape.jet(ray.at(t))), 1};
    const Return r = measured_return(shape, settings, ray, hit, part, key);
    block.points.positions.push_back(r.position);
    block.points.normals.push_back(to_float(r.truth.normal));
    block.points.truth.push_back(r.truth);
    block.points.scan_ids.push_back(0);
    block.outlier.push_back(r.outlier);
}

/// All crossings of lines [begin, end).
void sample_lines(const Shape& shape, const ScanSettings& settings, std::uint64_t begin,
                  std::uint64_t end, UniformBlock& block) {
    constexpr std::uint64_t kMostCrossings = 256;  // per line, for distinct keys
    block = {};
    for (std::uint64_t id = begin; id < end; ++id) {
        const Ray ray = random_line(shape, settings.seed, id);
        const Interval part = clip_to_shape(ray, shape);
        Interval rest = part;
        // Behind a crossing the march goes on a little deeper, where f has its new sign for
        // certain.
        const double past = 1e-9 * shape.bounds.diagonal();
        for (std::uint64_t i = 0; i < kMostCrossings; ++i) {
            const auto crossing = next_crossing(shape, ray, rest);
            if (!crossing) break;
            add_point(shape, settings, ray, crossing->t, part, id * kMostCrossings + i, block);
            rest.begin = crossing->t + past;
        }
    }
}

/// Drops what is beyond the n points wanted; lines are independent, so the end may go.
void truncate(UniformBlock& block, std::uint64_t n) {
    if (block.points.size() <= n) return;
    block.points.positions.resize(n);
    block.points.normals.resize(n);
    block.points.truth.resize(n);
    block.points.scan_ids.resize(n);
    block.outlier.resize(n);
}

}  // namespace

ScanSummary sample_uniformly(const Shape& shape, const ScanSettings& settings,
                             const ScanSink& sink, Reporter& reporter) {
    ScanSummary summary;
    summary.sigma = settings.noise * shape.bounds.diagonal();
    std::vector<UniformBlock> batch;
    while (summary.points < settings.n_points) {
        const std::uint64_t first = summary.rays, left = settings.n_points - summary.points;
        batch.resize(std::clamp(left / kLinesPerBlock, std::uint64_t{1}, kMostBlocks));
        parallel_blocks(batch.size(), 1, [&](std::size_t i, std::size_t) {
            const std::uint64_t begin = first + i * kLinesPerBlock;
            sample_lines(shape, settings, begin, begin + kLinesPerBlock, batch[i]);
        });
        summary.rays += batch.size() * kLinesPerBlock;
        for (UniformBlock& block : batch) {
            truncate(block, settings.n_points - summary.points);
            summary.points += block.points.size();
            for (const bool o : block.outlier) summary.outliers += o;
            if (block.points.size() > 0) sink(block.points);
        }
        reporter.progress("points", summary.points, settings.n_points);
    }
    return summary;
}

}  // namespace slim
