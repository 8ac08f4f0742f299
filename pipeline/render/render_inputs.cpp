#include "pipeline/render/render_inputs.h"

#include "formats/atomic_file.h"
#include "pipeline/input_kind.h"
#include "pipeline/render/render_cameras.h"
#include "pipeline/render/render_check.h"
#include "pipeline/render/render_lines.h"
#include "slim/base/error.h"

#include <cstdlib>

namespace slim {

namespace fs = std::filesystem;

void check_folder(const fs::path& folder, const std::string& output) {
    std::error_code none;
    fs::path above = folder;
    while (above.has_relative_path() && fs::status(above, none).type() == fs::file_type::not_found)
        above = above.parent_path();
    // Below a file nothing is found; the file itself is.
    if (above.empty() || fs::is_directory(above, none)) return;
    throw IoError({.file = output,
                   .problem = above.string() + " is no folder",
                   .expected = "one, or a name that is free"},
                  ExitCode::usage);
}

int check_request(const RenderConfig& config, const std::vector<std::string>& aovs) {
    check_options(config);
    check_lines(config);
    const int frames = n_frames(config);
    const OutputPlan pictures = plan_outputs(config, aovs);
    for (int k = 0; k <= (frames > 1 ? frames : 0); ++k)
        check_outputs(config, k > 0 ? pictures.numbered(k) : pictures);
    require_model(config.model);
    return frames;
}

void add_inputs(const RenderConfig& config, const ModelFile& model, Stamp& stamp) {
    stamp.input(config.model, model.identity());
    for (const std::string& file : {config.environment, config.matcap})
        if (!file.empty()) stamp.input(file);
    for (const std::string& added : config.add) stamp.input(added);
    if (const char* epoch = std::getenv("SOURCE_DATE_EPOCH")) stamp.depends(epoch);
}

void add_outputs(const RenderConfig& config, const std::vector<std::string>& aovs,
                 const RenderShare& share, Stamp& stamp) {
    const OutputPlan plan = plan_outputs(config, aovs);
    const FrameRange range = wanted_frames(config, share);
    const bool film = n_frames(config) > 1;
    for (int k = range.first; k <= range.last; ++k) {
        const OutputPlan picture = film ? plan.numbered(k) : plan;
        stamp.outputs(picture.pngs);
        if (!picture.exr.empty()) stamp.outputs({picture.exr});
    }
    if (!writes_lines(share, film)) return;
    for (const std::string& file : {config.lines_ply, config.lines_obj})
        if (!file.empty()) stamp.outputs({file});
}

bool writes_lines(const RenderShare& share, bool film) { return film || share.number <= 1; }

void check_outputs(const RenderConfig& config, const OutputPlan& plan) {
    std::vector<fs::path> outputs = plan.pngs;
    for (const std::string& aov : plan.drawn) outputs.push_back(plan.legend(aov));
    for (const fs::path& output :
         {plan.exr, plan.lines_svg(), plan.contours_svg(), fs::path(config.lines_ply),
          fs::path(config.lines_obj)})
        if (!output.empty()) outputs.push_back(output);
    for (const fs::path& output : outputs) {
        check_replaceable(output.string());
        check_folder(output.parent_path(), output.string());
        refuse_to_overwrite(output.string(), {config.model, config.environment, config.matcap});
        for (const std::string& added : config.add) refuse_to_overwrite(output.string(), {added});
    }
}

}  // namespace slim
