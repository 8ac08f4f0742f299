#include "pipeline/report/report_stage.h"

#include "formats/atomic_file.h"
#include "formats/made_folders.h"
#include "pipeline/folder_lock.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "pipeline/report/report_jobs.h"
#include "pipeline/report/report_names.h"
#include "pipeline/report/report_page.h"
#include "pipeline/report/report_steps.h"
#include "pipeline/version.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kMostNamed = 5;  // figures in the error message

/// Why an experiment cannot be run: a file that it needs and that is not there.
std::string missing_file(const Experiment& e, const ReportRow& row) {
    for (const std::string& needed : e.needs) {
        const std::string file = row.text(needed, 17, e.where);
        if (file.empty() || !fs::exists(file)) return "'" + file + "' is not there";
    }
    return "";
}

ExperimentResult run_experiment(const Experiment& e, const ReportFile& file,
                                const ReportConfig& config, StepRunner& runner) {
    ExperimentResult result;
    result.experiment = &e;
    auto values = file.values;
    values.emplace_back("seed", FigureValue(static_cast<double>(config.seed)));
    result.rows = rows_of(e, values, static_cast<double>(config.cap));
    if (result.rows.empty())
        result.left_out = "no row is within `when` and the cap of points";
    else
        result.left_out = missing_file(e, result.rows[0]);
    if (!result.left_out.empty())
        result.rows.clear();
    for (ReportRow& row : result.rows) runner.run(e, row);
    check_columns(e, result.rows);
    judge(result);
    return result;
}

json provenance_of(const ReportConfig& config, const std::vector<ReportFile>& files, int threads) {
    json configurations = json::object();
    for (const ReportFile& file : files) configurations[file.name] = file.hash;
    return {{"version", program_version()},
            {"machine", machine_json()},
            {"threads", threads},
            {"seed", config.seed},
            {"cap", config.cap},
            {"configurations", configurations}};
}

std::vector<fs::path> write_report(const Report& report, const fs::path& folder) {
    std::vector<fs::path> written;
    const auto write = [&](const std::string& name, const std::string& bytes) {
        written.push_back(folder / name);
        write_file_atomically(written.back().string(), bytes);
    };
    write("index.html", report_page(report));
    write("report.json", text_of(report_json(report), 1) + "\n");
    for (std::size_t i = 0; i < report.files.size(); ++i)
        for (const ExperimentResult& result : report.results[i])
            if (!result.experiment->columns.empty() && !result.rows.empty())
                write(fmt::format("{}.{}.csv", report.files[i].name, result.experiment->name),
                      rows_csv(result));
    return written;
}

/// "2 of 9 figures left their bands", "1 step failed", or both.
std::string what_failed(std::size_t n_left, std::size_t n_figures, std::size_t n_steps) {
    std::string text;
    if (n_left > 0) text = fmt::format("{} of {} figures left their bands", n_left, n_figures);
    if (n_steps > 0)
        text += fmt::format("{}{} step{} failed", n_left > 0 ? ", and " : "", n_steps,
                            n_steps == 1 ? "" : "s");
    return text;
}

void fail_if_left(const Report& report, const std::string& page) {
    std::vector<std::string> left;
    std::size_t n_steps = 0, n_figures = 0;
    for (const CheckResult* check : report.checks()) {
        n_figures += check->is_step ? 0 : 1;
        if (check->verdict != Verdict::failed) continue;
        n_steps += check->is_step ? 1 : 0;
        left.push_back(check->sentence());
    }
    if (left.empty()) return;
    const std::size_t n = left.size();
    left.resize(std::min(n, kMostNamed));
    throw NumericalError(
        fmt::format("{}: {}{}; all are in {}", what_failed(n - n_steps, n_figures, n_steps),
                    fmt::join(left, "; "),
                    n > kMostNamed ? fmt::format("; and {} more", n - kMostNamed) : "", page));
}

/// What is given, by kind: jobs are run as they are, report files say what to run.
struct GivenFiles {
    std::vector<std::string> reports, jobs;
    std::vector<std::string> values, changes;  ///< --set values.KEY, and TABLE.KEY of jobs
};

GivenFiles sorted(const ReportConfig& config) {
    GivenFiles out;
    for (const std::string& file : config.files)
        (is_ordinary_job(file) ? out.jobs : out.reports).push_back(file);
    for (const std::string& setting : config.settings) {
        const bool is_of_jobs = !out.jobs.empty() && !setting.starts_with("values.");
        (is_of_jobs ? out.changes : out.values).push_back(setting);
    }
    return out;
}

void check_files(const std::vector<ReportFile>& files) {
    for (std::size_t i = 0; i < files.size(); ++i)
        for (std::size_t k = 0; k < i; ++k)
            if (files[i].name == files[k].name)
                throw ConfigError(fmt::format("{} and {}: expected report files of different names",
                                              files[k].file.string(), files[i].file.string()));
}

}  // namespace

json run_report(const ReportConfig& config, StageContext& context) {
    const fs::path folder = fs::absolute(config.output).lexically_normal();
    for (const std::string& programs : config.programs)
        if (!fs::is_directory(programs))
            throw ConfigError(
                {.key = "programs", .expected = "folders", .found = "'" + programs + "'"});
    const GivenFiles given = sorted(config);
    Report report;
    report.files = read_report_files(given.reports, given.values);
    const std::vector<Job> jobs = read_report_jobs(given.jobs, folder / "jobs", given.changes);
    if (!jobs.empty()) report.files.push_back(experiment_of_jobs(jobs));
    check_files(report.files);
    const FolderLock lock(folder.string());
    make_folders((folder / "steps").string());
    Stamp stamp(context, manifest_path(folder, "report"));
    for (const std::string& file : config.files) stamp.input(file);
    for (const std::string& setting : config.settings) stamp.depends("--set " + setting);

    StepRunner runner({folder / "steps", config.seed, config.programs}, context);
    StepCounts of_jobs;
    for (std::size_t i = 0; i < report.files.size(); ++i) {
        const bool is_of_jobs = !jobs.empty() && i + 1 == report.files.size();
        report.results.emplace_back();
        for (const Experiment& e : report.files[i].experiments)
            report.results.back().push_back(
                is_of_jobs ? run_jobs(e, jobs, context, of_jobs)
                           : run_experiment(e, report.files[i], config, runner));
    }
    report.provenance = provenance_of(config, report.files, context.threads);
    const std::vector<fs::path> written = write_report(report, folder);
    json result = {{"index", written[0].string()},
                   {"steps_run", runner.n_run() + of_jobs.run},
                   {"steps_reused", runner.n_reused() + of_jobs.reused},
                   {"passed", report.count(Verdict::passed)},
                   {"failed", report.count(Verdict::failed)},
                   {"known_failures", report.count(Verdict::known_failure)},
                   {"not_run", report.count(Verdict::not_run)}};
    result = stamp.commit(std::move(result), Outlasts::power_cut, written);
    fail_if_left(report, written[0].string());
    return result;
}

}  // namespace slim
