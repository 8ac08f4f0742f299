#include "pipeline/job/job.h"

#include "pipeline/build/build_checks.h"
#include "pipeline/build/build_stage.h"
#include "pipeline/build/fit_stage.h"
#include "pipeline/build/normals_stage.h"
#include "pipeline/build/slice_stage.h"
#include "pipeline/job/job_own_keys.h"
#include "pipeline/job/job_tables.h"
#include "pipeline/job/job_view_reader.h"
#include "pipeline/manifest.h"
#include "pipeline/measure/measure_stage.h"
#include "pipeline/scan_stage.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace slim {
namespace {

namespace fs = std::filesystem;

/// The tables of a job file, found by name and strictly known.
class JobReader {
public:
    JobReader(const fs::path& file, const std::vector<std::string>& settings)
        : file_(file), root_(read_toml(file)) {
        for (const std::string& setting : settings) set_value(root_, setting);
        job_.settings = settings;
    }

    Job read() {
        read_frame();
        read_input();
        read_fit();
        read_measure();
        read_job_views({file_, root_, output_.aovs, model_}, job_);
        note_left_out();
        return std::move(job_);
    }

    /// The views of a model that is there.
    Job read_drawing(const JobDrawing& drawing) {
        const auto n_views = std::count_if(root_.tables.begin(), root_.tables.end(),
                                           [](const TomlTable& t) { return t.name == "view"; });
        override_views(root_, drawing.options);
        read_frame();
        if (n_views == 0)
            throw ConfigError(
                {.file = file_.string(), .problem = "no [[view]]: there is nothing to draw"});
        if (n_views > 1 && !drawing.picture.empty())
            throw ConfigError({.file = file_.string(),
                               .problem = fmt::format("its {} views cannot all be {}", n_views,
                                                      drawing.picture.string()),
                               .expected = "a folder to write them into"});
        job_.folder = drawing.folder, job_.stages = drawing.stages;
        read_job_views({file_, root_, output_.aovs, drawing.model, drawing.picture,
                        !drawing.options.empty()},
                       job_);
        return std::move(job_);
    }

private:
    /// What every reading of a job begins with: its tables are known, and where it writes.
    void read_frame() {
        check_tables(root_, kJobTables);
        check_top_keys(root_, file_);
        job_.file = file_;
        read_output();
    }

    const TomlTable* find(const TomlTable& in, const std::string& name) const {
        return find_table(in, name, file_);
    }
    void check_tables(const TomlTable& in, const std::vector<std::string>& known) const {
        slim::check_tables(in, known, file_);
    }

    void read_output() {
        if (const TomlTable* table = find(root_, "output")) {
            check_tables(*table, {});
            apply_table(*table, fields_of(output_), file_);
            require_words(*table, "title");
        }
        const fs::path stem = file_.stem();
        job_.folder =
            output_.dir.empty() ? file_.parent_path() / "out" / stem : fs::path(output_.dir);
        job_.title = output_.title.empty() ? stem.string() : output_.title;
        job_.html = output_.html;
    }

    /// Words that are never a number's: one without quotes is a slip (not after --set, which has
    /// none).
    void require_words(const TomlTable& table, const char* key) const {
        for (const TomlValue& value : table.values)
            if (value.key == key && value.kind != Field::Kind::text && value.line > 0)
                throw ConfigError({.file = file_.string(),
                                   .line = value.line,
                                   .key = key,
                                   .expected = "a string",
                                   .found = value.items[0]});
    }

    void read_input() {
        const TomlTable* table = find(root_, "input");
        if (!table)
            throw ConfigError({.file = file_.string(),
                               .problem = "no [input]",
                               .expected = "files = [...] or a scan"});
        check_tables(*table, {"scan"});
        InputTable input;
        apply_table(*table, fields_of(input), file_);
        const TomlTable* scan = find(*table, "scan");
        if (input.files.empty() == (scan == nullptr))
            throw ConfigError({.key = "[input]", .expected = "either files or a scan"})
                .at(toml_fault(file_, table->line));
        for (const std::string& name : input.files) clouds_.push_back(name);
        if (scan) read_scan(*scan);
    }

    void read_scan(const TomlTable& table) {
        NoKeys none;
        JobStep step{"scan", "scan", read_options<ScanConfig>(table, file_, none, kOwnedOfScan),
                     {},     {},     {},
                     {}};
        check_options_of<ScanConfig>(table, check_scan_options);
        // The shape is a word of slim-scan, not an option.
        for (std::string& option : step.arguments)
            if (option.starts_with("--shape=")) option = option.substr(8);
        step.output = job_.folder / "cloud.ply";
        add_step_output(step, job_);
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
        append_arguments(step, read_options<BuildConfig>(table, file_, none, kOwnedOfFit));
        const auto config = check_options_of<BuildConfig>(table, check_build_options);
        if (!config.sensors.empty()) step.inputs.emplace_back(config.sensors);
        add_step_output(step, job_);
        job_.steps.push_back(std::move(step));
        read_build_stages(table);
    }

