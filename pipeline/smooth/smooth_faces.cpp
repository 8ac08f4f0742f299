#include "pipeline/smooth/smooth_faces.h"

#include "pipeline/measure/mesh_input.h"

#include <fmt/format.h>

#include <cstdint>
#include <vector>

namespace slim {
namespace {

using nlohmann::json;

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

}  // namespace

json smooth_faces(const Smoother& smoother) {
    const SmoothConfig& config = smoother.config;
    const auto n_steps = static_cast<std::uint64_t>(config.iterations);
    Mesh mesh = read_mesh(config.cloud, smoother.origin);
    const std::vector<Vec3d> from = mesh.position;
    const json edges = edges_rounded_off(smoother, mesh);
    const auto out = rewrite_cloud(config.cloud, config.output, smoother.text_step(),
                                   smoother.noise_variance());
    const SmoothedMesh smoothed =
        smooth_mesh(smoother.index, smoother.settings(), mesh, [&](int i) {
            smoother.context.reporter.progress("iterations", static_cast<std::uint64_t>(i),
                                               n_steps);
            smoother.context.check_stop();
        });
    SmoothCounts counts;
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

}  // namespace slim
