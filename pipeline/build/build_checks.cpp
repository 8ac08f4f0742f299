#include "pipeline/build/build_checks.h"

#include "pipeline/build/slice_stage.h"
#include "pipeline/json_text.h"
#include "pipeline/memory_size.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <cstdint>

namespace slim {
namespace {

constexpr std::uint64_t kLeastMemory = 64 << 20;

}  // namespace

void check_slice_memory(const std::string& memory) {
    if (parse_memory_size(memory) < kLeastMemory)
        throw ConfigError({.key = "memory",
                           .expected = "at least " + memory_size_text(kLeastMemory) +
                                       ", which the coarse levels take",
                           .found = "'" + memory + "'"});
}

void check_normals_config(const NormalsConfig& config) {
    if (config.neighbors != 0 && config.neighbors < 4)
        throw ConfigError({.key = "neighbors",
                           .expected = "0, or 4 to 200",
                           .found = std::to_string(config.neighbors)});
    if (!config.sensors.empty() && config.normals != "keep") read_json(config.sensors);
    if (config.normals != "keep") return;
    if (!config.sensors.empty())
        throw ConfigError({.key = "sensors",
                           .problem = "turn estimated normals; --normals keep estimates none"});
    if (config.neighbors != 0)
        throw ConfigError(
            {.key = "neighbors",
             .problem = "are what normals are estimated from; --normals keep estimates none"});
}

void check_fit_config(const FitConfig& config) {
    if (config.coarse && (config.slice >= 0 || config.slices_per_task > 1))
        throw ConfigError({.key = "coarse",
                           .problem = "the coarse levels are of all slices: leave out --slice and "
                                      "--slices-per-task"});
    if (config.radius_rule != "windows") return;
    if (config.degree == "auto" || config.sharp == "on")
        throw ConfigError(
            {.key = "radius_rule",
             .problem = " windows: goes with one degree and without sharp features",
             .found = fmt::format("--degree {} --sharp {}", config.degree, config.sharp)});
}

NormalsConfig normals_config(const BuildConfig& c, const std::string& work) {
    NormalsConfig n;
    n.work = work;
    n.slice = kAllSlices;
    n.normals = c.normals;
    n.sensors = c.sensors;
    return n;
}

FitConfig fit_config(const BuildConfig& c, const std::string& work) {
    FitConfig f;
    f.work = work;
    f.slice = kAllSlices;
    static_cast<FitOptions&>(f) = c;
    f.memory = c.memory;
    f.seed = c.seed;
    return f;
}

void check_build_options(const BuildConfig& config) {
    check_slice_memory(config.memory);
    check_fit_config(fit_config(config, ""));
    check_normals_config(normals_config(config, ""));
}

}  // namespace slim
