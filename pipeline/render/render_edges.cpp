#include "pipeline/render/render_edges.h"

#include "slim/edges/trace_edges.h"

#include <algorithm>

namespace slim {

std::vector<ScenePart> scene_parts(const SurfelTree& tree,
                                   const std::optional<TracedModels>& traced) {
    if (!traced) return {{&tree, {}}};
    return {traced->parts().begin(), traced->parts().end()};
}

bool has_sharp(const std::vector<ScenePart>& parts) {
    return std::any_of(parts.begin(), parts.end(),
                       [](const ScenePart& part) { return !part.tree->sharp().empty(); });
}

std::vector<std::vector<SharpEdge>> edges_of(const std::vector<ScenePart>& parts, bool loose,
                                             Reporter& reporter) {
    const auto tell = [&](std::size_t done, std::size_t total) {
        reporter.progress("edges", done, total);
    };
    std::vector<std::vector<SharpEdge>> out;
    for (const ScenePart& part : parts) {
        out.push_back(trace_sharp_edges(*part.tree, loose, tell));
        for (SharpEdge& edge : out.back())
            for (EdgePoint& p : edge.points) p.point += part.offset;
    }
    return out;
}

}  // namespace slim
