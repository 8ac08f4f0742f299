#pragma once

#include "pipeline/report/report_row.h"

#include <optional>
#include <string>
#include <vector>

namespace slim {

/// What became of a band, a case or a step.
enum class Verdict { passed, failed, known_failure, not_run };
const char* verdict_text(Verdict verdict);

struct CheckResult {
    std::string experiment, name, place;  ///< place: the row's label
    std::string value, band;
    Verdict verdict = Verdict::passed;
    std::string reason;
    bool is_step = false;  ///< that ended otherwise than expected, not a figure

    /// "quick, L2 (degree 2): 0.3, expected at most 0.1": for messages.
    std::string sentence() const;
};

/// One curve of a plot, in the order of the grid.
struct Curve {
    struct Point {
        double x, y;
        bool broken = false;
    };
    std::string name;
    std::vector<Point> points;
    std::optional<double> slope, theory;  ///< of log y over log x
    std::optional<Point> breaks;          ///< the first point, in order, where `broken` holds
    std::string lacks;                    ///< why a row of it has no x or y, if that is a failure
};

struct PlotResult {
    const ReportPlot* plot = nullptr;
    std::vector<Curve> curves;
};

/// All that is shown of an experiment.
struct ExperimentResult {
    const Experiment* experiment = nullptr;
    std::vector<ReportRow> rows;
    std::string left_out;                 ///< why nothing of it was run
    std::vector<PlotResult> plots;
    std::vector<CheckResult> checks;      ///< bands, slopes, steps that failed
    std::optional<CheckResult> verdict;   ///< of a case
    std::string found, health;            ///< of a case
};

/// Least-squares slope of log y over log x; nothing for fewer than two different x > 0 with y > 0.
std::optional<double> log_slope(const std::vector<Curve::Point>& points);

/// Whether a check, plot or picture is of this row; one that lacks a figure of `when` is not.
bool is_meant(const ReportRow& row, const Expression& when);

/// Judges the rows of an experiment: its curves with their slopes and breaking points, its checks
/// and its verdict.
void judge(ExperimentResult& result);

}  // namespace slim
