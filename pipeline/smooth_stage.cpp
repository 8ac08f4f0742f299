#include "pipeline/smooth_stage.h"

#include "formats/cloud_rewriter.h"
#include "formats/model_file.h"
#include "formats/point_source.h"
#include "pipeline/input_kind.h"
#include "pipeline/manifest.h"
#include "pipeline/mesh_input.h"
#include "slim/base/error.h"
#include "slim/neighbors/point_pyramid.h"
#include "slim/smooth/refit.h"
#include "slim/smooth/smoothing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kChunk = 1 << 18;
/// What coordinates in text are rounded to, over the diagonal: a hundredth of a float's step.
constexpr double kTextStep = 1e-9;

/// What is counted over the points, in file order.
struct Counts {
    std::uint64_t points = 0, moved = 0, unsupported = 0, held = 0, opposed = 0, astray = 0, not_finite = 0;
    double sq_displacement = 0, max = 0;

    void add(const SmoothedPoint& p) {
        ++points;
        if (!p.moved) {
            ++(!is_finite(p.position) ? not_finite : p.held ? held : unsupported);
            return;
        }
        ++moved;
        opposed += p.opposed ? 1 : 0, astray += p.astray ? 1 : 0;
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

/// Most points that the surface is fitted anew to; of a larger cloud a random share. 90 bytes each.
constexpr std::size_t kMostRefit = std::size_t{1} << 22;
/// Most leaves of a model that is fitted anew: about 3 kB each.
constexpr std::size_t kMostLeaves = std::size_t{1} << 19;
constexpr std::uint64_t kSeed = 0;

/// A cloud's finite points, frame of the model, or a random share of them.
struct Sample {
    PointBlock points;
    double share = 1;
};

void thin(Sample& sample) {
    PointBlock& p = sample.points;
    sample.share /= 2;
    std::size_t n = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
        if (!in_share(kSeed, p.id[i], sample.share)) continue;
        p.position[n] = p.position[i], p.id[n] = p.id[i];
        if (p.has_normals()) p.normal[n] = p.normal[i];
        ++n;
    }
    p.position.resize(n), p.id.resize(n);
    if (p.has_normals()) p.normal.resize(n);
}

Sample read_sample(const std::string& path, const Vec3d& origin, StageContext& context) {
    Sample out;
    PointBlock& p = out.points;
    const auto source = open_cloud(path);
    PointChunk chunk;
    std::uint64_t id = 0;
    while (source->read(chunk, kChunk)) {
        for (std::size_t i = 0; i < chunk.size(); ++i, ++id) {
            const Vec3d at = chunk.position[i] - origin;
            if (!is_finite(at) || !in_share(kSeed, id, out.share)) continue;
            p.position.push_back(at), p.id.push_back(id);
            if (chunk.normal.empty()) continue;
            const Vec3d n = to_double(chunk.normal[i]);
            p.normal.push_back(is_finite(n) && sq_length(n) > 0 ? to_float(normalized(n)) : Vec3f{});
        }
        if (p.size() > kMostRefit) thin(out);
        context.reporter.progress("refit", source->bytes_read(), source->info().file_size);
        context.check_stop();
    }
    return out;
}

/// Leaves that were fitted anew, and those that stay.
struct LeafCounts {
    std::size_t refitted = 0, kept = 0;
};

/// The model's surface fitted anew to the cloud that is smoothed.
RefittedSurface refitted(const SurfelTree& tree, const BallIndex& model, double diagonal, Sample sample,
                         StageContext& context, LeafCounts& counts) {
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
    const std::vector<double> radii = wide_radii(model, noise, points, diagonal, telling("radii"));
    counts.refitted = static_cast<std::size_t>(std::count_if(radii.begin(), radii.end(), [](double r) { return r > 0; }));
    counts.kept = radii.size() - counts.refitted;
    return {model, noise, radii, points, telling("fits")};
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

json smooth_cloud(const Smoother& smoother) {
    const SmoothConfig& config = smoother.config;
    std::optional<RefittedSurface> anew;
    LeafCounts leaves{0, smoother.index.n_leaves()};
    if (smoother.index.n_leaves() > kMostLeaves) {
        smoother.context.reporter.warn(fmt::format(
            "{} leaves: more than {} are not fitted anew, for memory; the points go on the model as it is",
            smoother.index.n_leaves(), kMostLeaves));
    } else if (Sample sample = read_sample(config.cloud, smoother.origin, smoother.context); !sample.points.empty()) {
        anew.emplace(refitted(smoother.tree, smoother.index, smoother.diagonal, std::move(sample), smoother.context,
                              leaves));
    }
    const SmoothSurface surface{smoother.index, anew ? &*anew : nullptr};
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
        for (const SmoothedPoint& p : smoothed) {
            counts.add(p);
            rewritten.push_back(smoother.rewritten(p));
        }
        out->write(rewritten);
        smoother.context.reporter.progress("smooth", source->bytes_read(), source->info().file_size);
        smoother.context.check_stop();
    }
    if (counts.points == counts.not_finite)
        throw DataError(config.cloud + ": no finite point to smooth");
    out->commit();
    json result = counts.to_json("points");
    result["opposed"] = counts.opposed;
    result["astray"] = counts.astray;
    result["leaves_refitted"] = leaves.refitted;
    result["leaves_kept"] = leaves.kept;
    return result;
}

json smooth_faces(const Smoother& smoother) {
    const SmoothConfig& config = smoother.config;
    const auto n_steps = static_cast<std::uint64_t>(config.iterations);
    Mesh mesh = read_mesh(config.cloud, smoother.origin);
    const auto out = rewrite_cloud(config.cloud, config.output, smoother.text_step());
    const SmoothedMesh smoothed =
        smooth_mesh(smoother.index, smoother.settings(), mesh, [&](int i) {
            smoother.context.reporter.progress("iterations", static_cast<std::uint64_t>(i), n_steps);
            smoother.context.check_stop();
        });
    Counts counts;
    std::vector<RewrittenPoint> rewritten;
    for (const SmoothedPoint& p : smoothed.vertices) {
        counts.add(p);
        rewritten.push_back(smoother.rewritten(p));
    }
    if (counts.points == counts.not_finite)
        throw DataError(config.cloud + ": no finite point to smooth");
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
    else if (const auto kept = result.value("leaves_kept", std::size_t{0}); 2 * kept > index.n_leaves())
        context.reporter.warn(fmt::format(
            "{} of {} leaves of {} were not fitted anew: points there get the model's own error, which may be more "
            "than their noise; build with a smaller --t-mdl if so", kept, index.n_leaves(), config.model));
    return result;
}

}  // namespace

json run_smooth(const SmoothConfig& config, StageContext& context) {
    check_paths(config);
    Stamp stamp(context, manifest_path(config.output));
    stamp.input(config.model);
    stamp.input(config.cloud);
    if (auto done = stamp.up_to_date()) return *done;
    json result = smoothed(config, context);
    return stamp.commit({config.output}, std::move(result));
}

}  // namespace slim
