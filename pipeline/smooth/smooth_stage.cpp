#include "pipeline/smooth/smooth_stage.h"

#include "formats/cloud_rewriter.h"
#include "formats/model_file.h"
#include "formats/point_source.h"
#include "pipeline/build/cloud_survey.h"
#include "pipeline/input_kind.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "pipeline/measure/apart.h"
#include "pipeline/measure/mesh_input.h"
#include "pipeline/memory_size.h"
#include "pipeline/smooth/smooth_refit.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"
#include "slim/smooth/feature_edges.h"
#include "slim/smooth/refit_budget.h"
#include "slim/smooth/smoothing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// What coordinates in text are rounded to, over the diagonal: a hundredth of a float's step.
constexpr double kTextStep = 1e-9;

/// What is counted over the points, in file order.
struct Counts {
    std::uint64_t points = 0, moved = 0, unsupported = 0, held = 0, opposed = 0, astray = 0,
                  not_finite = 0;
    std::uint64_t by_model = 0, held_back = 0, kept = 0;
    double sq_displacement = 0, max = 0;
    Bbox box;  // of the finite points as they were, frame of the job

    void add(const Vec3d& from, const SmoothedPoint& p) {
        ++points;
        if (is_finite(from)) box.extend(from);
        if (!p.moved) {
            ++(!is_finite(p.position) ? not_finite
               : p.held               ? held
               : p.held_back          ? kept
                                      : unsupported);
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

/// A model opened for smoothing, and how.
struct Smoother {
    const SmoothConfig& config;
    StageContext& context;
    const SurfelTree& tree;
    const BallIndex& index;
    Vec3d origin;
    double diagonal;
    bool sharp;             // built with --sharp on
    SmoothModelRules rules; // of a build without

    double text_step() const { return kTextStep * diagonal; }
    SmoothSettings settings() const { return {config.iterations, config.amount, config.most}; }
    /// World position; a point that stays keeps the bytes of its coordinates.
    RewrittenPoint rewritten(const SmoothedPoint& p) const {
        return {p.position + origin, to_float(p.normal), static_cast<float>(p.displacement),
                p.moved};
    }
};

/// Points of a cloud that are smoothed together, and where they end.
class SmoothedBatch {
public:
    /// most: points that it is smoothed with; the last chunk may be above.
    explicit SmoothedBatch(std::size_t most) {
        from_.reserve(most + kChunkPoints), normals_.reserve(most + kChunkPoints);
    }
    std::size_t size() const { return from_.size(); }
    void add(const Smoother& smoother, const PointChunk& chunk) {
        for (const Vec3d& p : chunk.position) from_.push_back(p - smoother.origin);
        normals_.insert(normals_.end(), chunk.normal.begin(), chunk.normal.end());
    }
    void smooth(const SmoothSurface& surface, const Smoother& smoother) {
        points_.resize(from_.size());
        smooth_points(surface, smoother.settings(), from_, normals_, points_);
    }
    void write(const Smoother& smoother, Counts& counts, CloudRewriter& out) const {
        constexpr std::size_t kPiece = 4096;
        std::vector<RewrittenPoint> piece;
        for (std::size_t i = 0; i < from_.size();) {
            piece.clear();
            for (const std::size_t end = std::min(i + kPiece, from_.size()); i < end; ++i) {
                counts.add(from_[i], points_[i]);
                piece.push_back(smoother.rewritten(points_[i]));
            }
            out.write(piece);
        }
    }
    void clear() { from_.clear(), normals_.clear(), points_.clear(); }

private:
    std::vector<Vec3d> from_;     // frame of the job
    std::vector<Vec3f> normals_;  // of each, or none
    std::vector<SmoothedPoint> points_;
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

json smooth_cloud(const Smoother& smoother) {
    const SmoothConfig& config = smoother.config;
    const SmoothRefit refit = refit_cloud({config.cloud, config.memory, smoother.tree,
                                           smoother.index, smoother.origin, smoother.diagonal},
                                          smoother.context);
    const SmoothSurface surface{smoother.index, refit.surface.get(), refit.trust};
    const auto out = rewrite_cloud(config.cloud, config.output, smoother.text_step());
    Counts counts;
    SmoothedBatch done(refit.batch), next(refit.batch);
    // One thread alone counts and writes a batch: while the next one is smoothed.
    const auto take_turn = [&] {
        run_both([&] { done.write(smoother, counts, *out); },
                 [&] { next.smooth(surface, smoother); });
        std::swap(done, next);
        next.clear();
    };
    for_each_chunk({config.cloud}, smoother.context.reporter, "smooth",
                   [&](const PointChunk& chunk, std::uint64_t, std::size_t, const CloudInfo&) {
                       next.add(smoother, chunk);
                       if (next.size() >= refit.batch) take_turn();
                       smoother.context.check_stop();
                   });
    take_turn();
    done.write(smoother, counts, *out);
    require_moved(smoother, counts);
    out->commit();
    json result = counts.to_json("points");
    result["opposed"] = counts.opposed;
    result["astray"] = counts.astray;
    result["points_by_model"] = counts.by_model;
    result["points_held_back"] = counts.held_back;
    result.update(refit.counts());
    return result;
}

/// The share of the mesh at feature edges that the model rounds off, and the advice where there are
/// any; null: a model with sharp leaves, which follows them.
json edges_rounded_off(const Smoother& smoother, const Mesh& mesh) {
    if (smoother.sharp) return nullptr;
    const EdgesSeen seen = feature_edges(mesh, smoother.rules);
    smoother.context.check_stop();
    if (seen.are_features())
        smoother.context.reporter.info(
            fmt::format("about {:.0f} % of {} lies at edges, which {} rounds off: a model built "
                        "with --sharp on keeps them crisp",
                        100 * seen.share(), smoother.config.cloud, smoother.config.model));
    return seen.share();
}

json smooth_faces(const Smoother& smoother) {
    const SmoothConfig& config = smoother.config;
    const auto n_steps = static_cast<std::uint64_t>(config.iterations);
    Mesh mesh = read_mesh(config.cloud, smoother.origin);
    const std::vector<Vec3d> from = mesh.position;
    const json edges = edges_rounded_off(smoother, mesh);
    const auto out = rewrite_cloud(config.cloud, config.output, smoother.text_step());
    const SmoothedMesh smoothed =
        smooth_mesh(smoother.index, smoother.settings(), mesh, [&](int i) {
            smoother.context.reporter.progress("iterations", static_cast<std::uint64_t>(i),
                                               n_steps);
            smoother.context.check_stop();
        });
    Counts counts;
    std::vector<RewrittenPoint> rewritten;
    for (std::size_t i = 0; i < smoothed.vertices.size(); ++i) {
        counts.add(from[i], smoothed.vertices[i]);
        rewritten.push_back(smoother.rewritten(smoothed.vertices[i]));
    }
    if (smoothed.faces_unsupported == mesh.n_faces() || counts.points == counts.not_finite)
        require_moved(smoother, counts);
    out->write(rewritten);
    out->commit();
    if (2 * counts.held > counts.points)
        smoother.context.reporter.warn(
            fmt::format("{} of {} vertices are on boundaries and stay: do faces share no vertices? "
                        "weld them, or use "
                        "--mode points",
                        counts.held, counts.points));
    if (smoothed.turned.turned > 0)
        smoother.context.reporter.info(
            fmt::format("{} faces would have turned over: {} vertices go a share of their way, {} "
                        "stay",
                        smoothed.turned.turned, smoothed.turned.n_held_back - counts.kept,
                        counts.kept));
    json result = counts.to_json("mesh");
    if (!edges.is_null()) result["at_edges"] = edges;
    result["faces"] = mesh.n_faces();
    result["faces_unsupported"] = smoothed.faces_unsupported;
    result["faces_turned"] = smoothed.turned.turned;
    result["vertices_held_back"] = smoothed.turned.n_held_back;
    result["vertices_kept"] = counts.kept;
    result["held"] = counts.held;
    return result;
}

void check_paths(const SmoothConfig& config) {
    if (input_kind(config.cloud) == InputKind::model &&
        input_kind(config.model) == InputKind::cloud)
        throw ConfigError(fmt::format(
            "{0} is a cloud and {1} a model: expected the model first: slim smooth {1} {0} -o {2}",
            config.model, config.cloud, config.output));
    if (parse_memory_size(config.memory) < kLeastSmoothMemory)
        throw ConfigError("--memory " + config.memory + ": expected at least " +
                          memory_size_text(kLeastSmoothMemory));
    require_model(config.model);
    refuse_to_overwrite(config.output, {config.model, config.cloud});
}

/// What the model's record says that it was fitted with; empty where it does not say.
json rules_of(const ModelFile& model) {
    const json provenance = json_or_discarded(model.provenance_json());
    const json rules =
        provenance.is_object() ? provenance.value("rules", json::object()) : json::object();
    return rules.is_object() ? rules : json::object();
}

SmoothModelRules smooth_rules(const ModelHeader& header, const json& rules) {
    return {.degree = header.degree,
            .choose_degree = rules.value("choose_degree", false),
            .mdl_threshold = header.mdl_threshold,
            .diagonal = header.diagonal,
            .noise_variance = header.noise_variance,
            .contrary_share = rules.value("contrary_share", 0.0),
            .spacing = rules.value("spacing", 0.0)};
}

json smoothed(const SmoothConfig& config, StageContext& context) {
    const ModelFile model = ModelFile::open(config.model);
    const SurfelTree tree = model.tree();
    const BallIndex index(tree);
    const bool has_faces = is_mesh(config.cloud);
    if (config.mode == "mesh" && !has_faces)
        throw DataError(config.cloud +
                        ": has no faces that name their corners; expected a mesh for "
                        "--mode mesh");
    const json rules = rules_of(model);
    const Smoother smoother{config,
                            context,
                            tree,
                            index,
                            model.header().origin,
                            model.header().diagonal,
                            rules.value("sharp", false) || !tree.sharp().empty(),
                            smooth_rules(model.header(), rules)};
    const bool as_mesh = has_faces && config.mode != "points";
    json result = as_mesh ? smooth_faces(smoother) : smooth_cloud(smoother);
    const bool lost = warn_of_lost(config.cloud, config.model, result.at("unsupported"),
                                   result.at("points"), context.reporter);
    if (!lost && !as_mesh)
        say_what_is_known(result, smoother.diagonal, config.model, config.cloud, context.reporter);
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
