#include "pipeline/render/render_summary.h"

#include "pipeline/plain_number.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace slim {
namespace {

using nlohmann::json;

std::string file_lines(const json& files) {
    constexpr std::size_t kMost = 12;
    std::string text;
    for (std::size_t i = 0; i < std::min(files.size(), kMost); ++i)
        text += files[i].get<std::string>() + "\n";
    if (files.size() > kMost)
        text += fmt::format("... and {} more, the last {}\n", files.size() - kMost,
                            files.back().get<std::string>());
    return text;
}

}  // namespace

std::string render_summary(const RenderConfig& config, const json& result) {
    const std::string unit = config.unit.empty() ? "model units" : config.unit;
    const json files = result.value("files", json::array()),
               ranges = result.value("ranges", json::object());
    std::string text = file_lines(files);
    const double covered = result.value("covered_pixels", 0.0);
    const double all = result.value("rendered_pixels", 0.0) * result.value("frames", 1.0);
    text += fmt::format(
        "{} x {} pixels{}", result.value("width", 0), result.value("height", 0),
        result.contains("frames") ? fmt::format(", {} pictures", result.value("frames", 0)) : "");
    if (all > 0) text += fmt::format(", {:.3g} % covered", std::min(100.0, 100 * covered / all));
    if (result.contains("pixel_size"))
        text += fmt::format("; 1 pixel = {} {}",
                            plain_number(result.at("pixel_size").get<double>(), 4), unit);
    text += "\n";
    for (const auto& [aov, range] : ranges.items())
        text += fmt::format("{}: {} to {}\n", aov, plain_number(range.at(0).get<double>(), 4),
                            plain_number(range.at(1).get<double>(), 4));
    for (const json& left : result.value("left_out", json::array()))
        text += "not of aov all: " + left.get<std::string>() + "\n";
    if (result.contains("frame_ms_median"))
        text += fmt::format(
            "drawn in {}{}\n", duration_text(result.at("frame_ms_median").get<double>()),
            config.repeat > 1 ? fmt::format(", the median of {}", config.repeat) : "");
    return text;
}

}  // namespace slim
