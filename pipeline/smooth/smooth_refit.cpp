#include "pipeline/smooth/smooth_refit.h"

#include "pipeline/build/each_chunk.h"
#include "pipeline/median.h"
#include "pipeline/memory_size.h"
#include "slim/neighbors/point_pyramid.h"
#include "slim/smooth/cloud_sample.h"
#include "slim/smooth/refit_budget.h"
#include "slim/smooth/sheet_sides.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace slim {
namespace {

constexpr std::uint64_t kSeed = 0;

CloudSample read_sample(const SmoothInput& input, std::size_t most, StageContext& context) {
    CloudSampler sampler(most, kSeed);
    for_each_chunk({input.cloud}, context.reporter, "refit",
                   [&](const PointChunk& chunk, std::uint64_t, std::size_t, const CloudInfo&) {
                       sampler.add(chunk.position, chunk.normal, input.origin);
                       context.check_stop();
                   });
    return sampler.take();
}

std::vector<LeafNoise> noise_of_leaves(const SmoothInput& input) {
    std::vector<LeafNoise> noise(input.index.n_leaves());
    for (std::size_t i = 0; i < noise.size(); ++i) {
        const TreeNode& node = input.tree.node(input.index.node(i));
        noise[i] = {node.fit_error, static_cast<double>(node.n_points)};
    }
    return noise;
}

void count_known(const std::vector<WideRadius>& radii, const std::vector<double>& sq_noise,
                 double diagonal, SmoothRefit& out) {
    std::vector<double> known;
    for (std::size_t i = 0; i < radii.size(); ++i) {
        if (!radii[i].in_cloud) continue;
        if (std::isfinite(sq_noise[i]))
            known.push_back(std::sqrt(sq_noise[i]));
        else
            ++out.unknown;
    }
    out.known = known.size();
    if (!known.empty()) out.noise = median(std::move(known)) / diagonal;
}

/// points: along the curve
CoordinateSteps steps_of(const PointBlock& points) {
    std::vector<std::uint32_t> samples;
    const std::size_t stride = points.size() / kStepSamples + 1;
    for (std::size_t i = 0; i < points.size(); i += stride)
        samples.push_back(static_cast<std::uint32_t>(i));
    return coordinate_steps(NearestSearch(points.position), samples);
}

/// Fits anew, unless `most_fits` is zero, and judges how much the fits, or else the model's own
/// surface, are to be trusted with.
void fit_anew(const SmoothInput& input, CloudSample sample, std::size_t most_fits,
              StageContext& context, SmoothRefit& out) {
    const auto telling = [&context](const char* what) {
        return [&context, what](std::size_t done, std::size_t total) {
            context.reporter.progress(what, done, total);
            context.check_stop();
        };
    };
    Bbox box;
    for (const Vec3d& p : sample.points.position) box.extend(p);
    sort_along_curve(sample.points, box);
    const BallIndex& model = input.index;
    tell_sheets_apart(model, sample.points);
    const PointPyramid points(sample.points, box, kSeed, sample.share);
    const std::vector<LeafNoise> noise = noise_of_leaves(input);
    out.share = sample.share;
    std::vector<WideRadius> radii =
        most_fits == 0 ? kept_radii(model, noise, points)
                       : wide_radii(model, noise, points, input.diagonal, telling("radii"));
    if (most_fits > 0) {
        out.kept_for_memory = keep_costly_leaves(model, most_fits, radii);
        out.refitted = static_cast<std::size_t>(std::count_if(
            radii.begin(), radii.end(), [](const WideRadius& r) { return r.radius > 0; }));
        out.surface =
            std::make_unique<RefittedSurface>(model, noise, radii, points, telling("fits"));
        out.stray = out.surface->n_strays();
        out.kept = radii.size() - out.refitted - out.stray;
    }
    const std::vector<double> sq_noise =
        local_noise(model, noise, radii, points, steps_of(sample.points));
    out.trust =
        leaf_trust(model, radii, sq_noise, out.surface ? out.surface->fits() : model, points);
    count_known(radii, sq_noise, input.diagonal, out);
}

/// Says what there was no memory for.
void warn_of_memory(const SmoothRefit& refit, const RefitBudget& budget, const SmoothInput& input,
                    Reporter& reporter) {
    if (refit.kept_for_memory > 0)
        reporter.warn(
            fmt::format("{} of {} leaves are not fitted anew, for memory ({}): points there go on "
                        "the model's own surface; a larger "
                        "--memory helps",
                        refit.kept_for_memory, input.index.n_leaves(), input.memory));
    if (budget.points == 0)
        reporter.warn(
            fmt::format("no point fits in memory ({}): how noisy they are is not known, they go "
                        "all the way to the surface; a larger "
                        "--memory helps",
                        input.memory));
    else if (refit.share < 1 && budget.points < kMostSmoothPoints)
        reporter.warn(fmt::format(
            "only {:.3g} of the points {}, for memory ({}): what they are too sparse to show of "
            "the shape may count as noise; a larger --memory helps",
            refit.share,
            refit.kept_for_memory == input.index.n_leaves() ? "are asked how noisy they are"
                                                            : "are fitted to",
            input.memory));
}

}  // namespace

