#include "pipeline/report/report_file.h"

#include "pipeline/config.h"
#include "pipeline/manifest.h"
#include "pipeline/report/report_names.h"
#include "pipeline/report/report_table_reader.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <set>

namespace slim {
namespace {

namespace fs = std::filesystem;

FigureValue value_of(const TomlValue& value, const std::string& item) {
    if (value.kind == Field::Kind::boolean) return item == "true" ? 1.0 : 0.0;
    if (value.kind == Field::Kind::text) return item;
    return std::strtod(item.c_str(), nullptr);  // denormal numbers too
}

/// A table of formulas, in the order of the file.
std::vector<std::pair<std::string, Expression>> formulas_of(const TomlTable& table,
                                                            const TableReader& reader) {
    std::vector<std::pair<std::string, Expression>> out;
    for (const TomlValue& v : table.values)
        out.emplace_back(v.key, Expression(v.items.empty() ? "" : v.items[0],
                                           reader.place(v.line) + ": " + v.key));
    return out;
}

void check_point_formulas(const ReportStep& step) {
    static const std::set<std::string> kKnown = {"x",  "y",  "z",  "nx",  "ny",
                                                 "nz", "k1", "k2", "keep"};
    for (const auto& [key, formula] : step.point)
        if (!kKnown.contains(key))
            throw ConfigError(fmt::format(
                "{}: a point has no '{}'; expected x y z nx ny nz k1 k2 keep", step.where, key));
}

/// What a step must have, by what it runs.
void check_step(ReportStep& step) {
    static const std::vector<std::string> kRuns = {"scan",  "build",  "slice",   "normals", "fit",
                                                   "tree",  "render", "measure", "smooth",  "info",
                                                   "cloud", "text",   "command"};
    static const std::map<std::string, std::string> kEndings = {
        {"scan", ".ply"},   {"build", ".slim"}, {"render", ".png"},
        {"smooth", ".ply"}, {"cloud", ".ply"},  {"text", ".xyz"}};
    if (std::find(kRuns.begin(), kRuns.end(), step.run) == kRuns.end())
        throw ConfigError(fmt::format("{}: run: unknown '{}'{}", step.where, step.run,
                                      suggestion(step.run, kRuns)));
    if (step.name.empty()) step.name = step.run;
    if (step.out.empty() && kEndings.contains(step.run)) step.out = kEndings.at(step.run);
    if (step.run == "command" && step.program.empty())
        throw ConfigError(step.where + ": a command needs a program");
    if (step.run == "cloud" && step.from.empty() == step.points.empty())
        throw ConfigError(step.where + ": a cloud needs either from (clouds) or points (a number)");
    check_point_formulas(step);
}

ReportStep step_of(const TomlTable& table, const fs::path& file) {
    ReportStep step;
    TableReader reader(table, file);
    step.where = reader.place();
    reader.text("name", step.name);
    reader.text("run", step.run);
    reader.text("args", step.args);
    reader.text("out", step.out);
    reader.text("program", step.program);
    reader.texts("from", step.from);
    reader.text("points", step.points);
    reader.text("text", step.text);
    reader.formula("when", step.when);
    reader.wholes("exit", step.exit);
    reader.whole("repeat", step.repeat);
    reader.flag("may_fail", step.may_fail);
    reader.flag("single", step.single);
    reader.flag("transient", step.transient);
    reader.tables("point", [&](const TomlTable& t) { step.point = formulas_of(t, reader); });
    reader.read();
    step.repeat = std::max(step.repeat, 1);
    check_step(step);
    return step;
}

ReportPlot plot_of(const TomlTable& table, const fs::path& file) {
    ReportPlot plot;
    TableReader reader(table, file);
    plot.where = reader.place();
    std::string scale = "loglog";
    reader.text("title", plot.title);
    reader.formula("x", plot.x);
    reader.formula("y", plot.y);
    reader.text("x_label", plot.x_label);
    reader.text("y_label", plot.y_label);
    reader.text("series", plot.series);
    reader.text("scale", scale);
    reader.flag("slopes", plot.slopes);
    reader.formula("when", plot.when);
    reader.formula("theory", plot.theory);
    reader.text("theory_label", plot.theory_label);
    reader.formula("least_slope", plot.least_slope);
    reader.formula("most_slope", plot.most_slope);
    reader.formula("broken", plot.broken);
    reader.text("known", plot.known);
    reader.read();
    if (plot.x.empty() || plot.y.empty()) throw ConfigError(plot.where + ": a plot needs x and y");
    static const std::vector<std::string> kScales = {"loglog", "logx", "logy", "linear"};
    if (std::find(kScales.begin(), kScales.end(), scale) == kScales.end())
        throw ConfigError(fmt::format("{}: scale: unknown '{}'{}", plot.where, scale,
                                      suggestion(scale, kScales)));
    plot.log_x = scale == "loglog" || scale == "logx";
    plot.log_y = scale == "loglog" || scale == "logy";
    if (plot.x_label.empty()) plot.x_label = plot.x.text();
    if (plot.y_label.empty()) plot.y_label = plot.y.text();
    plot.slopes = plot.slopes || !plot.theory.empty() || !plot.least_slope.empty() ||
                  !plot.most_slope.empty();
    return plot;
}

ReportPictures pictures_of(const TomlTable& table, const fs::path& file) {
    ReportPictures pictures;
    TableReader reader(table, file);
    pictures.where = reader.place();
    reader.text("of", pictures.of);
    reader.text("caption", pictures.caption);
    reader.formula("when", pictures.when);
    reader.read();
    return pictures;
}

ReportCheck check_of(const TomlTable& table, const fs::path& file) {
    ReportCheck check;
    TableReader reader(table, file);
    check.where = reader.place();
    reader.text("name", check.name);
    reader.text("known", check.known);
    reader.formula("value", check.value);
    reader.formula("least", check.least);
    reader.formula("most", check.most);
    reader.formula("when", check.when);
    reader.read();
    if (check.value.empty() || (check.least.empty() && check.most.empty()))
        throw ConfigError(check.where + ": a check needs a value and least, most or both");
    if (check.name.empty()) check.name = check.value.text();
    return check;
}

void read_grid(const TomlTable& table, Experiment& out) {
    for (const TomlValue& v : table.values) {
        out.grid.emplace_back(v.key, std::vector<FigureValue>{});
        for (const std::string& item : v.items) out.grid.back().second.push_back(value_of(v, item));
    }
}

void check_names(const Experiment& e) {
    std::set<std::string> seen;
    for (const auto& [name, values] : e.grid) seen.insert(name);
    for (const ReportStep& step : e.steps)
        if (!seen.insert(step.name).second)
            throw ConfigError(fmt::format("{}: the name '{}' is taken", step.where, step.name));
    for (const ReportPictures& p : e.pictures)
        if (std::none_of(e.steps.begin(), e.steps.end(),
                         [&](const ReportStep& s) { return s.name == p.of; }))
            throw ConfigError(fmt::format("{}: of: no step '{}'", p.where, p.of));
}

Experiment experiment_of(const TomlTable& table, const fs::path& file) {
    Experiment e;
    TableReader reader(table, file);
    e.where = reader.place();
    for (const auto& [key, member] : {std::pair{"name", &e.name},
                                      {"title", &e.title},
                                      {"text", &e.text},
                                      {"row", &e.row},
                                      {"expected", &e.expected},
                                      {"found", &e.found},
                                      {"health", &e.health},
                                      {"known", &e.known}})
        reader.text(key, *member);
    reader.formula("pass", e.pass);
    reader.formula("when", e.when);
    reader.texts("needs", e.needs);
    reader.tables("grid", [&](const TomlTable& t) { read_grid(t, e); });
    reader.tables("columns", [&](const TomlTable& t) { e.columns = formulas_of(t, reader); });
    reader.tables("step", [&](const TomlTable& t) { e.steps.push_back(step_of(t, file)); });
    reader.tables("plot", [&](const TomlTable& t) { e.plots.push_back(plot_of(t, file)); });
    reader.tables("picture",
                  [&](const TomlTable& t) { e.pictures.push_back(pictures_of(t, file)); });
    reader.tables("check", [&](const TomlTable& t) { e.checks.push_back(check_of(t, file)); });
    reader.read();
    if (e.name.empty()) throw ConfigError(e.where + ": an experiment needs a name");
    if (e.title.empty()) e.title = e.name;
    check_names(e);
    return e;
}

/// [values] of a file.
const TomlTable* values_of(const TomlTable& root) {
    const auto found = std::find_if(root.tables.begin(), root.tables.end(),
                                    [](const TomlTable& t) { return t.name == "values"; });
    return found == root.tables.end() ? nullptr : &*found;
}

bool has_value(const TomlTable& root, const std::string& key) {
    const TomlTable* values = values_of(root);
    return values && std::any_of(values->values.begin(), values->values.end(),
                                 [&](const TomlValue& v) { return v.key == key; });
}

/// The KEY of "values.KEY=VALUE", which some file must have.
std::string key_of_setting(const std::string& setting, const std::vector<TomlTable>& roots) {
    constexpr std::string_view kTable = "values.";
    const std::size_t equals = setting.find('=');
    if (!setting.starts_with(kTable) || equals == std::string::npos)
        throw ConfigError(fmt::format(
            "--set {}: expected values.KEY=VALUE, such as values.points=1000", setting));
    const std::string key = setting.substr(kTable.size(), equals - kTable.size());
    std::vector<std::string> known;
    for (const TomlTable& root : roots) {
        if (has_value(root, key)) return key;
        if (const TomlTable* values = values_of(root))
            for (const TomlValue& v : values->values) known.push_back(v.key);
    }
    std::sort(known.begin(), known.end());
    known.erase(std::unique(known.begin(), known.end()), known.end());
    throw ConfigError(fmt::format(
        "--set {}: no report file has '{}' in its [values]{}; {}", setting, key,
        suggestion(key, known),
        known.empty() ? "they have none" : fmt::format("they have {}", fmt::join(known, ", "))));
}

void read_values(const TomlTable& table, const TableReader& reader, ReportFile& out) {
    for (const TomlValue& v : table.values) {
        if (v.is_list || v.items.size() != 1)
            throw ConfigError(fmt::format("{}: {}: expected one value, found '{}'",
                                          reader.place(v.line), v.key, fmt::join(v.items, ", ")));
        out.values.emplace_back(v.key, value_of(v, v.items[0]));
    }
    if (!table.tables.empty())
        throw ConfigError(fmt::format("{}: [values] holds values, no table '{}'",
                                      reader.place(table.tables[0].line), table.tables[0].name));
}

/// `settings`: those of this file.
ReportFile report_of(const fs::path& file, TomlTable root,
                     const std::vector<std::string>& settings) {
    for (const std::string& setting : settings) set_value(root, setting);
    ReportFile out;
    out.file = file;
    out.name = out.title = file.stem().string();
    out.hash = hash_file(file);
    if (!settings.empty())
        out.hash = hash_text(fmt::format("{} {}", out.hash, fmt::join(settings, " ")));
    TableReader reader(root, file);
    reader.text("title", out.title);
    reader.text("text", out.text);
    reader.tables("values", [&](const TomlTable& t) { read_values(t, reader, out); });
    reader.tables("experiment",
                  [&](const TomlTable& t) { out.experiments.push_back(experiment_of(t, file)); });
    reader.read();
    std::set<std::string> names;
    for (const Experiment& e : out.experiments)
        if (!names.insert(e.name).second)
            throw ConfigError(fmt::format("{}: the name '{}' is taken", e.where, e.name));
    if (out.experiments.empty()) throw ConfigError(file.string() + ": no [[experiment]]");
    for (const Experiment& e : out.experiments) check_formulas(e, out.values);
    return out;
}

}  // namespace

std::vector<ReportFile> read_report_files(const std::vector<std::string>& files,
                                          const std::vector<std::string>& settings) {
    std::vector<TomlTable> roots;
    for (const std::string& file : files) roots.push_back(read_toml(file));
    std::vector<std::string> keys;
    for (const std::string& setting : settings) keys.push_back(key_of_setting(setting, roots));
    std::vector<ReportFile> out;
    for (std::size_t i = 0; i < files.size(); ++i) {
        std::vector<std::string> own;
        for (std::size_t k = 0; k < keys.size(); ++k)
            if (has_value(roots[i], keys[k])) own.push_back(settings[k]);
        out.push_back(report_of(files[i], roots[i], own));
    }
    return out;
}

}  // namespace slim
