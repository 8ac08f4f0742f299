#pragma once

#include "formats/model_file.h"
#include "pipeline/manifest.h"
#include "pipeline/render/render_config.h"
#include "pipeline/render/render_files.h"
#include "pipeline/render/render_share.h"

#include <filesystem>
#include <string>
#include <vector>

namespace slim {

/// What can be wrong before the model is opened, ConfigError: among it a file of the run that is
/// one which it reads, by whatever name. Returns the number of pictures.
int check_request(const RenderConfig& config, const std::vector<std::string>& aovs);

/// The first of a folder and those above it that is there must be one: those below it can be made.
///
/// output  what was asked for, for the message (IoError, 2)
void check_folder(const std::filesystem::path& folder, const std::string& output);

/// No file of these, nor of lines in space, may be one that the run reads (ConfigError), a folder
/// or a device, or lie below a file (IoError, 2): said before the first picture is drawn.
void check_outputs(const RenderConfig& config, const OutputPlan& plan);

/// Adds all that the pictures depend on.
void add_inputs(const RenderConfig& config, const ModelFile& model, Stamp& stamp);

/// Adds the pictures and line files of a run or share that its options name; legends and line
/// drawings beside them are found while drawing. aovs: those that the model can give.
void add_outputs(const RenderConfig& config, const std::vector<std::string>& aovs,
                 const RenderShare& share, Stamp& stamp);

/// Of the shares of a picture the first writes the lines of all of it.
bool writes_lines(const RenderShare& share, bool film);

}  // namespace slim
