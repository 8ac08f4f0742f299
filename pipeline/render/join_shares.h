#pragma once

#include "pipeline/render/render_config.h"
#include "pipeline/render/render_share.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

namespace slim {

/// What a share draws: of a film the same (its pictures have their names already), of a picture a
/// tile of it, into the share's folder; its first share writes the lines of all of the picture.
RenderConfig config_of_share(const RenderConfig& config, const RenderShare& share);

/// Makes of --join shares what one run would have made: numbered pictures are checked, tiles are
/// put together, the same bytes; then the manifest of the whole is written. Draws nothing. throws
/// IncompleteError naming the shares that are missing, or that are of other options or inputs
nlohmann::json join_shares(const RenderConfig& config, StageContext& context);

}  // namespace slim
