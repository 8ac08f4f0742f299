#include "pipeline/report/report_results.h"

#include "pipeline/report/report_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace slim {

bool is_meant(const ReportRow& row, const Expression& when) {
    try {
        return row.is_meant(when);
    } catch (const MissingFigure&) {
        return false;
    }
}

namespace {

std::string shown(double value) { return number_text(value, 4); }

std::string band_text(std::optional<double> least, std::optional<double> most) {
    if (least && most) return fmt::format("{} to {}", shown(*least), shown(*most));
    return least ? fmt::format("at least {}", shown(*least))
                 : fmt::format("at most {}", shown(*most));
}

std::string failure(const ReportRow& row) {
    for (const StepRecord& step : row.steps)
        if (!step.done && !step.absent) return fmt::format("{} {}", step.step, step.reason);
    return "";
}

/// The same of steps that may not fail.
std::string failure(const ReportRow& row, const Experiment& e) {
    for (const ReportStep& step : e.steps) {
        const StepRecord* record = row.step(step.name);
        if (record && !record->done && !record->absent && !step.may_fail)
            return fmt::format("{} {}", step.name, record->reason);
    }
    return "";
}

/// Why a row lacks figures, if that is nobody's failure: a program that is not there. Not what
/// follows a step that failed.
std::string absence(const ReportRow& row) {
    if (!failure(row).empty()) return "";
    for (const StepRecord& step : row.steps)
        if (step.absent) return fmt::format("{}: {}", step.step, step.reason);
    return "";
}

CheckResult missing(const ReportRow& row, const std::string& name, CheckResult out) {
    out.reason = absence(row);
    out.verdict = out.reason.empty() ? Verdict::failed : Verdict::not_run;
    if (out.reason.empty()) out.reason = failure(row);
    if (out.reason.empty()) out.reason = "no figure '" + name + "'";
    return out;
}

/// Whether a value lies in its band; NaN does not.
void compare(double value, std::optional<double> least, std::optional<double> most,
             const std::string& known, CheckResult& out) {
    out.value = shown(value), out.band = band_text(least, most);
    const bool inside = (!least || value >= *least) && (!most || value <= *most);
    if (inside) return;
    out.verdict = known.empty() ? Verdict::failed : Verdict::known_failure;
    out.reason = known;
}

/// An end of a band; nothing without a formula. throws MissingFigure
std::optional<double> bound(const Expression& formula, const ReportRow& row) {
    return formula.empty() ? std::nullopt : std::optional(formula.number(row.lookup()));
}

CheckResult checked(const Experiment& e, const ReportCheck& check, const ReportRow& row) {
    CheckResult out{e.name, check.name, row.label(e), "", "", Verdict::passed, ""};
    try {
        compare(check.value.number(row.lookup()), bound(check.least, row), bound(check.most, row),
                check.known, out);
    } catch (const MissingFigure& figure) {
        return missing(row, figure.name, std::move(out));
    }
    return out;
}

/// Steps that ended otherwise than expected, each once.
void check_steps(ExperimentResult& result) {
    for (const ReportRow& row : result.rows)
        for (const ReportStep& step : result.experiment->steps) {
            const StepRecord* record = row.step(step.name);
            if (!record || record->done || record->absent || step.may_fail) continue;
            result.checks.push_back({result.experiment->name, "step " + step.name,
                                     row.label(*result.experiment), "", "", Verdict::failed,
                                     record->reason, true});
        }
}

Curve& curve_of(std::vector<Curve>& curves, const std::string& name) {
    for (Curve& curve : curves)
        if (curve.name == name) return curve;
    curves.push_back({name, {}, {}, {}, {}, {}});
    return curves.back();
}

PlotResult plotted(const ExperimentResult& result, const ReportPlot& plot) {
    PlotResult out{&plot, {}};
    for (const ReportRow& row : result.rows) {
        if (!is_meant(row, plot.when)) continue;
        Curve& curve = curve_of(out.curves, row.text(plot.series, 6, plot.where));
        const auto x = row.number(plot.x), y = row.number(plot.y);
        // A row that has no figure is beyond the breaking point of its curve.
        const bool lost = !y && absence(row).empty();
        const auto broken = plot.broken.empty() ? std::nullopt : row.number(plot.broken);
        const bool breaks = !plot.broken.empty() && (lost || (broken && *broken != 0));
        if (x && breaks && !curve.breaks)
            curve.breaks = Curve::Point{*x, y.value_or(std::nan("")), true};
        if (!plot.theory.empty() && !curve.theory) curve.theory = row.number(plot.theory);
        if (!(x && y) && curve.lacks.empty() && absence(row).empty())
            curve.lacks = missing(row, (x ? plot.y : plot.x).text(), {}).reason;
        if (x && y && std::isfinite(*x) && std::isfinite(*y))
            curve.points.push_back({*x, *y, breaks});
    }
    for (Curve& curve : out.curves) {
        if (plot.slopes) curve.slope = log_slope(curve.points);
    }
    return out;
}

/// Bands of slopes, in terms of the first row of each curve.
void check_slopes(const PlotResult& drawn, ExperimentResult& result) {
    const ReportPlot& plot = *drawn.plot;
    if (plot.least_slope.empty() && plot.most_slope.empty()) return;
    for (const Curve& curve : drawn.curves) {
        const auto row =
            std::find_if(result.rows.begin(), result.rows.end(), [&](const ReportRow& r) {
                return is_meant(r, plot.when) && r.text(plot.series, 6, plot.where) == curve.name;
            });
        CheckResult out{result.experiment->name, "slope of " + plot.title, curve.name,
                        "", "", Verdict::passed, ""};
        if (!curve.slope) {
            out.verdict = curve.lacks.empty() ? Verdict::not_run : Verdict::failed;
            out.reason = curve.lacks.empty() ? "too few points for a slope" : curve.lacks;
            result.checks.push_back(std::move(out));
            continue;
        }
        try {
            compare(*curve.slope, bound(plot.least_slope, *row), bound(plot.most_slope, *row),
                    plot.known, out);
        } catch (const MissingFigure& figure) {
            out = missing(*row, figure.name, std::move(out));
        }
        result.checks.push_back(std::move(out));
    }
}

/// Counters that are not zero, of one step or a part of it: what the user would be told.
std::string health_of(const ReportRow& row, const std::string& of) {
    static const char* const kCounters[] = {
        "dropped", "dropped_isolated", "dropped_beside", "dropped_unexplained", "contrary",
        "normals_disagree", "forced", "saturated", "noise_variance_floored", "few_points", "rank",
        "steep", "plane", "estimated", "turned", "degenerate", "unsupported", "missed", "opposed",
        "astray", "loose", "warnings"};
    std::string out;
    for (const std::string& prefix : {of + ".", of + ".stages.slice.", of + ".stages.normals.",
                                      of + ".stages.fit.", of + ".stages.fit.fallbacks."})
        for (const char* counter : kCounters) {
            const auto value = row.number(Expression(prefix + counter, ""));
            if (value && *value != 0)
                out += fmt::format("{}{} {}", out.empty() ? "" : ", ", counter, shown(*value));
        }
    return out;
}

/// A case holds if it does in every row; the first row that does not is shown, else the last.
void judge_case(ExperimentResult& result) {
    const Experiment& e = *result.experiment;
    CheckResult verdict{e.name, "case " + e.row, "", "", e.expected, Verdict::passed, ""};
    const ReportRow* shown_row = result.rows.empty() ? nullptr : &result.rows.back();
    for (const ReportRow& row : result.rows) {
        CheckResult here = verdict;
        here.place = row.label(e);
        try {
            if (const std::string why = failure(row, e); !why.empty())
                here.verdict = Verdict::failed, here.reason = why;
            else if (!e.pass.holds(row.lookup()))
                here.verdict = Verdict::failed, here.reason = "not so: " + e.pass.text();
        } catch (const MissingFigure& figure) {
            here = missing(row, figure.name, here);
        }
        if (here.verdict == Verdict::passed) continue;
        verdict = here, shown_row = &row;
        if (here.verdict == Verdict::failed) break;
    }
    if (verdict.verdict == Verdict::failed && !e.known.empty())
        verdict.verdict = Verdict::known_failure, verdict.reason = e.known;
    if (shown_row && verdict.verdict != Verdict::not_run) {
        result.found = shown_row->text(e.found, 4, e.where);
        if (result.rows.size() > 1 && verdict.verdict != Verdict::passed)
            result.found = shown_row->label(e) + ": " + result.found;
        if (!e.health.empty()) result.health = health_of(*shown_row, e.health);
    }
    verdict.value = result.found;
    result.verdict = verdict;
}

}  // namespace

