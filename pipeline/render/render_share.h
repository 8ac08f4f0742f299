#pragma once

#include "pipeline/render/render_config.h"

#include <filesystem>

namespace slim {

/// One of several tasks that share a film (pictures in a row) or a picture (bands of rows): number
/// `number` (from 1) of `of`; of 0: all at once.
struct RenderShare {
    int number = 0, of = 0;
};

/// Whether the configuration asks for a turntable or path.
bool is_film(const RenderConfig& config);

/// --share of a configuration. ConfigError if it is no i/n, if n is more than the pictures of the
/// film or the rows of the picture, or beside --join, --crop, --tile, --frame or --repeat, which
/// are no parts of a whole.
RenderShare share_of(const RenderConfig& config);
/// The same checks of --join.
void check_join(const RenderConfig& config);

/// Of n things in order those of the share: [begin, end), counted from 0; as --tile cuts rows.
int share_begin(int n, const RenderShare& share);
int share_end(int n, const RenderShare& share);

/// Pictures of a film, counted from 1, both included; 1 to 1 of a single one.
struct FrameRange {
    int first, last;
};
/// Those that a run, or its share of a film, draws.
FrameRange wanted_frames(const RenderConfig& config, const RenderShare& share);

/// x.png.shares/0003_of_0008: where a share of the picture or film x.png keeps what is not yet its
/// own file.
std::filesystem::path share_folder(const std::filesystem::path& named, const RenderShare& share);

/// The share's manifest.
std::filesystem::path share_target(const std::filesystem::path& named, const RenderShare& share);

}  // namespace slim
