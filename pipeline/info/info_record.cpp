#include "pipeline/info/info_record.h"

#include "pipeline/json_text.h"

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <initializer_list>

namespace slim {
namespace {

using nlohmann::json;

bool has(const json& value, std::initializer_list<const char*> keys) {
    if (!value.is_object()) return false;
    for (const char* key : keys)
        if (!value.contains(key)) return false;
    return true;
}

std::size_t n_of(const json& value, const char* key) {
    return value.contains(key) && value.at(key).is_array() ? value.at(key).size() : 0;
}

std::string text_in(const json& value, const char* key) {
    return value.at(key).is_string() ? value.at(key).get<std::string>() : "";
}

json manifest_info(const json& c) {
    return {{"kind", "manifest"},
            {"about", fmt::format("the manifest of slim {}: what it was told and read, what it "
                                  "wrote and found, and what that cost",
                                  text_in(c, "stage"))},
            {"inputs", n_of(c, "inputs")},
            {"outputs", n_of(c, "outputs")}};
}

json report_info(const json& c) {
    std::size_t experiments = 0, rows = 0;
    for (const json& file : c.at("files"))
        for (const json& experiment : file.value("experiments", json::array()))
            ++experiments, rows += n_of(experiment, "rows");
    return {{"kind", "report"},
            {"about", "the figures of a report: its page's for programs, as 'slim report' writes"},
            {"experiments", experiments},
            {"rows", rows}};
}

json about_of(const json& c) {
    if (has(c, {"stage", "config_hash", "outputs"})) return manifest_info(c);
    if (has(c, {"slices", "coordinate_quantum"}))
        return {{"kind", "plan"},
                {"about", "how 'slim slice' and 'slim build' cut clouds into slices"},
                {"slices", n_of(c, "slices")}};
    if (has(c, {"scans"}) && c.at("scans").is_array())
        return {{"kind", "scans"},
                {"about", "where the scanner stood: positions of a cloud's scans (--sensors)"},
                {"scans", n_of(c, "scans")}};
    if (has(c, {"provenance", "files"}) && c.at("files").is_array()) return report_info(c);
    if (has(c, {"step", "run", "figures"}))
        return {{"kind", "step"},
                {"about", fmt::format("a step of a report, '{}': its figures and files",
                                      text_in(c, "step"))},
                {"files", n_of(c, "files")}};
    if (has(c, {"stage", "version"}))
        return {{"kind", "result"},
                {"about", fmt::format("what slim {} found, as with --json", text_in(c, "stage"))},
                {"figures", c.size()}};
    if (has(c, {"l2", "max", "points"}))
        return {{"kind", "result"},
                {"about", "errors of a model or a cloud, as 'slim measure' writes"},
                {"figures", c.size()}};
    return {{"kind", "json"},
            {"about", "JSON, of no kind that slim writes"},
            {"items", c.is_structured() ? c.size() : 1}};
}

}  // namespace

json record_info(const std::string& path) {
    json contents = read_json(path);
    json out;
    try {
        out = about_of(contents);
    } catch (const json::exception&) {  // the keys of one of ours, and other values
        out = {{"kind", "json"}, {"about", "JSON, of no kind that slim writes"}};
    }
    out["bytes"] = std::filesystem::file_size(path);
    out["contents"] = std::move(contents);
    return out;
}

}  // namespace slim
