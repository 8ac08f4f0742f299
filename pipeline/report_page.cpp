#include "pipeline/report_page.h"

#include "pipeline/html_page.h"
#include "pipeline/json_text.h"
#include "pipeline/report_text.h"
#include "pipeline/report_times.h"
#include "pipeline/svg_plot.h"
#include "slim/base/markup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

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

std::string esc(const std::string& text) { return escaped_markup(text); }

const char* class_of(Verdict v) {
    switch (v) {
        case Verdict::passed: return "ok";
        case Verdict::failed: return "bad";
        case Verdict::known_failure: return "known";
        default: return "none";
    }
}

std::string verdict_cell(Verdict v) {
    return fmt::format("<td class=\"text {}\">{}</td>", class_of(v), verdict_text(v));
}

std::string text_cell(const std::string& text) {
    return "<td class=\"text\">" + esc(text) + "</td>";
}

std::string cell(const std::optional<FigureValue>& value, const char* mark = "") {
    if (value && value->is_text) return text_cell(value->text);
    const bool shows = value && std::isfinite(value->number);
    return "<td>" + (shows ? number_text(value->number, 4) + mark : "") + "</td>";
}

constexpr const char* kEarlierMark = "<span class=\"none\">&dagger;</span>";

/// Whether a time in the formula was taken before the last run of the report.
bool is_earlier(const Expression& formula, const ReportRow& row, const std::string& last_run) {
    const auto runs = runs_timed(formula, row);
    return std::any_of(runs.begin(), runs.end(),
                       [&](const std::string& run) { return run != last_run; });
}

std::string base64(const std::string& bytes) {
    static const char* const kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t v = 0;
        for (std::size_t k = 0; k < 3; ++k)
            v = v << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            out += i + k > bytes.size() ? '=' : kDigits[v >> (18 - 6 * k) & 63u];
    }
    return out;
}

std::string picture(const std::string& path, const std::string& caption) {
    std::ifstream in(path, std::ios::binary);
    if (!in) return "";
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    return fmt::format(
        "<figure class=\"picture\"><img alt=\"{0}\" "
        "src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>\n",
        esc(caption), base64(bytes));
}

/// The PNG files that a step of a row wrote.
std::vector<std::string> pngs_of(const StepRecord& step) {
    std::vector<std::string> out;
    if (step.figures.contains("files"))
        for (const json& file : step.figures["files"])
            if (file.get<std::string>().ends_with(".png")) out.push_back(file.get<std::string>());
    if (out.empty() && step.output.ends_with(".png")) out.push_back(step.output);
    return out;
}

/// "view-1a2b.mean.png": mean.
std::string map_of(const std::string& path) {
    const std::string stem = std::filesystem::path(path).stem().string();
    return stem.substr(stem.rfind('.') + 1);
}

std::string pictures_html(const ExperimentResult& result) {
    std::string out;
    for (const ReportPictures& shown_of : result.experiment->pictures)
        for (const ReportRow& row : result.rows) {
            const StepRecord* step = row.step(shown_of.of);
            if (!step || !step->done || !is_meant(row, shown_of.when)) continue;
            const std::string caption = shown_of.caption.empty()
                                            ? row.label(*result.experiment)
                                            : row.text(shown_of.caption, 4, shown_of.where);
            const std::vector<std::string> files = pngs_of(*step);
            for (const std::string& path : files)
                out += picture(path, caption + (files.size() > 1 ? ", " + map_of(path) : ""));
        }
    return out.empty() ? "" : "<div class=\"figures\">\n" + out + "</div>\n";
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
        if (plot.slopes)
            out +=
                fmt::format("<td>{}</td>", curve.slope ? fmt::format("{:.2f}", *curve.slope) : "");
        if (!plot.theory.empty())
            out += fmt::format("<td>{}</td>",
                               curve.theory ? fmt::format("{:.2f}", *curve.theory) : "");
        if (breaks)
            out +=
                text_cell(!curve.breaks ? "holds to the last"
                                        : fmt::format("{} = {}{}", plot.x_label,
                                                      number_text(curve.breaks->x, 4),
                                                      std::isnan(curve.breaks->y)
                                                          ? ": no result"
                                                          : ": " + plot.y_label + " " +
                                                                number_text(curve.breaks->y, 3)));
        out += "</tr>\n";
    }
    return out + "</table>\n";
}

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
    if (notes.empty()) return out;
    std::string list;
    for (const std::string& note : notes) list += "<br>" + esc(note);
    return out + fmt::format(
                     "<details><summary>{} steps without a result</summary><p "
                     "class=\"note\">{}</p></details>\n",
                     notes.size(), list.substr(4));
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
