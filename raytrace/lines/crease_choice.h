#pragma once

#include "raytrace/lines/line_scene.h"

#include <cstdint>
#include <vector>

namespace slim {

/// Which of the scene's edges are worth drawing in its view: 1 or 0 for each (see CreaseSearch).
std::vector<std::uint8_t> chosen_edges(const LineScene& scene);

}  // namespace slim
