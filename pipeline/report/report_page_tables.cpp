#include "pipeline/report/report_page_tables.h"

#include "pipeline/report/report_page_cells.h"
#include "pipeline/report/report_text.h"
#include "pipeline/report/report_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr const char* kEarlierMark = "<span class=\"none\">&dagger;</span>";

std::string slope_cell(const std::optional<double>& slope) {
    return fmt::format("<td>{}</td>", slope ? fmt::format("{:.2f}", *slope) : "");
}

/// Where a curve breaks, and at what.
std::string break_text(const ReportPlot& plot, const Curve& curve) {
    if (!curve.breaks) return "holds to the last";
    const std::string at = std::isnan(curve.breaks->y)
                               ? ": no result"
                               : ": " + plot.y_label + " " + number_text(curve.breaks->y, 3);
    return fmt::format("{} = {}{}", plot.x_label, number_text(curve.breaks->x, 4), at);
}

/// What became of the steps that have no result.
std::string notes_html(const std::vector<std::string>& notes) {
    if (notes.empty()) return "";
    std::string list;
    for (const std::string& note : notes) list += "<br>" + esc(note);
    return fmt::format(
        "<details><summary>{} steps without a result</summary><p "
        "class=\"note\">{}</p></details>\n",
        notes.size(), list.substr(4));
}

}  // namespace

bool is_earlier(const Expression& formula, const ReportRow& row, const std::string& last_run) {
    const auto runs = runs_timed(formula, row);
    return std::any_of(runs.begin(), runs.end(),
                       [&](const std::string& run) { return run != last_run; });
}

std::string slope_table(const PlotResult& result) {
    const ReportPlot& plot = *result.plot;
    const bool breaks = !plot.broken.empty();
    if (!plot.slopes && !breaks) return "";
    std::string out = "<table><tr><th>curve</th>";
    if (plot.slopes) out += "<th>slope</th>";
    if (!plot.theory.empty())
        out += "<th>theory" +
               (plot.theory_label.empty() ? "" : " (" + esc(plot.theory_label) + ")") + "</th>";
    if (breaks) out += "<th class=\"text\">breaks at</th>";
    out += "</tr>\n";
    for (const Curve& curve : result.curves) {
        out += "<tr><td>" + esc(curve.name) + "</td>";
        if (plot.slopes) out += slope_cell(curve.slope);
        if (!plot.theory.empty()) out += slope_cell(curve.theory);
        if (breaks) out += text_cell(break_text(plot, curve));
        out += "</tr>\n";
    }
    return out + "</table>\n";
}

std::string rows_table(const ExperimentResult& result, const std::string& last_run) {
    const Experiment& e = *result.experiment;
    if (e.columns.empty()) return "";
    std::string out = "<table>\n<tr>";
    for (const auto& [name, values] : e.grid) out += "<th>" + esc(name) + "</th>";
    for (const auto& [heading, formula] : e.columns) out += "<th>" + esc(heading) + "</th>";
    out += "</tr>\n";
    std::vector<std::string> notes;
    for (const ReportRow& row : result.rows) {
        out += "<tr>";
        for (const auto& [name, values] : e.grid) out += cell(row.at(name));
        for (const auto& [heading, formula] : e.columns)
            out += cell(row.value(formula), is_earlier(formula, row, last_run) ? kEarlierMark : "");
        out += "</tr>\n";
        for (const StepRecord& step : row.steps)
            if (!step.done)
                notes.push_back(fmt::format("{}: {} {}", row.label(e), step.step, step.reason));
    }
    out = "<div class=\"wide\">" + out + "</table></div>\n";
    if (result.rows.size() > 40)
        out = fmt::format("<details><summary>{} rows</summary>\n{}</details>\n", result.rows.size(),
                          out);
    return out + notes_html(notes);
}

std::string checks_table(const std::vector<CheckResult>& checks) {
    if (checks.empty()) return "";
    std::size_t bad = 0;
    std::string rows;
    for (const CheckResult& c : checks) {
        bad += c.verdict == Verdict::failed ? 1 : 0;
        rows += "<tr>" + text_cell(c.name) + text_cell(c.place) + "<td>" + esc(c.value) + "</td>" +
                text_cell(c.band) + verdict_cell(c.verdict) + text_cell(c.reason) + "</tr>\n";
    }
    return fmt::format(
        "<details{}><summary>{} bands, {} failed</summary>\n<table>\n"
        "<tr><th>figure</th><th class=\"text\">where</th><th>found</th><th "
        "class=\"text\">band</th><th class=\"text\">verdict</th><th "
        "class=\"text\">reason</th></tr>\n{}</table></details>\n",
        bad > 0 ? " open" : "", checks.size(), bad, rows);
}

std::string cases_table(const std::vector<ExperimentResult>& results) {
    std::string rows;
    for (const ExperimentResult& r : results) {
        if (!r.verdict) continue;
        rows += "<tr><td>" + esc(r.experiment->row) + "</td>" + text_cell(r.experiment->title) +
                text_cell(r.experiment->expected) + text_cell(r.found) +
                verdict_cell(r.verdict->verdict) + text_cell(r.verdict->reason) +
                text_cell(r.health) + "</tr>\n";
    }
    if (rows.empty()) return "";
    return "<table class=\"cases\">\n<tr><th>row</th><th class=\"text\">case</th><th "
           "class=\"text\">expected</th><th class=\"text\">found</th><th "
           "class=\"text\">verdict</th><th class=\"text\">reason</th><th class=\"text\">health "
           "counters</th></tr>\n" +
           rows + "</table>\n";
}

}  // namespace slim
