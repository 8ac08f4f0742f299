#include "pipeline/info/info_toml.h"

#include "pipeline/contains.h"
#include "pipeline/json_text.h"
#include "pipeline/toml_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace slim {
namespace {

using nlohmann::json;

json item_json(const TomlValue& value, const std::string& item) {
    if (value.kind == Field::Kind::text) return item;
    const json parsed = json_or_discarded(item);
    return parsed.is_discarded() ? json(item) : parsed;  // inf, nan
}

json value_json(const TomlValue& value) {
    if (!value.is_list && value.items.size() == 1) return item_json(value, value.items[0]);
    json list = json::array();
    for (const std::string& item : value.items) list.push_back(item_json(value, item));
    return list;
}

/// A table's own keys, without the tables in it.
json table_json(const TomlTable& table) {
    json out = json::object();
    for (const TomlValue& value : table.values) out[value.key] = value_json(value);
    return out;
}

std::size_t n_keys(const TomlTable& table) {
    std::size_t n = table.values.size();
    for (const TomlTable& inner : table.tables) n += n_keys(inner);
    return n;
}

/// A list, also one that is written as a command line has it.
json list_of(const json& value) { return value.is_array() ? value : json::array({value}); }

/// A view as it is drawn: with the name, camera and pictures that it takes from elsewhere.
json view_json(const TomlTable& table, const json& job) {
    json view = table_json(table);
    const auto usual = [&](const char* of, const char* key, const json& otherwise) {
        return job.contains(of) ? job.at(of).value(key, otherwise) : otherwise;
    };
    if (!view.contains("aovs"))
        view["aovs"] = usual("output", "aovs", json::array({"shaded"}));
    view["aovs"] = list_of(view.at("aovs"));
    if (!view.contains("lines")) view["lines"] = usual("render", "lines", json::array());
    view["lines"] = list_of(view.at("lines"));
    if (view.contains("name")) return view;
    const json camera = view.contains("camera") ? view.at("camera")
                                                : usual("render", "camera", json("front"));
    const bool is_name = camera.is_string() &&
                         camera.get_ref<const std::string&>().find(',') == std::string::npos;
    view["name"] = is_name ? camera : json("view");
    return view;
}

/// What a job's tables ask for.
void add_job(const TomlTable& root, json& out) {
    for (const TomlTable& table : root.tables)
        if (contains(std::vector<std::string>{"input", "fit", "render", "measure", "output"},
                     table.name)) {
            out[table.name] = table_json(table);
            for (const TomlTable& inner : table.tables)
                if (table.name == "input" && inner.name == "scan") out["scan"] = table_json(inner);
        }
    out["view_list"] = json::array();
    for (const TomlTable& table : root.tables)
        if (table.name == "view") out["view_list"].push_back(view_json(table, out));
}

void add_report(const TomlTable& root, json& out) {
    out["experiment_names"] = json::array();
    for (const TomlTable& table : root.tables)
        if (table.name == "experiment")
            for (const TomlValue& value : table.values)
                if (value.key == "name") out["experiment_names"].push_back(value_json(value));
}

/// A value as a person would write it: words without quotes, lists with commas.
std::string text_of_value(const json& value) {
    if (value.is_string()) return value.get<std::string>();
    if (!value.is_array()) return text_of(value);
    std::vector<std::string> items;
    for (const json& item : value) items.push_back(text_of_value(item));
    return fmt::format("{}", fmt::join(items, ", "));
}

/// "degree = 2, t_mdl = 0.01".
std::string keys_text(const json& table) {
    std::vector<std::string> keys;
    for (const auto& [key, value] : table.items())
        keys.push_back(key + " = " + text_of_value(value));
    return keys.empty() ? "as by default" : fmt::format("{}", fmt::join(keys, ", "));
}

/// Up to eight, and how many more there are.
std::string some_of(const std::vector<std::string>& names, const char* between) {
    constexpr std::size_t kMost = 8;
    const std::vector<std::string> first(
        names.begin(), names.begin() + static_cast<std::ptrdiff_t>(std::min(kMost, names.size())));
    const std::string more = names.size() > kMost
                                 ? fmt::format("{}and {} more", between, names.size() - kMost)
                                 : "";
    return fmt::format("{}{}", fmt::join(first, between), more);
}

std::string view_text(const json& view) {
    const std::string lines = text_of_value(view.at("lines"));
    return text_of_value(view.at("name")) + ": " + text_of_value(view.at("aovs")) +
           (lines.empty() ? "" : ", lines " + lines);
}

}  // namespace

json toml_info(const std::string& path) {
    const TomlTable root = read_toml(path);
    json tables = json::array();
    for (const TomlTable& table : root.tables)
        if (std::find(tables.begin(), tables.end(), table.name) == tables.end())
            tables.push_back(table.name);
    const auto has = [&](const char* name) {
        return std::find(tables.begin(), tables.end(), name) != tables.end();
    };
    const bool is_report = has("experiment");
    const bool is_job = !is_report && (has("input") || has("view") || has("fit"));
    json out = {{"kind", is_report ? "report" : is_job ? "job" : "toml"},
                {"about", is_report ? "a report file: 'slim report' runs its experiments"
                          : is_job
                              ? "a job file: 'slim run' does it, 'slim plan --explain' says it"
                              : "a TOML file: options of a verb, for its --config"},
                {"bytes", std::filesystem::file_size(path)},
                {"tables", tables},
                {"keys", n_keys(root)}};
    for (const auto& [table, counted] : {std::pair{"view", "views"}, {"experiment", "experiments"}})
        if (has(table))
            out[counted] =
                std::count_if(root.tables.begin(), root.tables.end(),
                              [table = table](const TomlTable& t) { return t.name == table; });
    if (is_job) add_job(root, out);
    if (is_report) add_report(root, out);
    if (!is_job && !is_report) out["options"] = table_json(root);
    return out;
}

json toml_in_short(json info) {
    std::vector<std::string> names;
    if (info.contains("view_list")) {
        for (const json& view : info.at("view_list")) names.push_back(view_text(view));
        info["views"] = names.empty() ? "none" : some_of(names, "; ");
        if (info.contains("input") && info.at("input").contains("files"))
            info["input"] = text_of_value(info.at("input").at("files"));
        else
            info.erase("input");
        for (const char* key : {"scan", "fit", "render", "measure", "output"})
            if (info.contains(key)) info[key] = keys_text(info.at(key));
        for (const char* key : {"view_list", "tables", "keys"}) info.erase(key);
    } else if (info.contains("experiment_names")) {
        for (const json& name : info.at("experiment_names")) names.push_back(text_of_value(name));
        info["experiments"] = fmt::format("{}: {}", text_of(info.at("experiments")),
                                          some_of(names, ", "));
        for (const char* key : {"experiment_names", "tables", "keys"}) info.erase(key);
    } else {
        for (const auto& [key, value] : info.at("options").items()) names.push_back(key);
        if (!names.empty())
            info["keys"] = fmt::format("{}: {}", text_of(info.at("keys")), some_of(names, ", "));
        info.erase("options"), info.erase("tables");
    }
    return info;
}

}  // namespace slim
