#pragma once

#include "pipeline/render/render_config.h"
#include "pipeline/stage.h"

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace slim {

/// Puts the tiles that the --join shares of a picture have drawn together, rows after rows: the
/// files of one run, byte for byte. `written`: names of what the shares wrote, without folders.
/// `at_once`: whether one run would hold the picture as a whole, so that it sees whether all of it
/// is opaque. Returns what was written. Memory: a band of rows. throws FormatError where a tile is
/// not of its place's size
std::vector<std::filesystem::path> stitch_shares(const RenderConfig& config,
                                                 const std::vector<std::string>& aovs,
                                                 const std::set<std::filesystem::path>& written,
                                                 bool at_once, StageContext& context);

}  // namespace slim
