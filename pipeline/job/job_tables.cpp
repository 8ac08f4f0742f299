#include "pipeline/job/job_tables.h"

#include "pipeline/job/job_own_keys.h"
#include "pipeline/manifest.h"
#include "slim/base/error.h"
#include "slim/base/nearest_name.h"

#include <fmt/format.h>

#include <algorithm>

namespace slim {

namespace fs = std::filesystem;

std::string table_place(const fs::path& file, const TomlTable& table) {
    return toml_place(file, table.line);
}

const TomlTable* find_table(const TomlTable& in, const std::string& name, const fs::path& file) {
    const TomlTable* found = nullptr;
    for (const TomlTable& table : in.tables) {
        if (table.name != name) continue;
        if (found)
            throw ConfigError("a second [" + name + "]").at(toml_fault(file, table.line));
        found = &table;
    }
    return found;
}

void check_tables(const TomlTable& in, const std::vector<std::string>& known,
                  const fs::path& file) {
    for (const TomlTable& table : in.tables) {
        if (std::find(known.begin(), known.end(), table.name) != known.end()) continue;
        Fault fault{.problem = "unknown table [" + table.name + "]",
                    .hint = did_you_mean(table.name, known)};
        if (fault.hint.empty())
            fault.expected = known.empty() ? "keys alone within [" + in.name + "]"
                                           : fmt::format("{}", fmt::join(known, ", "));
        throw ConfigError(fault).at(toml_fault(file, table.line));
    }
}

void check_top_keys(const TomlTable& root, const fs::path& file) {
    for (const TomlValue& value : root.values) {
        const Fault place = toml_fault(file, value.line);
        if (value.key != "schema_version")
            throw ConfigError(
                {.problem = fmt::format("unknown key '{}': keys stand in the tables {}, above them "
                                        "schema_version",
                                        value.key, fmt::join(kJobTables, ", ")),
                 .hint = did_you_mean(value.key, {"schema_version"})})
                .at(place);
        if (value.kind != Field::Kind::integer || value.is_list ||
            value.items != std::vector<std::string>{std::to_string(kJobSchema)})
            throw ConfigError(
                {.key = "schema_version",
                 .problem = fmt::format("this program reads jobs of version {}", kJobSchema),
                 .found = fmt::format("{}", fmt::join(value.items, ", "))})
                .at(place);
    }
}

TomlTable without_replaced(TomlTable table) {
    const auto find = [&](const char* key) {
        return std::find_if(table.values.begin(), table.values.end(),
                            [&](const TomlValue& value) { return value.key == key; });
    };
    const auto is_said_later = [&](const char* key, const char* none) {
        const auto value = find(key);
        return value != table.values.end() && value->line <= 0 &&
               value->items != std::vector<std::string>{none};
    };
    const auto leave_out = [&](const char* key) {
        const auto value = find(key);
        if (value != table.values.end() && value->line > 0) table.values.erase(value);
    };
    const bool antialias = is_said_later("antialias", "false"),
               supersample = is_said_later("supersample", "1");
    if (antialias) leave_out("supersample");
    if (supersample) leave_out("antialias");
    return table;
}

std::set<std::string> replaced_by_view(const TomlTable& view) {
    const auto says = [&](const char* key, const char* none) {
        return std::any_of(view.values.begin(), view.values.end(), [&](const TomlValue& value) {
            return value.key == key && value.items != std::vector<std::string>{none};
        });
    };
    const bool antialias = says("antialias", "false"), supersample = says("supersample", "1");
    if (antialias == supersample)
        return {};  // of both the renderer says that they do not go together
    return {antialias ? "supersample" : "antialias"};
}

namespace {

void put_value(TomlTable& table, TomlValue value) {
    std::erase_if(table.values, [&](const TomlValue& v) { return v.key == value.key; });
    table.values.push_back(std::move(value));
}

/// What an option for all views leaves without effect in a view's own table.
void erase_overridden(TomlTable& view, const TomlValue& option) {
    const auto erase = [&](const std::string& key) {
        std::erase_if(view.values, [&](const TomlValue& v) { return v.key == key; });
    };
    erase(option.key);
    for (const std::string& other : replaced_by_view({"", 0, {option}, {}})) erase(other);
}

}  // namespace

void override_views(TomlTable& root, const std::vector<TomlValue>& options) {
    const auto is = [](const char* name) {
        return [name](const TomlTable& table) { return table.name == name; };
    };
    if (!options.empty() && std::none_of(root.tables.begin(), root.tables.end(), is("render")))
        root.tables.push_back({"render", kOnCommandLine, {}, {}});
    for (TomlValue option : options) {
        const bool of_each = option.key == "aov" || option.key == "name";
        if (option.key == "aov") option.key = "aovs";  // as views call it
        if (option.key == "light") std::erase_if(root.tables, is("light"));
        for (TomlTable& table : root.tables) {
            if (table.name == "view") erase_overridden(table, option);
            if (table.name == (of_each ? "view" : "render")) put_value(table, option);
        }
    }
}

/// Nothing for an empty value: a command line would take its next word for it.
void append_option(const Field& field, std::vector<std::string>& out) {
    if (field.is_flag()) {
        const bool on = field.items()[0] == "true";
        out.push_back(on ? field.option() : "--no-" + field.option().substr(2));
    } else if (field.is_path()) {
        for (const std::string& item : field.items())
            if (!item.empty()) out.push_back(field.option() + "=" + item);
    } else {
        const std::string value = fmt::format("{}", fmt::join(field.items(), ","));
        if (!value.empty()) out.push_back(field.option() + "=" + value);
    }
}

void append_arguments(JobStep& step, const std::vector<std::string>& arguments) {
    step.arguments.insert(step.arguments.end(), arguments.begin(), arguments.end());
}

void add_step_output(JobStep& step, const Job& job) {
    for (const JobStep& earlier : job.steps)
        if (earlier.output == step.output)
            throw ConfigError({.file = job.file.string(),
                               .problem = fmt::format("{} would write {}, which {} writes",
                                                      step.name, step.output.string(),
                                                      earlier.name),
                               .expected = "different names"});
    step.arguments.push_back("-o");
    step.arguments.push_back(step.output.string());
    step.target = manifest_path(step.output);
    step.products = {step.output};
}

}  // namespace slim