nlohmann::json SmoothRefit::counts() const {
    return {{"leaves_refitted", refitted},
            {"leaves_kept", kept},
            {"leaves_kept_for_memory", kept_for_memory},
            {"leaves_stray", stray},
            {"refit_share", share},
            {"noise", known > 0 ? nlohmann::json(noise) : nlohmann::json()},
            {"leaves_noise_unknown", unknown}};
}

SmoothRefit refit_cloud(const SmoothInput& input, StageContext& context) {
    SmoothRefit out;
    out.kept = input.index.n_leaves();
    const RefitBudget budget = refit_budget(parse_memory_size(input.memory), out.kept);
    const bool too_many = out.kept > budget.leaves;
    if (too_many) out.kept_for_memory = out.kept;
    if (budget.points == 0) out.share = 0;
    out.batch = budget.batch;
    if (budget.points > 0)
        if (CloudSample sample = read_sample(input, budget.points, context); !sample.points.empty())
            fit_anew(input, std::move(sample), too_many ? 0 : budget.fits, context, out);
    warn_of_memory(out, budget, input, context.reporter);
    return out;
}

void say_what_is_known(const nlohmann::json& result, double diagonal, const std::string& model,
                       const std::string& cloud, Reporter& reporter) {
    const auto count = [&result](const char* key) { return result.value(key, std::size_t{0}); };
    const std::size_t leaves =
        count("leaves_kept") + count("leaves_refitted") + count("leaves_stray");
    const bool known = result.at("noise").is_number();
    if (const std::size_t unknown = count("leaves_noise_unknown"); unknown > 0)
        reporter.warn(
            fmt::format("{}: too few points to tell noise from shape about {} of {} leaves of {}: "
                        "points there go all the way to the "
                        "surface, be they noisy or not; --most limits how far",
                        cloud, unknown, leaves, model));
    const std::size_t moved = count("moved"), held = count("points_held_back");
    // Where memory left leaves as they were, it is that; the warning of it has said so.
    if (!known || 2 * held <= moved || count("leaves_kept_for_memory") > 0) return;
    const double noise = result.at("noise").get<double>();
    reporter.info(
        fmt::format("{} of {} points went only part of the way (points_held_back): {} is farther "
                    "from them than their noise explains, {:.2g} of L ({:.2g} in the cloud's unit) "
                    "in the median leaf, as of a clean cloud, beside edges, or where neighbours "
                    "share their noise, which stays. Single points may go farther than that "
                    "(max_displacement): --most limits it, a model with a smaller --t-mdl lies "
                    "nearer",
                    held, moved, model, noise, noise * diagonal));
}

}  // namespace slim
