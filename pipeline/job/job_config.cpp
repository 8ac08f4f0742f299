#include "pipeline/job/job_config.h"

#include "pipeline/build/build_stage.h"
#include "pipeline/job/job.h"
#include "pipeline/job/job_own_keys.h"
#include "pipeline/job/job_tables.h"
#include "pipeline/measure/measure_stage.h"
#include "pipeline/render/render_config.h"
#include "pipeline/scan_stage.h"

#include <fmt/format.h>

#include <algorithm>

namespace slim {
namespace {

namespace fs = std::filesystem;

void make_absolute(const FieldList& fields) {
    for (const Field& field : fields.fields()) {
        if (!field.is_path() || field.empty()) continue;
        std::vector<std::string> paths = field.items();
        for (std::string& path : paths) path = fs::absolute(path).lexically_normal().string();
        field.set(paths, field.place());
    }
}

/// A table with the job's own keys and those of a verb but for what the job fills in. `only`: those
/// keys alone; empty: all, with their help.
template <class Config, class Own>
std::string table_text(const std::string& heading, const TomlTable& table, const fs::path& file,
                       Own& own, const std::set<std::string>& owned,
                       const std::set<std::string>& only = {}) {
    Config config;
    FieldList all;
    own.visit(all);
    const FieldList of_verb = fields_of(config);
    for (const Field& field : of_verb.fields())
        if (!owned.contains(field.key) && !all.find(field.key)) all.append(field);
    apply_table(table, all, file);
    make_absolute(all);
    std::string out = "\n" + heading + "\n";
    if (only.empty()) return out + print_config(all);
    for (const Field& field : all.fields())
        if (only.contains(field.key)) out += fmt::format("{} = {}\n", field.key, field.toml());
    return out;
}

/// A value as it was read: of lights, whose keys are no options.
std::string value_text(const TomlValue& value) {
    std::vector<std::string> items = value.items;
    if (value.kind == Field::Kind::text)
        for (std::string& item : items) {
            std::string text = item;
            item = Field("", Field::Target(&text), "", FieldRole::option).toml();
        }
    const std::string joined = fmt::format("{}", fmt::join(items, ", "));
    return value.is_list ? "[" + joined + "]" : joined;
}

class JobPrinter {
public:
    JobPrinter(const fs::path& file, const std::vector<std::string>& settings)
        : file_(file), root_(read_toml(file)), job_(read_job(file, settings)) {
        for (const std::string& setting : settings) set_value(root_, setting);
    }

    std::string text() {
        std::string out = fmt::format("schema_version = {}\n", kJobSchema);
        out += input() + table_text<BuildConfig>("[fit]", table("fit"), file_, none_, kOwnedOfFit);
        if (find_table(root_, "measure", file_))
            out += table_text<MeasureConfig>("[measure]", table("measure"), file_, none_,
                                             owned_of_measure(n_clouds_));
        AllViewsTable all_views;
        out += output() + table_text<RenderConfig>("[render]", without_replaced(table("render")),
                                                   file_, all_views, kOwnedOfRender);
        return out + lights() + views();
    }

private:
    const TomlTable& table(const std::string& name) const {
        static const TomlTable empty;
        const TomlTable* found = find_table(root_, name, file_);
        return found ? *found : empty;
    }

    std::string input() {
        if (const TomlTable* scan = find_table(table("input"), "scan", file_))
            return table_text<ScanConfig>("[input.scan]", *scan, file_, none_, kOwnedOfScan);
        InputTable input;
        const std::string text = table_text<NoKeys>("[input]", table("input"), file_, input, {});
        n_clouds_ = input.files.size();
        return text;
    }

    std::string output() {
        apply_table(table("output"), fields_of(output_), file_);
        output_.dir = job_.folder.string(), output_.title = job_.title;
        make_absolute(fields_of(output_));
        return "\n[output]\n" + print_config(fields_of(output_));
    }

    std::string lights() const {
        std::string out;
        for (const TomlTable& light : root_.tables) {
            if (light.name != "light") continue;
            out += "\n[[light]]\n";
            for (const TomlValue& value : light.values)
                out += fmt::format("{} = {}\n", value.key, value_text(value));
        }
        return out;
    }

    std::string views() {
        std::string out;
        auto step = job_.steps.begin();
        for (const TomlTable& in_file : root_.tables) {
            if (in_file.name != "view") continue;
            step = std::find_if(step, job_.steps.end(),
                                [](const JobStep& s) { return s.verb == "render"; });
            ViewTable view;
            view.name = step->name.substr(std::string("view ").size());
            view.aovs = output_.aovs;
            std::set<std::string> keys = {"name", "aovs"};
            for (const TomlValue& value : in_file.values) keys.insert(value.key);
            out += table_text<RenderConfig>("[[view]]", in_file, file_, view, kOwnedOfView, keys);
            ++step;
        }
        return out;
    }

    fs::path file_;
    TomlTable root_;
    Job job_;
    NoKeys none_;
    OutputTable output_;
    std::size_t n_clouds_ = 1;
};

}  // namespace

std::string resolved_job(const fs::path& file, const std::vector<std::string>& settings) {
    return JobPrinter(file, settings).text();
}

}  // namespace slim
