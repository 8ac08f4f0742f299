#include "pipeline/report/report_page.h"

#include "pipeline/report/report_text.h"
#include "pipeline/report/report_times.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include <unistd.h>

namespace slim {
namespace {

using nlohmann::json;

constexpr const char* kTimedIn = "timed in the run of";

std::string csv_cell(const std::string& text) {
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
    return out + "\"";
}

std::string exact(const std::optional<FigureValue>& value) {
    if (!value) return "";
    return value->is_text ? value->text : number_text(value->number, 17);
}

json json_of(const std::optional<FigureValue>& value) {
    if (!value) return nullptr;
    if (value->is_text) return value->text;
    return std::isfinite(value->number) ? json(value->number) : json();
}

json row_json(const Experiment& e, const ReportRow& row) {
    json out = json::object();
    for (const auto& [name, values] : e.grid) out[name] = json_of(row.at(name));
    for (const auto& [heading, formula] : e.columns) out[heading] = json_of(row.value(formula));
    if (has_times(e)) out[kTimedIn] = runs_timed(e, row);
    return out;
}

json optional_json(const std::optional<double>& value) { return value ? json(*value) : json(); }

json plot_json(const PlotResult& plot) {
    json curves = json::array();
    for (const Curve& curve : plot.curves) {
        json points = json::array();
        for (const Curve::Point& p : curve.points) points.push_back({p.x, p.y});
        json out = {{"name", curve.name},
                    {"points", points},
                    {"slope", optional_json(curve.slope)},
                    {"theory", optional_json(curve.theory)}};
        if (!plot.plot->broken.empty())
            out["breaks_at"] = curve.breaks ? json(curve.breaks->x) : json();
        curves.push_back(std::move(out));
    }
    return {{"title", plot.plot->title},
            {"x", plot.plot->x_label},
            {"y", plot.plot->y_label},
            {"curves", curves}};
}

json check_json(const CheckResult& check) {
    return {{"name", check.name},
            {"place", check.place},
            {"value", check.value},
            {"band", check.band},
            {"verdict", verdict_text(check.verdict)},
            {"reason", check.reason}};
}

json experiment_json(const ExperimentResult& result) {
    const Experiment& e = *result.experiment;
    json out = {{"name", e.name},
                {"title", e.title},
                {"rows", json::array()},
                {"plots", json::array()},
                {"checks", json::array()}};
    if (!result.left_out.empty()) out["left_out"] = result.left_out;
    for (const ReportRow& row : result.rows) out["rows"].push_back(row_json(e, row));
    for (const PlotResult& plot : result.plots) out["plots"].push_back(plot_json(plot));
    for (const CheckResult& check : result.checks) out["checks"].push_back(check_json(check));
    if (result.verdict) {
        out["case"] = check_json(*result.verdict);
        out["case"].update({{"row", e.row},
                            {"expected", e.expected},
                            {"found", result.found},
                            {"health", result.health}});
    }
    return out;
}

std::string first_of(const char* file, const std::string& key) {
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);)
        if (line.starts_with(key)) {
            const std::size_t begin = line.find_first_not_of(" \t:=\"", key.size());
            return begin == std::string::npos
                       ? ""
                       : line.substr(begin, line.find_last_not_of("\"") + 1 - begin);
        }
    return "";
}

}  // namespace

json machine_json() {
    const std::string memory = first_of("/proc/meminfo", "MemTotal");
    const double kib = memory.empty() ? 0 : std::stod(memory);
    return {{"processor", first_of("/proc/cpuinfo", "model name")},
            {"cores", sysconf(_SC_NPROCESSORS_ONLN)},
            {"memory_gib", std::round(kib / 104857.6) / 10},
            {"system", first_of("/etc/os-release", "PRETTY_NAME")}};
}

std::string rows_csv(const ExperimentResult& result) {
    const Experiment& e = *result.experiment;
    std::string out;
    const auto add = [&](const std::string& cell, bool first) {
        out += (first ? "" : ",") + csv_cell(cell);
    };
    bool first = true;
    for (const auto& [name, values] : e.grid) add(name, first), first = false;
    for (const auto& [heading, formula] : e.columns) add(heading, first), first = false;
    if (has_times(e)) add(kTimedIn, first);
    out += "\n";
    for (const ReportRow& row : result.rows) {
        first = true;
        for (const auto& [name, values] : e.grid) add(exact(row.at(name)), first), first = false;
        for (const auto& [heading, formula] : e.columns)
            add(exact(row.value(formula)), first), first = false;
        if (has_times(e)) add(fmt::format("{}", fmt::join(runs_timed(e, row), " ")), first);
        out += "\n";
    }
    return out;
}

json report_json(const Report& report) {
    json out = {{"provenance", report.provenance},
                {"runs", steps_by_run(report)},
                {"files", json::array()}};
    for (const Verdict v :
         {Verdict::passed, Verdict::failed, Verdict::known_failure, Verdict::not_run})
        out["checks"][verdict_text(v)] = report.count(v);
    for (std::size_t i = 0; i < report.files.size(); ++i) {
        json experiments = json::array();
        for (const ExperimentResult& result : report.results[i])
            experiments.push_back(experiment_json(result));
        out["files"].push_back({{"name", report.files[i].name}, {"title", report.files[i].title},
                                {"experiments", experiments}});
    }
    return out;
}

std::vector<const CheckResult*> Report::checks() const {
    std::vector<const CheckResult*> out;
    for (const auto& of_file : results)
        for (const ExperimentResult& result : of_file) {
            for (const CheckResult& check : result.checks) out.push_back(&check);
            if (result.verdict) out.push_back(&*result.verdict);
        }
    return out;
}

std::size_t Report::count(Verdict verdict) const {
    std::size_t n = 0;
    for (const CheckResult* check : checks()) n += check->verdict == verdict ? 1 : 0;
    return n;
}

}  // namespace slim
