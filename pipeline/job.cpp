#include "pipeline/job.h"

#include "pipeline/build_stage.h"
#include "pipeline/fit_stage.h"
#include "pipeline/job_views.h"
#include "pipeline/manifest.h"
#include "pipeline/measure_stage.h"
#include "pipeline/normals_stage.h"
#include "pipeline/ray_options.h"
#include "pipeline/render_config.h"
#include "pipeline/render_lights.h"
#include "pipeline/scan_stage.h"
#include "pipeline/slice_stage.h"
#include "pipeline/toml_file.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>

namespace slim {
namespace {

namespace fs = std::filesystem;

struct InputTable {
    std::vector<std::string> files;
    template <class V>
    void visit(V&& field) {
        field.path("files", files, "point clouds");
    }
};

struct OutputTable {
    std::string dir;
    std::string title;
    std::vector<std::string> aovs = {"shaded"};
    bool html = true;
    template <class V>
    void visit(V&& field) {
        field.path("dir", dir, "folder for everything that is written");
        field("title", title, "heading of the page");
        field("aovs", aovs, "pictures of every view that names none");
        field("html", html, "write DIR/index.html");
    }
};

/// The keys of a view that are the job's own; the others are options of slim-render.
struct ViewTable {
    std::string name;
    std::vector<std::string> aovs;
    template <class V>
    void visit(V&& field) {
        field("name", name, "begins the names of the view's pictures");
        field("aovs", aovs, "pictures of this view");
    }
};

std::string place(const fs::path& file, const TomlTable& table) {
    return table.line > 0 ? fmt::format("{}:{}", file.string(), table.line)
                          : file.string() + ", --set";
}

/// A field's value as one option, or one per path.
void append_option(const Field& field, std::vector<std::string>& out) {
    if (field.is_flag()) {
        const bool on = field.items()[0] == "true";
        out.push_back(on ? field.option() : "--no-" + field.option().substr(2));
    } else if (field.is_path()) {
        for (const std::string& item : field.items()) out.push_back(field.option() + "=" + item);
    } else {
        out.push_back(fmt::format("{}={}", field.option(), fmt::join(field.items(), ",")));
    }
}

/// Checks a table against the fields of a verb and of the job's own part of it, and returns the
/// verb's as command-line options. `owned` are the verb's keys that the job fills in itself.
template <class Config, class Own>
std::vector<std::string> read_options(const TomlTable& table, const fs::path& file, Own& own,
                                      const std::set<std::string>& owned) {
    Config config;
    FieldList all;
    own.visit(all);
    FieldList verb = fields_of(config);
    for (const Field& field : verb.fields())
        if (!owned.contains(field.key)) all.append(field);
    apply_table(table, all, file);
    std::vector<std::string> options;
    for (const TomlValue& value : table.values)
        if (const Field* field = verb.find(value.key); field && !fields_of(own).find(value.key))
            append_option(*field, options);
    return options;
}

struct NoKeys {
    template <class V>
    void visit(V&&) {}
};

/// The tables of a job file, found by name and strictly known.
class JobReader {
public:
    JobReader(const fs::path& file, const std::vector<std::string>& settings)
        : file_(file), root_(read_toml(file)) {
        for (const std::string& setting : settings) set_value(root_, setting);
        job_.settings = settings;
    }

    Job read() {
        check_tables(root_, {"input", "fit", "render", "light", "view", "output", "measure"});
        if (!root_.values.empty())
            throw ConfigError(fmt::format(
                "{}:{}: unknown key '{}': keys stand in the tables input, fit, render, light, view, "
                "output and measure",
                file_.string(), root_.values[0].line, root_.values[0].key));
        job_.file = file_;
        read_output();
        read_input();
        read_fit();
        read_measure();
        read_views();
        note_left_out();
        return std::move(job_);
    }

private:
    const TomlTable* find(const TomlTable& in, const std::string& name) const {
        const TomlTable* found = nullptr;
        for (const TomlTable& table : in.tables) {
            if (table.name != name) continue;
            if (found)
                throw ConfigError(fmt::format("{}: a second [{}]", place(file_, table), name));
            found = &table;
        }
        return found;
    }

