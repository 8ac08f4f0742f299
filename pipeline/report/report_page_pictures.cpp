#include "pipeline/report/report_page_pictures.h"

#include "pipeline/report/report_page_cells.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

namespace slim {
namespace {

std::string base64(const std::string& bytes) {
    static const char* const kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t v = 0;
        for (std::size_t k = 0; k < 3; ++k)
            v = v << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            out += i + k > bytes.size() ? '=' : kDigits[v >> (18 - 6 * k) & 63u];
    }
    return out;
}

std::string picture(const std::string& path, const std::string& caption) {
    std::ifstream in(path, std::ios::binary);
    if (!in) return "";
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    return fmt::format(
        "<figure class=\"picture\"><img alt=\"{0}\" "
        "src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>\n",
        esc(caption), base64(bytes));
}

/// The PNG files that a step of a row wrote.
std::vector<std::string> pngs_of(const StepRecord& step) {
    std::vector<std::string> out;
    if (step.figures.contains("files"))
        for (const nlohmann::json& file : step.figures["files"])
            if (file.get<std::string>().ends_with(".png")) out.push_back(file.get<std::string>());
    if (out.empty() && step.output.ends_with(".png")) out.push_back(step.output);
    return out;
}

/// "view-1a2b.mean.png": mean.
std::string map_of(const std::string& path) {
    const std::string stem = std::filesystem::path(path).stem().string();
    return stem.substr(stem.rfind('.') + 1);
}

}  // namespace

std::string pictures_html(const ExperimentResult& result) {
    std::string out;
    for (const ReportPictures& shown_of : result.experiment->pictures)
        for (const ReportRow& row : result.rows) {
            const StepRecord* step = row.step(shown_of.of);
            if (!step || !step->done || !is_meant(row, shown_of.when)) continue;
            const std::string caption = shown_of.caption.empty()
                                            ? row.label(*result.experiment)
                                            : row.text(shown_of.caption, 4, shown_of.where);
            const std::vector<std::string> files = pngs_of(*step);
            for (const std::string& path : files)
                out += picture(path, caption + (files.size() > 1 ? ", " + map_of(path) : ""));
        }
    return out.empty() ? "" : "<div class=\"figures\">\n" + out + "</div>\n";
}

}  // namespace slim
