#include "pipeline/render/render_uses.h"

#include "pipeline/config.h"
#include "pipeline/contains.h"
#include "pipeline/render/ray_options.h"
#include "pipeline/render/render_asked.h"
#include "pipeline/render/render_cameras.h"
#include "raytrace/camera.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace slim {
namespace {

using Aovs = std::vector<std::string>;

bool shows(const Aovs& aovs, const char* aov) {
    return contains(aovs, aov) || (contains(aovs, "all") && contains(aovs_of_all(), aov));
}

template <const char* const& kAov>
bool takes(const RenderConfig&, const Aovs& aovs) {
    return shows(aovs, kAov);
}

constexpr const char* kTruth = "truth_distance";
constexpr const char* kEnvironment = "environment";
constexpr const char* kMatcap = "matcap";
constexpr const char* kHillshade = "hillshade";
constexpr const char* kShaded = "shaded";

bool has_ground(const RenderConfig& config, const Aovs&) { return config.ground; }
bool takes_ground(const RenderConfig&, const Aovs& aovs) {
    return shows(aovs, "shaded") || shows(aovs, "ao");
}
bool has_openness(const RenderConfig& config, const Aovs& aovs) {
    return config.ao || shows(aovs, "ao");
}

bool is_orthographic(const RenderConfig& config, const Aovs&) {
    return config.ortho || config.ortho_width > 0;
}
bool has_named_camera(const RenderConfig& config) {
    const std::vector<std::string> cameras = cameras_of(config);
    return std::any_of(cameras.begin(), cameras.end(),
                       [](const auto& camera) { return is_camera_name(camera); });
}
bool takes_same_scale(const RenderConfig& config, const Aovs& aovs) {
    return is_orthographic(config, aovs) && config.ortho_width <= 0 && has_named_camera(config);
}
/// All but cameras of nine numbers, and what stands upright in the scene.
bool takes_up(const RenderConfig& config, const Aovs& aovs) {
    const std::vector<std::string> cameras = cameras_of(config);
    const bool turns_cameras =
        std::any_of(cameras.begin(), cameras.end(), [](const std::string& camera) {
            return std::count(camera.begin(), camera.end(), ',') != 8;
        });
    const bool lights = shows(aovs, kShaded) && config.light != RenderConfig{}.light;
    return turns_cameras || config.turntable > 0 || !config.same_range.empty() || config.ground ||
           lights || shows(aovs, kHillshade) || shows(aovs, kEnvironment);
}
bool takes_camera(const RenderConfig& config, const Aovs&) { return config.path.empty(); }
bool takes_zoom(const RenderConfig& config, const Aovs&) {
    const std::vector<std::string> keys = keyframes_of(config);  // one, and empty, without a path
    return std::any_of(keys.begin(), keys.end(), [](const std::string& key) {
        return key.find("zoom") == std::string::npos;
    });
}
bool takes_name(const RenderConfig& config, const Aovs&) { return is_folder_output(config.output); }
bool takes_background(const RenderConfig& config, const Aovs& aovs) {
    return !config.environment_behind || aovs != Aovs{kEnvironment};
}
/// Cameras of numbers see, orthographically, what the angle shows at their target.
bool takes_angle(const RenderConfig& config, const Aovs& aovs) {
    if (!is_orthographic(config, aovs) || !config.path.empty()) return true;
    return config.ortho_width <= 0 && config.camera.find(',') != std::string::npos;
}
bool is_cast(const RenderConfig& config, const Aovs&) { return config.mode == "raytrace"; }
bool throws_shadows(const RenderConfig& config, const Aovs& aovs) {
    return is_cast(config, aovs) && shows(aovs, kShaded);
}
/// The other modes draw no stand-ins, as --lod 0.
bool takes_lod(const RenderConfig& config, const Aovs&) {
    return config.mode == "forward" || config.lod == 0;
}

constexpr const char* kCurvatures[] = {"mean", "gauss", "k1", "k2"};
constexpr const char* kOtherMaps[] = {"e1",    "e2",       "dk1_dt2",       "dk2_dt1",
                                      "error", "coverage", "truth_distance"};

bool shows_curvature(const Aovs& aovs) {
    return std::any_of(std::begin(kCurvatures), std::end(kCurvatures),
                       [&](auto aov) { return shows(aovs, aov); });
}
bool has_map(const RenderConfig&, const Aovs& aovs) {
    return shows_curvature(aovs) || shows(aovs, "depth") ||
           std::any_of(std::begin(kOtherMaps), std::end(kOtherMaps),
                       [&](auto aov) { return shows(aovs, aov); });
}
/// A map that is shown and of which --range does not say the range.
bool has_free_range(const RenderConfig& config, const Aovs& aovs, const char* aov) {
    return shows(aovs, aov) &&
           std::none_of(config.range.begin(), config.range.end(), [&](const std::string& entry) {
               const std::size_t equals = entry.find('=');
               return equals == std::string::npos || entry.substr(0, equals) == aov;
           });
}
bool takes_percentile(const RenderConfig& config, const Aovs& aovs) {
    const auto is_free = [&](auto aov) { return has_free_range(config, aovs, aov); };
    return std::any_of(std::begin(kCurvatures), std::end(kCurvatures), is_free) ||
           std::any_of(std::begin(kOtherMaps), std::end(kOtherMaps), is_free);
}
bool takes_same_range(const RenderConfig& config, const Aovs& aovs) {
    return takes_percentile(config, aovs) || has_free_range(config, aovs, "depth");
}
/// Some entry speaks of a map that is shown: A, AOV=A or AOV=LO:HI.
bool takes_range(const RenderConfig& config, const Aovs& aovs) {
    return std::any_of(config.range.begin(), config.range.end(), [&](const std::string& entry) {
        const std::size_t equals = entry.find('=');
        return equals == std::string::npos ? has_map(config, aovs)
                                           : shows(aovs, entry.substr(0, equals).c_str());
    });
}
bool takes_light_maps(const RenderConfig&, const Aovs& aovs) {
    return shows_curvature(aovs) || shows(aovs, "color");
}

bool leaves_room(const RenderConfig& config, const Aovs&) { return frames_by_name(config); }

/// A picture with one sample a pixel that may have more.
bool takes_antialias(const RenderConfig& config, const Aovs& aovs) {
    return has_one_sample(config) &&
           std::any_of(aovs.begin(), aovs.end(), [](const std::string& aov) {
               return aov != "lines" && is_filterable(aov);
           });
}

bool draws_lines(const RenderConfig& config, const Aovs& aovs) {
    return !config.lines.empty() || contains(aovs, "lines");
}

constexpr const char* kLinesRemedy = ": --lines or --aov lines";
constexpr const char* kOpennessRemedy = ": --ao or --aov ao";

constexpr OptionUse kUses[] = {
    {"truth_shape", "the aov truth_distance", "", takes<kTruth>},
    {"offset", "the aov truth_distance", "", takes<kTruth>},
    {"environment", "the aov environment", "", takes<kEnvironment>},
    {"environment_turn", "the aov environment", "", takes<kEnvironment>},
    {"environment_behind", "the aov environment", "", takes<kEnvironment>},
    {"matcap", "the aov matcap", "", takes<kMatcap>},
    {"sun", "the aov hillshade", "", takes<kHillshade>},
    {"contours", "the aov hillshade", "", takes<kHillshade>},
    {"camera", "a view that stands or turns", ", but --path is, which says its cameras",
     takes_camera},
    {"zoom", "a camera that says no zoom of its own", ", but --path says one with each",
     takes_zoom},
    {"up", "a camera without an up axis of its own or for what stands upright", "", takes_up},
    {"name", "a folder as output", ": -o FOLDER", takes_name},
    {"background", "a picture without --environment-behind", "", takes_background},
    {"same_scale", "an orthographic named camera that frames the model", ": --ortho",
     takes_same_scale},
    {"fov", "a perspective camera", ", but parallel projection is", takes_angle},
    {"bounces", "the aov shaded of rays", ": --mode raytrace", throws_shadows},
    {"shadows", "the aov shaded of rays", ": --mode raytrace", throws_shadows},
    {"lod", "--mode forward", "", takes_lod},
    {"antialias", "a shaded picture or a map of one sample a pixel",
     ": pictures of id and level show data, which are never averaged, lines alone are smooth "
     "already, --supersample takes more samples everywhere, --mode brute one",
     takes_antialias},
    {"range", "a map that it names", ": such as --aov mean", takes_range},
    {"percentile", "a map with a range of its own", ": such as --aov mean without --range",
     takes_percentile},
    {"same_range", "a map with a range of its own", ": such as --aov mean without --range",
     takes_same_range},
    {"legend_room", "a named camera that frames the whole model", "", leaves_room},
    {"lines_ply", "a drawing of lines", kLinesRemedy, draws_lines},
    {"lines_obj", "a drawing of lines", kLinesRemedy, draws_lines},
    {"light_maps", "a curvature map or the aov color", "", takes_light_maps},
    {"light", "the aov shaded", "", takes<kShaded>},
    {"material", "the aov shaded", "", takes<kShaded>},
    {"ambient", "the aov shaded", "", takes<kShaded>},
    {"ao", "the aov shaded", " (alone: --aov ao)", takes<kShaded>},
    {"ground", "the aov shaded or ao", "", takes_ground},
    {"ao_distance", "ambient occlusion", kOpennessRemedy, has_openness},
    {"ao_samples", "ambient occlusion", kOpennessRemedy, has_openness},
    {"ground_height", "the ground", ": --ground", has_ground},
    {"ground_color", "the ground", ": --ground", has_ground},
};

}  // namespace

