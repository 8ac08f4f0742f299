#include "pipeline/measure_stage.h"

#include "formats/atomic_file.h"
#include "formats/model_file.h"
#include "formats/point_source.h"
#include "formats/truth_file.h"
#include "pipeline/input_kind.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"
#include "slim/smooth/point_projector.h"
#include "slim/tree/ball_index.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

namespace slim {
namespace {

constexpr std::size_t kChunk = 1 << 18;
constexpr std::size_t kGrain = 2048;

/// Sums over points; those of a block are added in order, so threads do not matter.
struct Sums {
    std::uint64_t points = 0, missed = 0, opposed = 0, astray = 0, no_normal = 0;
    double sq_distance = 0, max = -1 /* none yet */, sq_angle = 0, sq_k1 = 0, sq_k2 = 0,
           sq_mean = 0;
    std::uint64_t n_angles = 0;
    Vec3d max_at;  // world; the first point of the greatest distance

    void add_distance(double t, const Vec3d& world) {
        sq_distance += t * t;
        if (std::abs(t) > max) max = std::abs(t), max_at = world;
    }
    void add(const Sums& b) {
        points += b.points, missed += b.missed, opposed += b.opposed, astray += b.astray;
        no_normal += b.no_normal;
        sq_distance += b.sq_distance;
        if (b.max > max) max = b.max, max_at = b.max_at;
        sq_angle += b.sq_angle, n_angles += b.n_angles;
        sq_k1 += b.sq_k1, sq_k2 += b.sq_k2, sq_mean += b.sq_mean;
    }
};

double angle_deg(const Vec3d& a, const Vec3d& b) {
    return std::atan2(length(cross(a, b)), dot(a, b)) * 180 / std::numbers::pi;
}

/// One point against the model; `truth` may be null.
class PointMeter {
public:
    PointMeter(const BallIndex& index, const Vec3d& origin) : projector_(index), origin_(origin) {}

    void measure(const Vec3d& world, const Vec3f& own_normal, const PointTruth* truth, Sums& sums) {
        if (!is_finite(world)) return;
        ++sums.points;
        const ProjectedPoint put = projector_.project(world - origin_, to_double(own_normal), truth != nullptr);
        sums.no_normal += put.has_normal ? 0u : 1u;
        sums.missed += put.hit ? 0u : 1u;
        if (!put.hit) return;
        sums.opposed += put.opposed ? 1u : 0u;
        sums.astray += put.astray ? 1u : 0u;
        sums.add_distance(put.hit->t, world);
        if (truth || put.has_normal)
            add_angle(*put.hit, truth ? truth->normal : put.direction, put.opposed, sums);
        if (truth) add_curvature(*put.hit, *truth, sums);
    }

private:
    static void add_angle(const Projection& hit, const Vec3d& reference, bool opposed, Sums& sums) {
        double angle = angle_deg(hit.normal, reference);
        if (opposed) angle = std::min(angle, 180 - angle);
        sums.sq_angle += angle * angle;
        ++sums.n_angles;
    }
    static void add_curvature(const Projection& hit, const PointTruth& truth, Sums& sums) {
        const auto sq = [](double x) { return x * x; };
        sums.sq_k1 += sq(hit.curvature.k1 - truth.k1);
        sums.sq_k2 += sq(hit.curvature.k2 - truth.k2);
        sums.sq_mean += sq(hit.curvature.mean - 0.5 * (truth.k1 + truth.k2));
    }