    /// What a verb would refuse of its table once it runs, said where the table says it.
    template <class Config>
    Config check_options_of(const TomlTable& table, void (*check)(const Config&)) const {
        Config config;
        apply_table(table, fields_of(config), file_);
        try {
            check(config);
        } catch (const ConfigError& error) {
            Fault place = toml_fault(file_, table.line);
            for (const TomlValue& value : table.values)
                if (value.key == error.fault().key) place = toml_fault(file_, value.line);
            throw error.at(place);
        }
        return config;
    }

    /// The same options dealt out to the single stages, which know them by the same keys.
    void read_build_stages(const TomlTable& table) {
        BuildConfig build;
        apply_table(table, fields_of(build), file_);
        BuildStages& stages = job_.stages;
        stages.work = build.work.empty() ? model_.string() + ".work" : build.work;
        stages.slice_target = manifest_path(stages.work, "slice");
        stages.estimate_normals = build.normals == "estimate";
        stages.memory = build.memory;
        stages.degree = build.degree, stages.color = build.color,
        stages.sharp = build.radius_rule == "windows" ? "off" : build.sharp;
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

    void read_measure() {
        const TomlTable* table = find(root_, "measure");
        if (!table) {
            job_.left_out.push_back("measure: there is no [measure]");
            return;
        }
        check_tables(*table, {});
        NoKeys none;
        const std::set<std::string> owned = owned_of_measure(clouds_.size());
        const std::vector<std::string> options =
            read_options<MeasureConfig>(*table, file_, none, owned);
        const auto config = check_options_of<MeasureConfig>(*table, check_measure_options);
        std::set<std::string> names;
        for (const fs::path& cloud : clouds_) {
            JobStep step{
                "measure", "measure", {model_.string(), cloud.string()}, {model_, cloud}, {},
                {},        {}};
            if (clouds_.size() > 1)
                step.name = numbered("measure " + cloud.filename().string(), names);
            if (!config.truth.empty()) step.inputs.emplace_back(config.truth);
            step.line = table->line;
            append_arguments(step, options);
            step.output = job_.folder / (file_name(step.name) + ".json");
            add_step_output(step, job_);
            job_.steps.push_back(std::move(step));
        }
    }

    static std::string file_name(std::string name) {
        std::replace(name.begin(), name.end(), ' ', '_');
        return name;
    }

    /// The name, with a number if its file is taken: clouds of several folders may be named alike.
    static std::string numbered(const std::string& name, std::set<std::string>& taken) {
        std::string out = name;
        for (int k = 2; !taken.insert(file_name(out)).second; ++k)
            out = fmt::format("{} {}", name, k);
        return out;
    }

    void note_left_out() {
        if (!job_.html) job_.left_out.push_back("index.html: output.html is false");
        if (job_.steps[0].verb != "scan") job_.left_out.push_back("scan: the input is files");
    }

    fs::path file_;
    TomlTable root_;
    OutputTable output_;
    Job job_;
    std::vector<fs::path> clouds_;
    fs::path model_;
};

}  // namespace

fs::path page_target(const Job& job) { return manifest_path(job.folder, "run"); }

namespace {

Job unless_refused(Job job) {
    if (!job.refused.empty()) throw ConfigError(job.refused[0]);
    return job;
}

}  // namespace

Job read_job(const fs::path& file, const std::vector<std::string>& settings) {
    return unless_refused(read_job_to_explain(file, settings));
}

Job read_job_to_explain(const fs::path& file, const std::vector<std::string>& settings) {
    return JobReader(file, settings).read();
}

Job read_drawing(const fs::path& file, const JobDrawing& drawing) {
    return unless_refused(JobReader(file, {}).read_drawing(drawing));
}

std::string model_remedy(const BuildStages& stages, const std::string& key,
                         const std::string& value) {
    const bool is_flag = value == "true";
    if (stages.given)
        return fmt::format("a model built with --{}{}", key, is_flag ? "" : " " + value);
    const bool is_word = !is_flag && value.find_first_not_of("0123456789") != std::string::npos;
    return fmt::format("{} = {} in [fit]", key, is_word ? "\"" + value + "\"" : value);
}

}  // namespace slim
