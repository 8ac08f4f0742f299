#include "pipeline/smooth_stage.h"

#include "formats/cloud_rewriter.h"
#include "formats/model_file.h"
#include "formats/point_source.h"
#include "pipeline/apart.h"
#include "pipeline/input_kind.h"
#include "pipeline/manifest.h"
#include "pipeline/memory_size.h"
#include "pipeline/mesh_input.h"
#include "slim/base/error.h"
#include "slim/neighbors/point_pyramid.h"
#include "slim/smooth/cloud_sample.h"
#include "slim/smooth/local_noise.h"
#include "slim/smooth/refit.h"
#include "slim/smooth/refit_budget.h"
#include "slim/smooth/smoothing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kChunk = 1 << 16;
/// What coordinates in text are rounded to, over the diagonal: a hundredth of a float's step.
constexpr double kTextStep = 1e-9;

/// What is counted over the points, in file order.
struct Counts {
    std::uint64_t points = 0, moved = 0, unsupported = 0, held = 0, opposed = 0, astray = 0, not_finite = 0;
    std::uint64_t by_model = 0, held_back = 0;
    double sq_displacement = 0, max = 0;
    Bbox box;  // of the finite points as they were, frame of the job

    void add(const Vec3d& from, const SmoothedPoint& p) {
        ++points;
        if (is_finite(from)) box.extend(from);
        if (!p.moved) {
            ++(!is_finite(p.position) ? not_finite : p.held ? held : unsupported);
            return;
        }
        ++moved;
        opposed += p.opposed ? 1 : 0, astray += p.astray ? 1 : 0;
        by_model += p.by_model ? 1 : 0, held_back += p.held_back ? 1 : 0;
        sq_displacement += p.displacement * p.displacement;
        max = std::max(max, std::abs(p.displacement));
    }
    json to_json(const char* mode) const {
        const double n = static_cast<double>(moved);
        return {{"mode", mode},
                {"points", points},
                {"moved", moved},
                {"unsupported", unsupported},
                {"not_finite", not_finite},
                {"rms_displacement", moved > 0 ? json(std::sqrt(sq_displacement / n)) : json()},
                {"max_displacement", moved > 0 ? json(max) : json()}};
    }
};

constexpr std::uint64_t kSeed = 0;

CloudSample read_sample(const std::string& path, const Vec3d& origin, std::size_t most, StageContext& context) {
    CloudSampler sampler(most, kSeed);
    const auto source = open_cloud(path);
    PointChunk chunk;
    while (source->read(chunk, kChunk)) {
        sampler.add(chunk.position, chunk.normal, origin);
        context.reporter.progress("refit", source->bytes_read(), source->info().file_size);
        context.check_stop();
    }
    return sampler.take();
}

/// Leaves that were fitted anew, and those that stay.
struct LeafCounts {
    std::size_t refitted = 0, kept = 0, kept_for_memory = 0;
    double share = 1;  ///< of the cloud's points that the others were fitted to
};

/// What a cloud is put on beside the model.
struct Anew {
    std::unique_ptr<RefittedSurface> surface;  ///< null: there is no memory for it
    std::vector<LeafTrust> trust;
};

/// The model's surface fitted anew to the cloud that is smoothed, unless `most_fits` is zero, and how much it, or else the
/// model's own, is to be trusted with.
Anew fitted_anew(const SurfelTree& tree, const BallIndex& model, double diagonal, CloudSample sample,
                 std::size_t most_fits, StageContext& context, LeafCounts& counts) {
    const auto telling = [&context](const char* what) {
        return [&context, what](std::size_t done, std::size_t total) {
            context.reporter.progress(what, done, total);
            context.check_stop();
        };
    };
    Bbox box;
    for (const Vec3d& p : sample.points.position) box.extend(p);
    sort_along_curve(sample.points, box);
    const PointPyramid points(sample.points, box, kSeed, sample.share);
    std::vector<LeafNoise> noise(model.n_leaves());
    for (std::size_t i = 0; i < noise.size(); ++i) {
        const TreeNode& node = tree.node(model.node(i));
        noise[i] = {node.fit_error, static_cast<double>(node.n_points)};
    }
    counts.share = sample.share;
    Anew out;
    if (most_fits == 0) {
        const std::vector<WideRadius> kept = kept_radii(model, noise, points);
        out.trust = leaf_trust(model, kept, local_noise(model, noise, kept, points), model, points);
        return out;
    }
    std::vector<WideRadius> radii = wide_radii(model, noise, points, diagonal, telling("radii"));
    counts.kept_for_memory = keep_costly_leaves(model, most_fits, radii);
    counts.refitted = static_cast<std::size_t>(std::count_if(radii.begin(), radii.end(), [](const WideRadius& r) { return r.radius > 0; }));
    counts.kept = radii.size() - counts.refitted;
    out.surface = std::make_unique<RefittedSurface>(model, noise, radii, points, telling("fits"));
    out.trust = leaf_trust(model, radii, local_noise(model, noise, radii, points), out.surface->fits(), points);
    return out;
}

