#include "pipeline/report/report_jobs.h"

#include "pipeline/input_kind.h"
#include "pipeline/job/job_source.h"
#include "pipeline/job/job_steps.h"
#include "pipeline/manifest.h"
#include "pipeline/run_started.h"
#include "pipeline/signals.h"
#include "pipeline/toml_file.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace slim {
namespace {

namespace fs = std::filesystem;

constexpr const char* kName = "jobs";

bool has_table(const TomlTable& root, const std::string& name) {
    return std::any_of(root.tables.begin(), root.tables.end(),
                       [&](const TomlTable& table) { return table.name == name; });
}

/// What formulas call the steps: "view_front" of "view front". Steps of one name are one figure in
/// the rows of all jobs.
class StepNames {
public:
    struct Named {
        std::string step, verb, identifier;
    };

    explicit StepNames(const std::vector<Job>& jobs) {
        for (const Job& job : jobs)
            for (const JobStep& step : job.steps) add(step);
    }
    const std::vector<Named>& all() const { return all_; }
    std::vector<Named> of_verb(const std::string& verb) const {
        std::vector<Named> out;
        for (const Named& named : all_)
            if (named.verb == verb) out.push_back(named);
        return out;
    }
    const Named* find(const JobStep& step) const {
        for (const Named& named : all_)
            if (named.step == step.name) return &named;
        return nullptr;
    }

private:
    void add(const JobStep& step) {
        if (find(step)) return;
        std::string plain = step.name;
        for (char& c : plain)
            if (!(c >= 'a' && c <= 'z') && !(c >= '0' && c <= '9')) c = '_';
        std::string identifier = plain;
        for (int k = 2; !taken_.insert(identifier).second; ++k)
            identifier = fmt::format("{}_{}", plain, k);
        all_.push_back({step.name, step.verb, identifier});
    }

    std::vector<Named> all_;
    std::set<std::string> taken_;
};

std::string name_of(const Job& job) { return job.file.stem().string(); }

/// "front" of "view front", "scan.ply" of "measure scan.ply".
std::string object_of(const std::string& step) { return step.substr(step.find(' ') + 1); }

/// What headings say of a measure beside others: ", scan.ply".
std::string said_of(const StepNames::Named& measure, std::size_t n_measures) {
    return n_measures > 1 ? ", " + object_of(measure.step) : "";
}

void add_column(Experiment& e, const std::string& heading, const std::string& formula) {
    e.columns.emplace_back(heading, Expression(formula, heading));
}

void add_model_columns(Experiment& e) {
    for (const char* figure : {"points", "leaves", "bytes"})
        add_column(e, figure, std::string("build.") + figure);
    for (const char* stage : {"slice", "normals", "fit", "tree"})
        add_column(e, fmt::format("{}, s", stage), fmt::format("build.stages.{}.seconds", stage));
    add_column(e, "build, s", "build.seconds");
    add_column(e, "points / s", "build.points / build.seconds");
}

void add_error_columns(Experiment& e, const std::vector<StepNames::Named>& measures) {
    for (const auto& measure : measures)
        for (const auto& [heading, figure] : {std::pair{"L2 / L", "l2"},
                                              {"max / L", "max"},
                                              {"normals, deg", "normal_rms_deg"},
                                              {"completeness", "completeness"}})
            add_column(e, heading + said_of(measure, measures.size()),
                       measure.identifier + "." + figure);
}

void add_views(Experiment& e, const std::vector<StepNames::Named>& views) {
    for (const auto& view : views) {
        add_column(e, object_of(view.step) + ", ms a frame",
                   view.identifier + ".frame_ms_median");
        e.pictures.push_back({view.identifier, "{job}, " + object_of(view.step), {}, kName});
    }
}

void add_error_plots(Experiment& e, const std::vector<StepNames::Named>& measures) {
    for (const auto& measure : measures)
        for (const auto& [label, figure] : {std::pair{"L2 / L", "l2"}, {"max / L", "max"}}) {
            ReportPlot plot;
            plot.x_label = "build, s", plot.y_label = label + said_of(measure, measures.size());
            plot.title = plot.where = plot.y_label + " over the seconds of the build";
            plot.x = Expression("build.seconds", plot.title);
            plot.y = Expression(measure.identifier + "." + figure, plot.title);
            plot.series = "{job}";
            e.plots.push_back(std::move(plot));
        }
}

/// Runs a step; one that fails is a record that is not done.
StepRecord done(const JobStep& step, const std::string& identifier, const Job& job,
                StageContext& context, StepCounts& counts) {
    StepRecord record;
    record.step = identifier, record.run = step.verb;
    record.name = name_of(job) + "/" + step.name, record.output = step.output.string();
    record.figures = nlohmann::json::object();
    record.run_started = run_started();
    try {
        StepOutcome outcome = run_step(step, context);
        record.figures = std::move(outcome.result);
        record.figures["seconds"] = outcome.seconds;
        record.figures["peak_memory_bytes"] = outcome.peak_memory_bytes;
        record.run_started = outcome.run_started;
        record.done = true;
        ++(outcome.up_to_date ? counts.reused : counts.run);
    } catch (const Interrupted&) {
        throw;
    } catch (const Error& error) {
        record.reason = error.what();
        ++counts.run;
    }
    return record;
}

}  // namespace

