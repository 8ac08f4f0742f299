#pragma once

#include "pipeline/render/render_trace.h"
#include "slim/base/reporter.h"
#include "slim/model/sharp_edge.h"
#include "slim/model/surfel_tree.h"

#include <optional>
#include <vector>

namespace slim {

/// The models of a picture with their places: those that rays meet, or the one.
std::vector<ScenePart> scene_parts(const SurfelTree& tree,
                                   const std::optional<TracedModels>& traced);

/// Whether some model has sharp surfels.
bool has_sharp(const std::vector<ScenePart>& parts);

/// The sharp edges of each model, frame of the first one. Tells its progress, of each model in
/// turn, and can be stopped.
std::vector<std::vector<SharpEdge>> edges_of(const std::vector<ScenePart>& parts, bool loose,
                                             Reporter& reporter);

}  // namespace slim
