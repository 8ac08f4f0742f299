#pragma once

#include "pipeline/job/job.h"
#include "pipeline/render/render_config.h"

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace slim {

/// The pictures that a view leaves in a folder: <name>.<aov>.png, of a turntable or path
/// <name>.<aov>_0001.png and so on; with lines <name>.lines.svg (<name>_0001.lines.svg). Of format
/// exr <name>.exr, which holds all AOVs, and its preview <name>.png.
std::vector<std::filesystem::path> view_pictures(const std::filesystem::path& folder,
                                                 const std::string& name,
                                                 const std::vector<std::string>& aovs,
                                                 const RenderConfig& config);

/// Whether a word of the command line is that option: --ao-samples=9 or --no-legend.
bool is_option(const std::string& word, const std::string& key);

/// [render] may say what only some views take (a truth, contours, lights): slim-render refuses it
/// elsewhere, so these options are left out of views that have no use for them, and set back in
/// `config`; and so are those that the view's `own` keys replace:
/// on a command line lists would be joined.
std::vector<std::string> options_for(const std::vector<std::string>& aovs,
                                     std::vector<std::string> options,
                                     const std::set<std::string>& own, RenderConfig& config);

/// Files that these options of slim-render name to be read.
std::vector<std::filesystem::path> files_read(const std::vector<std::string>& options);

/// The files of lines in space that these options of slim-render name: --lines-ply, --lines-obj.
std::vector<std::filesystem::path> line_files(const std::vector<std::string>& options);

/// The first of them whose name is not that of such a file, by its key ("lines_ply"); nothing if
/// all are.
struct WrongLineFile {
    std::string key, reason;
};
std::optional<WrongLineFile> wrong_line_file(const std::vector<std::string>& options);

/// Renames those in the options of several views, each of which writes its own: edges.ply is
/// front.edges.ply of the view "front", as its pictures are named.
void name_line_files(const std::string& view, std::vector<std::string>& options);

/// Throws ConfigError on a view that no model of this [fit], or not the given one, can give.
void check_view_of_fit(const std::vector<std::string>& aovs, const RenderConfig& view,
                       const BuildStages& stages);

}  // namespace slim
