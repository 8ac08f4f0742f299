#include "pipeline/render/render_asked.h"

#include "pipeline/contains.h"
#include "pipeline/option_names.h"
#include "pipeline/render/render_lights.h"
#include "pipeline/render/render_uses.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <map>

namespace slim {
namespace {

const std::map<std::string, Channels>& channel_table() {
    static const std::map<std::string, Channels> table{
        {"shaded", kNormalChannel},
        {"environment", kNormalChannel},
        {"matcap", kNormalChannel},
        {"reflection", kNormalChannel},
        {"hillshade", kNormalChannel | kPositionChannel},
        {"color", kNormalChannel | kPositionChannel | kSurfelIdChannel},
        {"dir1", kDirectionChannel | kK1Channel | kK2Channel},
        {"dir2", kDirectionChannel | kK1Channel | kK2Channel | kNormalChannel},
        {"e1", kThirdOrderChannel | kK1Channel | kK2Channel},
        {"e2", kThirdOrderChannel | kK1Channel | kK2Channel},
        {"dk1_dt2", kThirdOrderChannel | kK1Channel | kK2Channel},
        {"dk2_dt1", kThirdOrderChannel | kK1Channel | kK2Channel},
        {"mean", kMeanChannel},
        {"gauss", kGaussChannel | kMeanChannel},  // its range
        {"k1", kK1Channel},
        {"k2", kK2Channel},
        {"normal", kNormalChannel},
        {"depth", kDepthChannel},
        {"position", kPositionChannel},
        {"id", kSurfelIdChannel},
        {"error", kFitErrorChannel},
        {"level", kLevelChannel},
        {"coverage", kCoverageChannel},
        {"ao", kNormalChannel | kPositionChannel},
        {"truth_distance", kPositionChannel},
        {"lines", 0},  // what they need depends on their kinds: line_channels
    };
    return table;
}

/// Each once, "all" by its names.
std::vector<std::string> written_out(const std::vector<std::string>& asked) {
    std::vector<std::string> aovs;
    const auto add = [&](const std::string& aov) {
        if (!contains(aovs, aov)) aovs.push_back(aov);
    };
    for (const std::string& aov : asked) {
        if (aov != "all") add(aov);
        else
            for (const std::string& each : aovs_of_all())
                add(each);
    }
    return aovs;
}

}  // namespace

bool is_curvature(const std::string& aov) {
    return (channel_table().at(aov) & kCurvatureChannel) != 0 && aov != "dir1" && aov != "dir2" &&
           !is_third_order(aov);
}

bool is_third_order(const std::string& aov) {
    return (channel_table().at(aov) & kThirdOrderChannel) != 0;
}

std::vector<std::string> possible_aovs(const std::vector<std::string>& asked, int degree,
                                       bool has_colors) {
    std::vector<std::string> aovs = written_out(asked);
    if (!has_colors) std::erase(aovs, "color");
    if (degree < 3) std::erase_if(aovs, is_third_order);
    return aovs;
}

std::vector<LeftOut> left_out_of_all(const std::vector<std::string>& asked, int degree,
                                     bool has_colors, SaidBy said_by) {
    const auto said = [&](const char* option, const char* key) {
        return said_by == SaidBy::options ? option : key;
    };
    std::vector<LeftOut> out;
    if (!contains(asked, "all")) return out;
    const auto add = [&](std::initializer_list<const char*> aovs, std::string reason) {
        std::vector<std::string> names;
        for (const char* aov : aovs)
            if (!contains(asked, aov)) names.push_back(aov);
        if (!names.empty())
            out.push_back({fmt::format("{}", fmt::join(names, ", ")), std::move(reason)});
    };
    if (degree < 3)
        add({"e1", "e2", "dk1_dt2", "dk2_dt1"},
            fmt::format("a model of degree {} has no third derivatives (build it with {} 3)",
                        degree, said("--degree", "degree")));
    const auto add_by_name = [&](const char* aov, const char* why) {
        add({aov}, fmt::format("{} and is to be asked for by name", why));
    };
    if (!has_colors)
        add({"color"}, fmt::format("one model with colours has it (build it with {})",
                                   said("--color", "color")));
    add_by_name("ao", said("takes rays (--mode raytrace)", "takes rays (mode raytrace)"));
    add_by_name("truth_distance",
                said("needs a shape (--truth-shape)", "needs a shape (truth_shape)"));
    return out;
}

namespace {

constexpr const char* kNoColors =
    "the model has no colours: build it with --color, from a PLY with red, green and blue";

}  // namespace

std::vector<std::string> wanted_aovs(const RenderConfig& config) {
    const std::vector<std::string> aovs = written_out(config.aov);
    if (aovs.empty()) throw ConfigError({.key = "aov", .expected = "at least one"});
    check_truth(config, aovs);
    return aovs;
}

void check_truth(const RenderConfig& config, const std::vector<std::string>& aovs) {
    if (contains(aovs, "truth_distance") && config.truth_shape.empty())
        throw ConfigError({.key = "aov",
                           .problem = " truth_distance needs a shape to measure against: " +
                                      quoted_key("truth_shape")});
}

void keep_possible_aovs(const RenderConfig& config, int degree, bool has_colors,
                        std::vector<std::string>& aovs) {
    if (!has_colors && std::find(config.aov.begin(), config.aov.end(), "color") != config.aov.end())
        throw ConfigError(
            {.file = config.model, .problem = std::string("aov color: ") + kNoColors});
    if (!has_colors && tints_shaded(config, aovs))
        throw ConfigError(
            {.file = config.model, .problem = std::string("material color=scan: ") + kNoColors});
    // Those of a model are by its own surfels, which further models do not have.
    if (!has_colors || !config.add.empty()) std::erase(aovs, "color");
    if (degree >= 3) return;
    for (const std::string& aov : config.aov)
        if (aov != "all" && is_third_order(aov))
            throw ConfigError(
                {.file = config.model,
                 .problem = "aov " + aov + " needs third derivatives, which a model of degree " +
                            std::to_string(degree) + " does not have: build it with --degree 3"});
    std::erase_if(aovs, is_third_order);
}

Channels channels_of(const std::vector<std::string>& aovs, bool light_maps) {
    Channels channels = 0;
    for (const std::string& aov : aovs) {
        const Channels own = channel_table().at(aov);
        channels |= own;
        if (light_maps && is_curvature(aov)) channels |= kNormalChannel;
    }
    return channels;
}

bool is_filterable(const std::string& aov) {
    return aov != "id" && aov != "level" && aov != "truth_distance";
}

}  // namespace slim