/// A model opened for smoothing, and how.
struct Smoother {
    const SmoothConfig& config;
    StageContext& context;
    const SurfelTree& tree;
    const BallIndex& index;
    Vec3d origin;
    double diagonal;

    double text_step() const { return kTextStep * diagonal; }
    SmoothSettings settings() const { return {config.iterations, config.amount, config.most}; }
    /// World position; a point that stays keeps the bytes of its coordinates.
    RewrittenPoint rewritten(const SmoothedPoint& p) const {
        return {p.position + origin, to_float(p.normal), static_cast<float>(p.displacement), p.moved};
    }
};

/// Nothing is written where the model says nothing of any point.
void require_moved(const Smoother& smoother, const Counts& counts) {
    const std::string& cloud = smoother.config.cloud;
    if (counts.points == counts.not_finite) throw DataError(cloud + ": no finite point to smooth");
    if (counts.moved > 0 || counts.unsupported == 0) return;
    const Bbox world{counts.box.lo + smoother.origin, counts.box.hi + smoother.origin};
    refuse_apart({cloud, world}, placed(smoother.config.model, smoother.tree.header()),
                 counts.points - counts.not_finite);
}

/// Says what there was no memory for.
void warn_of_memory(const LeafCounts& leaves, const RefitBudget& budget, const Smoother& smoother) {
    Reporter& reporter = smoother.context.reporter;
    const std::string& memory = smoother.config.memory;
    if (leaves.kept_for_memory > 0)
        reporter.warn(fmt::format(
            "{} of {} leaves are not fitted anew, for memory ({}): points there go on the model's own surface; a larger "
            "--memory helps",
            leaves.kept_for_memory, smoother.index.n_leaves(), memory));
    if (budget.points == 0)
        reporter.warn(fmt::format(
            "no point fits in memory ({}): how noisy they are is not known, they go all the way to the surface; a larger "
            "--memory helps",
            memory));
    else if (leaves.share < 1 && budget.points < kMostSmoothPoints)
        reporter.warn(fmt::format(
            "only {:.3g} of the points are fitted to, for memory ({}): what they are too sparse to show of the shape may "
            "count as noise; a larger --memory helps",
            leaves.share, memory));
}

json smooth_cloud(const Smoother& smoother) {
    const SmoothConfig& config = smoother.config;
    Anew anew;
    LeafCounts leaves;
    leaves.kept = smoother.index.n_leaves();
    const RefitBudget budget = refit_budget(parse_memory_size(config.memory), leaves.kept);
    const bool too_many = leaves.kept > budget.leaves;
    if (too_many) leaves.kept_for_memory = leaves.kept;
    if (budget.points == 0) leaves.share = 0;
    if (budget.points > 0)
        if (CloudSample sample = read_sample(config.cloud, smoother.origin, budget.points, smoother.context);
            !sample.points.empty())
            anew = fitted_anew(smoother.tree, smoother.index, smoother.diagonal, std::move(sample),
                               too_many ? 0 : budget.fits, smoother.context, leaves);
    warn_of_memory(leaves, budget, smoother);
    const SmoothSurface surface{smoother.index, anew.surface.get(), anew.trust};
    const auto source = open_cloud(config.cloud);
    const auto out = rewrite_cloud(config.cloud, config.output, smoother.text_step());
    Counts counts;
    PointChunk chunk;
    std::vector<SmoothedPoint> smoothed;
    std::vector<RewrittenPoint> rewritten;
    while (source->read(chunk, kChunk)) {
        for (Vec3d& p : chunk.position) p -= smoother.origin;
        smoothed.resize(chunk.size());
        smooth_points(surface, smoother.settings(), chunk.position, chunk.normal, smoothed);
        rewritten.clear();
        for (std::size_t i = 0; i < smoothed.size(); ++i) {
            counts.add(chunk.position[i], smoothed[i]);
            rewritten.push_back(smoother.rewritten(smoothed[i]));
        }
        out->write(rewritten);
        smoother.context.reporter.progress("smooth", source->bytes_read(), source->info().file_size);
        smoother.context.check_stop();
    }
    require_moved(smoother, counts);
    out->commit();
    json result = counts.to_json("points");
    result["opposed"] = counts.opposed;
    result["astray"] = counts.astray;
    result["points_by_model"] = counts.by_model;
    result["points_held_back"] = counts.held_back;
    result["leaves_refitted"] = leaves.refitted;
    result["leaves_kept"] = leaves.kept;
    result["leaves_kept_for_memory"] = leaves.kept_for_memory;
    result["refit_share"] = leaves.share;
    return result;
}