    void check_tables(const TomlTable& in, const std::vector<std::string>& known) const {
        for (const TomlTable& table : in.tables)
            if (std::find(known.begin(), known.end(), table.name) == known.end())
                throw ConfigError(fmt::format("{}: unknown table [{}]{}", place(file_, table),
                                              table.name, suggestion(table.name, known)));
    }

    void read_output() {
        if (const TomlTable* table = find(root_, "output")) {
            check_tables(*table, {});
            apply_table(*table, fields_of(output_), file_);
        }
        const fs::path stem = file_.stem();
        job_.folder =
            output_.dir.empty() ? file_.parent_path() / "out" / stem : fs::path(output_.dir);
        job_.title = output_.title.empty() ? stem.string() : output_.title;
        job_.html = output_.html;
    }

    void read_input() {
        const TomlTable* table = find(root_, "input");
        if (!table)
            throw ConfigError(fmt::format("{}: no [input]: expected files = [...] or a scan",
                                          file_.string()));
        check_tables(*table, {"scan"});
        InputTable input;
        apply_table(*table, fields_of(input), file_);
        const TomlTable* scan = find(*table, "scan");
        if (input.files.empty() == (scan == nullptr))
            throw ConfigError(fmt::format("{}: [input]: expected either files or a scan",
                                          place(file_, *table)));
        for (const std::string& name : input.files) clouds_.push_back(name);
        if (scan) read_scan(*scan);
    }

    void read_scan(const TomlTable& table) {
        NoKeys none;
        JobStep step{"scan", "scan", read_options<ScanConfig>(table, file_, none, {"output"}),
                     {},     {},     {},
                     {}};
        // The shape is a word of slim-scan, not an option.
        for (std::string& option : step.arguments)
            if (option.starts_with("--shape=")) option = option.substr(8);
        step.output = job_.folder / "cloud.ply";
        add_output(step);
        clouds_.push_back(step.output);
        job_.steps.push_back(std::move(step));
    }

    void read_fit() {
        static const TomlTable empty;
        const TomlTable* found = find(root_, "fit");
        const TomlTable& table = found ? *found : empty;
        check_tables(table, {});
        model_ = job_.folder / "model.slim";
        JobStep step{"build", "build", {}, clouds_, model_, {}, {}};
        for (const fs::path& cloud : clouds_) step.arguments.push_back(cloud.string());
        NoKeys none;
        append(step, read_options<BuildConfig>(table, file_, none, {"inputs", "output"}));
        add_output(step);
        job_.steps.push_back(std::move(step));
        read_build_stages(table);
    }

    /// The same options dealt out to the single stages, which know them by the same keys.
    void read_build_stages(const TomlTable& table) {
        BuildConfig build;
        apply_table(table, fields_of(build), file_);
        BuildStages& stages = job_.stages;
        stages.work = build.work.empty() ? model_.string() + ".work" : build.work;
        stages.slice_target = manifest_path(stages.work, "slice");
        stages.estimate_normals = build.normals == "estimate";
        for (const fs::path& cloud : clouds_) stages.slice.push_back(cloud.string());
        stages.slice.insert(stages.slice.end(), {"-o", stages.work.string()});
        append_shared<SliceConfig>(stages.slice, table, build);
        stages.normals = stages.fit = {stages.work.string()};
        append_shared<NormalsConfig>(stages.normals, table, build);
        append_shared<FitConfig>(stages.fit, table, build);
    }

    /// Those options of [fit] that the stage has too.
    template <class Config>
    static void append_shared(std::vector<std::string>& arguments, const TomlTable& table,
                              BuildConfig& build) {
        Config config;
        const FieldList stage = fields_of(config);
        const FieldList all = fields_of(build);
        for (const TomlValue& value : table.values)
            if (value.key != "work" && stage.find(value.key))
                append_option(*all.find(value.key), arguments);
    }

    static void append(JobStep& step, const std::vector<std::string>& arguments) {
        step.arguments.insert(step.arguments.end(), arguments.begin(), arguments.end());
    }