    PointProjector projector_;
    Vec3d origin_;
};

Sums measure_cloud(const MeasureConfig& config, const BallIndex& index, const Vec3d& origin,
                   const std::string& truth_file, StageContext& context) {
    const auto source = open_cloud(config.cloud);
    std::vector<PointTruth> truth;
    if (!truth_file.empty())
        truth = read_truth(truth_file, std::filesystem::file_size(truth_file) / sizeof(PointTruth));
    Sums sums;
    PointChunk chunk;
    std::uint64_t first = 0;
    while (source->read(chunk, kChunk)) {
        if (!truth.empty() && first + chunk.size() > truth.size())
            throw FormatError(fmt::format("{}: holds {} points' truth, {} has more points",
                                          truth_file, truth.size(), config.cloud));
        std::vector<Sums> partial((chunk.size() + kGrain - 1) / kGrain);
        parallel_blocks(chunk.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            PointMeter meter(index, origin);
            for (std::size_t i = begin; i < end; ++i)
                meter.measure(chunk.position[i], chunk.normal.empty() ? Vec3f{} : chunk.normal[i],
                              truth.empty() ? nullptr : &truth[first + i], partial[begin / kGrain]);
        });
        for (const Sums& p : partial) sums.add(p);
        first += chunk.size();
        context.reporter.progress("measure", source->bytes_read(), source->info().file_size);
        context.check_stop();
    }
    if (!truth.empty() && first != truth.size())
        throw FormatError(fmt::format("{}: expected the truth of {} points, found {}", truth_file,
                                      first, truth.size()));
    if (sums.points == 0) throw DataError(config.cloud + ": no finite point to measure");
    return sums;
}

/// Null where there is nothing to take a mean of: 0 would be the best score.
nlohmann::json rms(double sum, std::uint64_t n, double unit = 1) {
    return n > 0 ? nlohmann::json(std::sqrt(sum / static_cast<double>(n)) / unit)
                 : nlohmann::json();
}

/// The result without its record.
nlohmann::json measured(const MeasureConfig& config, const std::string& truth,
                        StageContext& context) {
    const ModelFile model = ModelFile::open(config.model);
    const SurfelTree tree = model.tree();
    const BallIndex index(tree);
    const Sums s = measure_cloud(config, index, model.header().origin, truth, context);

    const std::uint64_t hits = s.points - s.missed;
    const double diagonal = model.header().diagonal;
    if (2 * s.missed > s.points)
        context.reporter.warn(fmt::format(
            "{}: {} of its {} points lie in no surfel's support of {}: are they in the same frame?",
            config.cloud, s.missed, s.points, config.model));
    nlohmann::json out = {{"points", s.points},
                          {"missed", s.missed},
                          {"opposed", s.opposed},
                          {"astray", s.astray},
                          {"without_normal", s.no_normal},
                          {"l2", rms(s.sq_distance, hits, diagonal)},
                          {"max", hits > 0 ? nlohmann::json(s.max / diagonal) : nlohmann::json()},
                          {"max_at", hits > 0 ? nlohmann::json{s.max_at.x, s.max_at.y, s.max_at.z}
                                              : nlohmann::json()},
                          {"normal_rms_deg", rms(s.sq_angle, s.n_angles)},
                          {"leaves", model.header().n_leaves},
                          {"bytes", model.file_size()},
                          {"diagonal", diagonal}};
    if (!truth.empty()) {
        for (const auto& [key, sum] : {std::pair{"k1_rms", s.sq_k1}, std::pair{"k2_rms", s.sq_k2},
                                       std::pair{"mean_curvature_rms", s.sq_mean}}) {
            out[key] = rms(sum, hits);
            out[std::string(key) + "_x_diagonal"] = rms(sum, hits, 1 / diagonal);
        }
    }
    return out;
}

}  // namespace

nlohmann::json run_measure(const MeasureConfig& config, StageContext& context) {
    if (input_kind(config.cloud) == InputKind::model &&
        input_kind(config.model) == InputKind::cloud)
        throw ConfigError(fmt::format(
            "{0} is a cloud and {1} a model: expected the model first: slim measure {1} {0}",
            config.model, config.cloud));
    require_model(config.model);
    std::string truth = config.truth;
    if (truth.empty() && std::filesystem::exists(truth_path(config.cloud)))
        truth = truth_path(config.cloud);
    if (config.output.empty()) return measured(config, truth, context);
    refuse_to_overwrite(config.output, {config.model, config.cloud, truth});
    Stamp stamp(context, manifest_path(config.output));
    stamp.input(config.model);
    stamp.input(config.cloud);
    if (!truth.empty()) stamp.input(truth);
    if (auto done = stamp.up_to_date()) return *done;
    nlohmann::json result = measured(config, truth, context);
    write_file_atomically(config.output, text_of(result, 2) + "\n");
    return stamp.commit({config.output}, std::move(result));
}

}  // namespace slim
