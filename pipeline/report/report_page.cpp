#include "pipeline/report/report_page.h"

#include "pipeline/html_page.h"
#include "pipeline/json_text.h"
#include "pipeline/report/report_page_cells.h"
#include "pipeline/report/report_page_pictures.h"
#include "pipeline/report/report_page_tables.h"
#include "pipeline/report/report_times.h"
#include "pipeline/report/svg_plot.h"

#include <fmt/format.h>

#include <cmath>

namespace slim {
namespace {

using nlohmann::json;

constexpr const char* kStyle = R"(body { font-size: 15px; max-width: 84rem }
h2 { margin-top: 3rem; border-bottom: 2px solid #ccc }
h3 { margin-top: 2.2rem; margin-bottom: .3rem }
table { font-size: .9rem; font-variant-numeric: tabular-nums }
th, td { padding: .2rem .7rem; vertical-align: top }
th { background: #f0f0f0 }
td.text, th.text { text-align: left }
td.text { max-width: 26rem }
.wide { overflow-x: auto }
.figures { display: flex; flex-wrap: wrap; gap: 1rem }
figure svg, figure img { max-width: 100%; height: auto; display: block }
figure.picture { max-width: 24rem }
.ok { color: #00694b } .bad { color: #b00020; font-weight: 600 } .known { color: #9a5b00 } .none { color: #777 }
summary { cursor: pointer }
)";

/// What a plot's caption says of times that were taken in other runs than the last.
std::string earlier_points(const ReportPlot& plot, const std::vector<ReportRow>& rows,
                           const std::string& last_run) {
    std::size_t n = 0, earlier = 0;
    for (const ReportRow& row : rows) {
        if (!is_meant(row, plot.when) || !row.number(plot.x) || !row.number(plot.y)) continue;
        ++n;
        earlier += is_earlier(plot.x, row, last_run) || is_earlier(plot.y, row, last_run) ? 1 : 0;
    }
    return earlier == 0 ? "" : fmt::format("; {} of {} points timed in an earlier run", earlier, n);
}

std::string plot_html(const PlotResult& result, const std::vector<ReportRow>& rows,
                      const std::string& last_run) {
    const ReportPlot& plot = *result.plot;
    SvgPlot svg{plot.x_label, plot.y_label, plot.log_x, plot.log_y, {}};
    for (const Curve& curve : result.curves) {
        SvgCurve drawn{curve.name, {}, curve.theory.value_or(0),
                       curve.theory && std::isfinite(*curve.theory)};
        for (const Curve::Point& p : curve.points) drawn.points.push_back({p.x, p.y, p.broken});
        svg.curves.push_back(std::move(drawn));
    }
    std::string caption = esc(plot.title);
    if (!plot.theory.empty()) caption += "; dashed: slope of theory";
    if (!plot.broken.empty()) caption += "; cross: " + esc(plot.broken.text());
    caption += earlier_points(plot, rows, last_run);
    return "<figure>" + svg_of(svg) + "<figcaption>" + caption + slope_table(result) +
           "</figcaption></figure>\n";
}

std::string experiment_html(const ExperimentResult& result, const std::string& last_run) {
    const Experiment& e = *result.experiment;
    const bool only_a_case =
        e.is_case() && result.plots.empty() && e.pictures.empty() && e.checks.empty();
    if (only_a_case) return "";
    std::string out = fmt::format("<h3>{}</h3>\n", esc(e.title));
    if (!e.text.empty()) out += "<p>" + esc(e.text) + "</p>\n";
    if (!result.left_out.empty())
        return out + "<p class=\"note\">left out: " + esc(result.left_out) + "</p>\n";
    std::string plots;
    for (const PlotResult& plot : result.plots) plots += plot_html(plot, result.rows, last_run);
    if (!plots.empty()) out += "<div class=\"figures\">\n" + plots + "</div>\n";
    return out + pictures_html(result) + rows_table(result, last_run) + checks_table(result.checks);
}

std::string provenance_html(const json& provenance) {
    std::string out;
    const auto add = [&out](const std::string& key, const json& value) {
        const std::string text = value.is_string() ? value.get<std::string>() : text_of(value);
        out += fmt::format("{}{}: {}", out.empty() ? "" : " &middot; ", esc(key), esc(text));
    };
    for (const auto& [key, value] : provenance.items()) {
        if (!value.is_object()) add(key, value);
        else
            for (const auto& [name, part] : value.items())
                add(key == "machine" ? name : name + ".toml", part);
    }
    return "<p class=\"note\">" + out + "</p>\n";
}

/// When the steps were run: once, or in several runs, whose times are then no comparison.
std::string runs_html(const std::map<std::string, std::size_t>& runs) {
    if (runs.empty()) return "";
    std::string list;
    for (const auto& [run, steps] : runs)
        list += fmt::format("{}{} ({} steps)", list.empty() ? "" : ", ", esc(run), steps);
    return fmt::format(
        "<p class=\"note\">run: {}{}</p>\n", list,
        runs.size() == 1
            ? ""
            : "; &dagger; a time of an earlier run than the last: another hour, perhaps "
              "another load (--force times all of it anew)");
}

std::string summary_html(const Report& report) {
    std::string out = "<p>";
    for (const Verdict v :
         {Verdict::passed, Verdict::failed, Verdict::known_failure, Verdict::not_run})
        out += fmt::format("<span class=\"{}\">{} {}</span> &emsp;",
                           report.count(v) > 0 ? class_of(v) : "none", report.count(v),
                           verdict_text(v));
    out += "</p>\n";
    std::string list;
    for (const CheckResult* check : report.checks())
        if (check->verdict == Verdict::failed) list += "<li>" + esc(check->sentence()) + "</li>\n";
    return list.empty() ? out : out + "<ul class=\"bad\">\n" + list + "</ul>\n";
}

}  // namespace

std::string page_head(const std::string& title) { return html_head(title, kStyle); }

std::string report_page(const Report& report) {
    const std::string title =
        report.files.size() == 1 ? report.files[0].title : "SLIM: error against run time";
    const auto runs = steps_by_run(report);
    const std::string last_run = runs.empty() ? "" : runs.rbegin()->first;
    std::string out = page_head(title) + "<h1>" + esc(title) + "</h1>\n" +
                      provenance_html(report.provenance) + runs_html(runs) + summary_html(report);
    for (std::size_t i = 0; i < report.files.size(); ++i) {
        if (report.files.size() > 1)
            out += fmt::format("<h2>{}</h2>\n", esc(report.files[i].title));
        if (!report.files[i].text.empty()) out += "<p>" + esc(report.files[i].text) + "</p>\n";
        out += cases_table(report.results[i]);
        for (const ExperimentResult& result : report.results[i])
            out += experiment_html(result, last_run);
    }
    return out + kHtmlEnd;
}

}  // namespace slim