const char* verdict_text(Verdict verdict) {
    switch (verdict) {
        case Verdict::passed: return "ok";
        case Verdict::failed: return "FAILED";
        case Verdict::known_failure: return "fails (known)";
        default: return "not run";
    }
}

std::string CheckResult::sentence() const {
    std::string out =
        fmt::format("{}, {}{}", experiment, name, place.empty() ? "" : " (" + place + ")");
    if (!value.empty()) out += fmt::format(": found {}, expected {}", value, band);
    if (!reason.empty()) out += ": " + reason;
    return out;
}

std::optional<double> log_slope(const std::vector<Curve::Point>& points) {
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (const Curve::Point& p : points) {
        if (!(p.x > 0) || !(p.y > 0)) continue;
        const double x = std::log(p.x), y = std::log(p.y);
        n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    const double spread = n * sxx - sx * sx;
    if (n < 2 || !(spread > 1e-12 * n * sxx)) return std::nullopt;
    return (n * sxy - sx * sy) / spread;
}

void judge(ExperimentResult& result) {
    const Experiment& e = *result.experiment;
    if (!result.left_out.empty()) {
        if (e.is_case())
            result.verdict = CheckResult{e.name,           "case " + e.row, "", "", e.expected,
                                         Verdict::not_run, result.left_out};
        return;
    }
    if (!e.is_case()) check_steps(result);
    for (const ReportCheck& check : e.checks)
        for (const ReportRow& row : result.rows)
            if (is_meant(row, check.when)) result.checks.push_back(checked(e, check, row));
    for (const ReportPlot& plot : e.plots) {
        result.plots.push_back(plotted(result, plot));
        check_slopes(result.plots.back(), result);
        std::erase_if(result.plots.back().curves,
                      [](const Curve& c) { return c.points.empty() && !c.breaks; });
    }
    if (e.is_case()) judge_case(result);
}

}  // namespace slim