bool is_ordinary_job(const fs::path& file) {
    const TomlTable root = read_toml(file);
    if (has_table(root, "experiment") || has_table(root, "values")) return false;
    for (const char* table : {"input", "fit", "view", "render", "measure"})
        if (has_table(root, table)) return true;
    return false;
}

std::vector<Job> read_report_jobs(const std::vector<std::string>& files, const fs::path& folder,
                                  const std::vector<std::string>& settings) {
    std::vector<Job> jobs;
    std::map<std::string, std::string> named;
    for (const std::string& file : files) {
        const std::string name = fs::path(file).stem().string();
        if (const auto [other, is_new] = named.emplace(name, file); !is_new)
            throw ConfigError(
                fmt::format("{} and {}: expected jobs of different names", other->second, file));
        std::vector<std::string> changes = settings;
        if (!has_table(read_toml(file), "measure"))  // its errors are what is asked for
            changes.insert(changes.begin(), "measure.two_way=false");
        jobs.push_back(read_job(file, job_settings({file, {}, (folder / name).string(), changes})));
        require_inputs(jobs.back());
    }
    return jobs;
}

ReportFile experiment_of_jobs(const std::vector<Job>& jobs) {
    const StepNames names(jobs);
    Experiment e;
    e.name = "rows", e.where = kName;
    e.title = "Error against run time";
    e.text = "L: diagonal of the input's box. Seconds are those of each step's manifest, whether "
             "it was done now or was up to date.";
    e.grid.emplace_back("job", std::vector<FigureValue>{});
    std::string hashes;
    for (const Job& job : jobs) {
        e.grid[0].second.emplace_back(name_of(job));
        hashes += fmt::format("{} {}\n", hash_file(job.file), fmt::join(job.settings, " "));
    }
    for (const auto& named : names.all()) {
        ReportStep step;
        step.name = named.identifier, step.run = named.verb, step.where = kName;
        e.steps.push_back(std::move(step));
    }
    add_model_columns(e);
    add_error_columns(e, names.of_verb("measure"));
    add_views(e, names.of_verb("render"));
    add_error_plots(e, names.of_verb("measure"));
    ReportFile out;
    out.name = kName, out.title = "Jobs", out.hash = hash_text(hashes);
    out.experiments.push_back(std::move(e));
    return out;
}

ExperimentResult run_jobs(const Experiment& experiment, const std::vector<Job>& jobs,
                          StageContext& context, StepCounts& counts) {
    const StepNames names(jobs);
    ExperimentResult result;
    result.experiment = &experiment;
    for (const Job& job : jobs) {
        ReportRow row;
        row.parameters.emplace_back("job", FigureValue(name_of(job)));
        make_writable_folder(job.folder);
        context.reporter.info(job.file.string());
        for (const JobStep& step : job.steps) {
            StepRecord record = done(step, names.find(step)->identifier, job, context, counts);
            const bool goes_on = record.done;
            row.steps.push_back(std::move(record));
            if (!goes_on) break;
        }
        result.rows.push_back(std::move(row));
    }
    judge(result);
    return result;
}

}  // namespace slim