    void read_measure() {
        const TomlTable* table = find(root_, "measure");
        if (!table) {
            job_.left_out.push_back("measure: there is no [measure]");
            return;
        }
        check_tables(*table, {});
        NoKeys none;
        std::set<std::string> owned = {"model", "cloud", "output"};
        if (clouds_.size() > 1) owned.insert("per_point");  // one file for one cloud
        const std::vector<std::string> options = read_options<MeasureConfig>(*table, file_, none, owned);
        for (const fs::path& cloud : clouds_) {
            JobStep step{
                "measure", "measure", {model_.string(), cloud.string()}, {model_, cloud}, {},
                {},        {}};
            if (clouds_.size() > 1) step.name += " " + cloud.filename().string();
            append(step, options);
            std::string name = step.name + ".json";
            std::replace(name.begin(), name.end(), ' ', '_');
            step.output = job_.folder / name;
            add_output(step);
            job_.steps.push_back(std::move(step));
        }
    }

    void read_views() {
        ViewTable none;
        std::vector<std::string> defaults;
        if (const TomlTable* table = find(root_, "render")) {
            defaults = read_options<RenderConfig>(*table, file_, none, kOwnedByView);
            check_view(*table, render_);
        }
        read_lights(defaults);
        for (const TomlTable& table : root_.tables)
            if (table.name == "view") read_view(table, defaults);
        if (names_.empty()) job_.left_out.push_back("pictures: there is no [[view]]");
    }

    /// [[light]] tables say what --light says in one line: kind = "sun", azimuth = 300.
    void read_lights(std::vector<std::string>& defaults) {
        std::string all;
        for (const TomlTable& table : root_.tables) {
            if (table.name != "light") continue;
            check_tables(table, {});
            std::string kind, words;
            for (const TomlValue& value : table.values) {
                const std::string text = fmt::format("{}", fmt::join(value.items, ","));
                if (value.key == "kind") kind = text;
                else words += fmt::format(" {}={}", value.key, text);
            }
            try {
                check_lights(kind + words);
            } catch (const ConfigError& error) {
                throw ConfigError(fmt::format("{}: {}", place(file_, table), error.what()));
            }
            all += (all.empty() ? "" : "; ") + kind + words;
        }
        if (all.empty()) return;
        if (render_.light != RenderConfig{}.light)
            throw ConfigError(file_.string() + ": both [[light]] tables and light in [render]: expected one of the two");
        render_.light = all;
        defaults.push_back("--light=" + all);
    }

    void read_view(const TomlTable& table, const std::vector<std::string>& defaults) {
        check_tables(table, {});
        ViewTable view;
        const std::vector<std::string> own =
            read_options<RenderConfig>(table, file_, view, kOwnedByView);
        RenderConfig render = render_;
        check_view(table, render);
        if (view.aovs.empty()) view.aovs = output_.aovs;
        check_aovs(view.aovs, table);
        std::vector<std::string> options = options_for(view.aovs, defaults, own);
        options.insert(options.end(), own.begin(), own.end());
        if (view.name.empty()) view.name = name_of(options);
        if (!names_.insert(view.name).second)
            throw ConfigError(fmt::format("{}: a second view of the name '{}'", place(file_, table),
                                          view.name));
        aovs_.insert(view.aovs.begin(), view.aovs.end());
        note_rays(render, view.aovs, table);
        JobStep step{"view " + view.name, "render", {model_.string()}, {model_}, {}, {}, {}};
        for (const fs::path& file : files_read(options)) step.inputs.push_back(file);
        append(step, options);
        step.arguments.push_back(fmt::format("--aov={}", fmt::join(view.aovs, ",")));
        // Several AOVs become name.shaded.png, name.mean.png; one is to be named alike.
        const std::string aov = view.aovs.size() == 1 ? "." + view.aovs[0] : "";
        step.output = job_.folder / (view.name + aov + ".png");
        add_output(step);
        step.products = view_pictures(job_.folder, view.name, view.aovs, render);
        lines_ = lines_ || !render.lines.empty() ||
                 std::find(view.aovs.begin(), view.aovs.end(), "lines") != view.aovs.end();
        job_.steps.push_back(std::move(step));
    }

