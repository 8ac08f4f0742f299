#include "pipeline/render_uses.h"

#include "pipeline/config.h"
#include "pipeline/contains.h"
#include "slim/base/error.h"

#include <fmt/format.h>

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
bool has_openness(const RenderConfig& config, const Aovs& aovs) { return config.ao || shows(aovs, "ao"); }

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
    {"light", "the aov shaded", "", takes<kShaded>},
    {"material", "the aov shaded", "", takes<kShaded>},
    {"ambient", "the aov shaded", "", takes<kShaded>},
    {"ao", "the aov shaded", " (alone: --aov ao)", takes<kShaded>},
    {"ground", "the aovs shaded and ao", "", takes_ground},
    {"ao_distance", "ambient occlusion", kOpennessRemedy, has_openness},
    {"ao_samples", "ambient occlusion", kOpennessRemedy, has_openness},
    {"ground_height", "the ground", ": --ground", has_ground},
    {"ground_color", "the ground", ": --ground", has_ground},
};

}  // namespace

const std::vector<std::string>& aovs_of_all() {
    static const std::vector<std::string> kAll = {
        "shaded",  "color",   "environment", "matcap", "reflection", "hillshade", "mean",  "gauss",
        "k1",      "k2",      "dir1",        "dir2",   "e1",         "e2",        "dk1_dt2", "dk2_dt1",
        "normal",  "depth",   "position",    "id",     "error",      "level",     "coverage"};
    return kAll;
}

std::span<const OptionUse> option_uses() { return kUses; }

std::string unused_text(const OptionUse& use) {
    return fmt::format("{} is for {}, which is not asked for{}", use.key, use.what, use.remedy);
}

void refuse_unused(const RenderConfig& config, const std::vector<std::string>& aovs) {
    RenderConfig given = config, usual;
    const FieldList fields = fields_of(given), defaults = fields_of(usual);
    for (const OptionUse& use : kUses)
        if (fields.find(use.key)->items() != defaults.find(use.key)->items() && !use.used(config, aovs))
            throw ConfigError(unused_text(use));
}

}  // namespace slim
