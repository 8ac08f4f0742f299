#include "pipeline/job/job_views.h"

#include "formats/extension.h"
#include "pipeline/config.h"
#include "pipeline/contains.h"
#include "pipeline/render/render_cameras.h"
#include "pipeline/render/render_lights.h"
#include "pipeline/render/render_uses.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

namespace slim {

std::vector<std::filesystem::path> view_pictures(const std::filesystem::path& folder,
                                                 const std::string& name,
                                                 const std::vector<std::string>& aovs,
                                                 const RenderConfig& config) {
    const bool lines = !config.lines.empty() || contains(aovs, "lines");
    const bool film = config.turntable > 0 || !config.path.empty();
    const int n = film ? n_frames(config) : 1;
    std::vector<std::filesystem::path> files;
    for (int k = 1; k <= n; ++k) {
        if (config.frame > 0 && k != config.frame) continue;
        const std::string number = film ? fmt::format("_{:04}", k) : "";
        if (config.format == "exr")
            for (const char* ending : {".exr", ".png"})
                files.push_back(folder / (name + number + ending));
        else
            for (const std::string& aov : aovs)
                if (aov != "all") files.push_back(folder / (name + "." + aov + number + ".png"));
        if (lines) files.push_back(folder / (name + number + ".lines.svg"));
    }
    return files;
}

bool is_option(const std::string& word, const std::string& key) {
    std::string name = key;
    std::replace(name.begin(), name.end(), '_', '-');
    return word == "--" + name || word == "--no-" + name || word.starts_with("--" + name + "=");
}

std::vector<std::string> options_for(const std::vector<std::string>& aovs,
                                     std::vector<std::string> options,
                                     const std::set<std::string>& own, RenderConfig& config) {
    const auto take_out = [&](const std::string& key) {
        std::erase_if(options, [&](const std::string& word) { return is_option(word, key); });
    };
    for (const std::string& key : own) take_out(key);
    RenderConfig usual;
    const FieldList fields = fields_of(config), defaults = fields_of(usual);
    for (const OptionUse& use : option_uses()) {
        if (own.contains(use.key) || use.used(config, aovs)) continue;
        take_out(use.key);
        fields.find(use.key)->set(defaults.find(use.key)->items(), {.key = use.key});
    }
    return options;
}

std::vector<std::filesystem::path> files_read(const std::vector<std::string>& options) {
    std::vector<std::filesystem::path> files;
    for (const std::string& option : options)
        for (const std::string begin : {"--add=", "--environment=", "--matcap="})
            if (option.starts_with(begin)) files.emplace_back(option.substr(begin.size()));
    return files;
}

namespace {

constexpr auto kLineFiles = std::to_array<std::string_view>({"--lines-ply=", "--lines-obj="});

/// What such a file's name must end in, and its key: lines_ply.
std::string ending_of(std::string_view option) { return option == kLineFiles[0] ? ".ply" : ".obj"; }
std::string key_of(std::string_view option) { return "lines_" + ending_of(option).substr(1); }

}  // namespace

std::optional<WrongLineFile> wrong_line_file(const std::vector<std::string>& options) {
    for (const std::string& option : options)
        for (const std::string_view begin : kLineFiles) {
            if (!option.starts_with(begin) || option.size() == begin.size()) continue;
            const std::filesystem::path file = option.substr(begin.size());
            if (lower_extension(file) == ending_of(begin)) continue;
            return WrongLineFile{key_of(begin),
                                 fmt::format("expected a name ending in {}, found {}",
                                             ending_of(begin), file.filename().string())};
        }
    return std::nullopt;
}

std::vector<std::filesystem::path> line_files(const std::vector<std::string>& options) {
    std::vector<std::filesystem::path> files;
    for (const std::string& option : options)
        for (const std::string_view begin : kLineFiles)
            if (option.starts_with(begin)) files.emplace_back(option.substr(begin.size()));
    return files;
}

void name_line_files(const std::string& view, std::vector<std::string>& options) {
    for (std::string& option : options)
        for (const std::string_view begin : kLineFiles) {
            if (!option.starts_with(begin)) continue;
            std::filesystem::path file = option.substr(begin.size());
            file.replace_filename(view + "." + file.filename().string());
            option = std::string(begin) + file.string();
        }
}

void check_view_of_fit(const std::vector<std::string>& aovs, const RenderConfig& view,
                       const BuildStages& stages) {
    const std::string& degree = stages.degree;
    if (degree == "1" || degree == "2") {
        const std::string reason = fmt::format(
            "third derivatives, which a model of degree {} does not have: expected {}", degree,
            model_remedy(stages, "degree", "3"));
        for (const char* aov : {"e1", "e2", "dk1_dt2", "dk2_dt1"})
            if (contains(aovs, aov))
                throw ConfigError(
                    {.key = "aov", .problem = fmt::format(" {} needs {}", aov, reason)});
        if (view.lines ==
            std::vector<std::string>{"crest"})  // beside others it is left out with a warning
            throw ConfigError({.key = "lines", .problem = " crest need " + reason});
    }
    if (stages.sharp == "off" && view.lines == std::vector<std::string>{"crease"})
        throw ConfigError({.key = "lines",
                           .problem = " crease need the sheets of sharp surfels",
                           .expected = model_remedy(stages, "sharp", "on")});
    const std::string colors = "a model with colours";
    if (contains(aovs, "color") && !stages.color)
        throw ConfigError({.key = "aov",
                           .problem = " color needs " + colors,
                           .expected = model_remedy(stages, "color", "true")});
    if (tints_shaded(view, aovs) && !stages.color)
        throw ConfigError({.key = "material",
                           .problem = " color=scan needs " + colors,
                           .expected = model_remedy(stages, "color", "true")});
}

}  // namespace slim