const std::vector<std::string>& aovs_of_all() {
    static const std::vector<std::string> kAll = {
        "shaded", "color", "environment", "matcap", "reflection", "hillshade", "mean",    "gauss",
        "k1",     "k2",    "dir1",        "dir2",   "e1",         "e2",        "dk1_dt2", "dk2_dt1",
        "normal", "depth", "position",    "id",     "error",      "level",     "coverage"};
    return kAll;
}

Legends legends_of(const RenderConfig& config, const Aovs& aovs) {
    if (!config.legend) return Legends::none;
    if (shows(aovs, "level") || has_map(config, aovs)) return Legends::maps;
    const bool directions = shows(aovs, "dir1") || shows(aovs, "dir2");
    const bool contours = shows(aovs, kHillshade) && config.contours != "none";
    if (directions) return contours ? Legends::both_keys : Legends::directions;
    return contours ? Legends::contours : Legends::none;
}

bool has_legend(const RenderConfig& config, const Aovs& aovs) {
    return legends_of(config, aovs) != Legends::none;
}

bool frames_by_name(const RenderConfig& config) {
    return config.ortho_width <= 0 && (!config.path.empty() || is_camera_name(config.camera));
}

std::span<const OptionUse> option_uses() { return kUses; }

ConfigError unused_option(const OptionUse& use, const Fault& place, const std::string& hint) {
    Fault fault = place;
    fault.key = use.key;
    fault.problem = fmt::format(" is for {}, which is not asked for{}", use.what, use.remedy);
    fault.hint = hint;
    return ConfigError(fault);
}

void refuse_unused(const RenderConfig& config, const std::vector<std::string>& aovs) {
    RenderConfig given = config, usual;
    const FieldList fields = fields_of(given), defaults = fields_of(usual);
    for (const OptionUse& use : kUses)
        if (fields.find(use.key)->items() != defaults.find(use.key)->items() &&
            !use.used(config, aovs))
            throw unused_option(use);
}

}  // namespace slim
