#include "pipeline/scan_stage.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace slim {
namespace {

/// Options that were given and play no part. (A noise model without noise does: series over the
/// noise begin at 0.)
void refuse_without_effect(const ScanConfig& config) {
    const ScanConfig usual;
    const bool uniform = config.pattern == "uniform";
    if (uniform && config.stations != usual.stations)
        throw ConfigError({.key = "stations",
                           .problem = "are of --pattern scan; uniform points have none"});
    if (uniform && config.dropout != usual.dropout)
        throw ConfigError({.key = "dropout",
                           .problem = "is of --pattern scan; none of uniform points is lost"});
}

}  // namespace

Vec3d scan_offset(const ScanConfig& config) {
    if (config.offset.empty()) return {};
    if (config.offset.size() != 3)
        throw ConfigError({.key = "offset",
                           .expected = "three numbers x,y,z",
                           .found = std::to_string(config.offset.size())});
    const Vec3d offset{config.offset[0], config.offset[1], config.offset[2]};
    // Beyond it doubles are half a unit apart, and the shapes two units large.
    constexpr double kMost = 1e15;
    for (const double v : config.offset)
        if (!(std::abs(v) <= kMost))
            throw ConfigError({.key = "offset",
                               .expected = fmt::format("three numbers in [{}, {}]", -kMost, kMost),
                               .found = fmt::format("{}", v)});
    return offset;
}

void check_scan_options(const ScanConfig& config) {
    refuse_without_effect(config);
    scan_offset(config);
}

}  // namespace slim