json smooth_faces(const Smoother& smoother) {
    const SmoothConfig& config = smoother.config;
    const auto n_steps = static_cast<std::uint64_t>(config.iterations);
    Mesh mesh = read_mesh(config.cloud, smoother.origin);
    const std::vector<Vec3d> from = mesh.position;
    const auto out = rewrite_cloud(config.cloud, config.output, smoother.text_step());
    const SmoothedMesh smoothed =
        smooth_mesh(smoother.index, smoother.settings(), mesh, [&](int i) {
            smoother.context.reporter.progress("iterations", static_cast<std::uint64_t>(i), n_steps);
            smoother.context.check_stop();
        });
    Counts counts;
    std::vector<RewrittenPoint> rewritten;
    for (std::size_t i = 0; i < smoothed.vertices.size(); ++i) {
        counts.add(from[i], smoothed.vertices[i]);
        rewritten.push_back(smoother.rewritten(smoothed.vertices[i]));
    }
    if (smoothed.faces_unsupported == mesh.n_faces() || counts.points == counts.not_finite) require_moved(smoother, counts);
    out->write(rewritten);
    out->commit();
    if (2 * counts.held > counts.points)
        smoother.context.reporter.warn(fmt::format(
            "{} of {} vertices are on boundaries and stay: do faces share no vertices? weld them, or use "
            "--mode points", counts.held, counts.points));
    json result = counts.to_json("mesh");
    result["faces"] = mesh.n_faces();
    result["faces_unsupported"] = smoothed.faces_unsupported;
    result["held"] = counts.held;
    return result;
}

void check_paths(const SmoothConfig& config) {
    if (input_kind(config.cloud) == InputKind::model && input_kind(config.model) == InputKind::cloud)
        throw ConfigError(fmt::format(
            "{0} is a cloud and {1} a model: expected the model first: slim smooth {1} {0} -o {2}",
            config.model, config.cloud, config.output));
    if (parse_memory_size(config.memory) < kLeastSmoothMemory)
        throw ConfigError("--memory " + config.memory + ": expected at least " + memory_size_text(kLeastSmoothMemory));
    require_model(config.model);
    refuse_to_overwrite(config.output, {config.model, config.cloud});
}

json smoothed(const SmoothConfig& config, StageContext& context) {
    const ModelFile model = ModelFile::open(config.model);
    const SurfelTree tree = model.tree();
    const BallIndex index(tree);
    const bool has_faces = is_mesh(config.cloud);
    if (config.mode == "mesh" && !has_faces)
        throw DataError(config.cloud + ": has no faces that name their corners; expected a mesh for "
                                       "--mode mesh");
    const Smoother smoother{config, context, tree, index, model.header().origin, model.header().diagonal};
    const bool as_mesh = has_faces && config.mode != "points";
    json result = as_mesh ? smooth_faces(smoother) : smooth_cloud(smoother);
    const auto n = result.at("points").get<std::uint64_t>();
    const auto lost = result.at("unsupported").get<std::uint64_t>();
    if (2 * lost > n)
        context.reporter.warn(fmt::format(
            "{}: {} of its {} points lie in no surfel's support of {}: are they in the same frame?",
            config.cloud, lost, n, config.model));
    else if (const auto kept = result.value("leaves_kept", std::size_t{0}) -
                                    result.value("leaves_kept_for_memory", std::size_t{0});
             2 * kept > index.n_leaves())
        context.reporter.info(fmt::format(
            "{} of {} leaves of {} are used as they were built: fits made anew of {} would be no nearer there, as is "
            "usual for a clean cloud, few points or edges. Where their noise is known points move no farther than it lets "
            "expect. Nothing need be done unless they move farther than you want: build the model with a smaller --t-mdl then",
            kept, index.n_leaves(), config.model, config.cloud));
    return result;
}

}  // namespace

json run_smooth(const SmoothConfig& config, StageContext& context) {
    check_paths(config);
    Stamp stamp(context, manifest_path(config.output));
    stamp.input(config.model);
    stamp.input(config.cloud);
    stamp.outputs({config.output});
    if (auto done = stamp.up_to_date()) return *done;
    json result = smoothed(config, context);
    return stamp.commit(std::move(result));
}

}  // namespace slim