    /// Checks what only rays can do, and notes what rays are asked for.
    void note_rays(const RenderConfig& render, const std::vector<std::string>& aovs, const TomlTable& table) {
        try {
            check_tracing(render, aovs);
        } catch (const ConfigError& error) {
            throw ConfigError(fmt::format("{}: {}", place(file_, table), error.what()));
        }
        const bool cast = render.mode == "raytrace", shaded = std::find(aovs.begin(), aovs.end(), "shaded") != aovs.end();
        rays_ = rays_ || cast;
        shadows_ = shadows_ || (cast && render.shadows && shaded);
        openness_ = openness_ || render.ao || std::find(aovs.begin(), aovs.end(), "ao") != aovs.end();
    }

    void check_view(const TomlTable& table, RenderConfig& config) const {
        const FieldList fields = fields_of(config);
        for (const TomlValue& value : table.values)
            if (const Field* field = fields.find(value.key)) field->set(value.items, value.key);
        check_view_keys(config, [&](const char* key, const std::function<void()>& check) {
            for (const TomlValue& value : table.values) {
                if (value.key != key) continue;
                try {
                    check();
                } catch (const ConfigError& error) {
                    const TomlTable at{key, value.line, {}, {}};
                    throw ConfigError(fmt::format("{}: {}", place(file_, at), error.what()));
                }
            }
        });
    }

    void check_aovs(const std::vector<std::string>& aovs, const TomlTable& table) const {
        RenderConfig render;
        fields_of(render).find("aov")->set(aovs, place(file_, table) + ": aovs");
    }

    /// A view without a name takes its camera's, "view" if that is given by numbers.
    static std::string name_of(const std::vector<std::string>& options) {
        std::string camera = RenderConfig{}.camera;
        for (const std::string& option : options)
            if (option.starts_with("--camera=")) camera = option.substr(9);
        return camera.find(',') == std::string::npos ? camera : "view";
    }

    void note_left_out() {
        RenderConfig render;
        const FieldList fields = fields_of(render);
        if (!asks({"mean", "gauss", "k1", "k2", "dir1", "dir2", "e1", "e2", "dk1_dt2", "dk2_dt1",
                   "all"}) &&
            !lines_)
            job_.left_out.push_back("curvature: no AOV asks for it (no second derivatives)");
        if (!asks({"e1", "e2", "dk1_dt2", "dk2_dt1", "all"}) && !lines_)
            job_.left_out.push_back("third derivatives: no AOV asks for them");
        if (!lines_) job_.left_out.push_back("feature lines: no view asks for them");
        if (!rays_) job_.left_out.push_back("rays: no view has mode = \"raytrace\"");
        else if (!shadows_) job_.left_out.push_back("shadows: no shaded view asks for them");
        if (rays_ && !openness_) job_.left_out.push_back("ambient occlusion: no view asks for it");
        std::vector<std::string> rest;
        if (const Field* aov = fields.find("aov"); !aovs_.contains("all"))
            for (const std::string& name : aov->choices)
                if (name != "all" && name != "lines" && !aovs_.contains(name)) rest.push_back(name);
        if (!rest.empty())
            job_.left_out.push_back(fmt::format("pictures of {}: no view asks for them",
                                                fmt::join(rest, ", ")));
        if (!job_.html) job_.left_out.push_back("index.html: output.html is false");
        if (job_.steps[0].verb != "scan")
            job_.left_out.push_back("scan: the input is files");
    }

    bool asks(const std::vector<std::string>& names) const {
        return std::any_of(names.begin(), names.end(),
                           [&](const std::string& name) { return aovs_.contains(name); });
    }

    static void add_output(JobStep& step) {
        step.arguments.push_back("-o");
        step.arguments.push_back(step.output.string());
        step.target = manifest_path(step.output);
        step.products = {step.output};
    }

    inline static const std::set<std::string> kOwnedByView = {"model", "output", "aov"};

    fs::path file_;
    TomlTable root_;
    OutputTable output_;
    Job job_;
    std::vector<fs::path> clouds_;
    fs::path model_;
    RenderConfig render_;  // with what [render] and the lights say
    bool rays_ = false, shadows_ = false, openness_ = false;
    std::set<std::string> names_;
    std::set<std::string> aovs_;
    bool lines_ = false;  // does any view show feature lines?
};

}  // namespace

fs::path page_target(const Job& job) { return manifest_path(job.folder, "run"); }

Job read_job(const fs::path& file, const std::vector<std::string>& settings) {
    return JobReader(file, settings).read();
}

}  // namespace slim
