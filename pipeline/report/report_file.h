#pragma once

#include "pipeline/report/report_expression.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace slim {

/// One command of an experiment, done for every row of its grid (docs/report.md).
struct ReportStep {
    std::string name, run;
    std::string args;              ///< words, {formulas} in them
    std::string out;               ///< what the output's name ends with; empty: no output
    std::string program;           ///< of run = "command"
    std::vector<std::string> from; ///< clouds that a cloud step takes
    std::string points;            ///< how many it makes of nothing
    std::vector<std::pair<std::string, Expression>> point;  ///< its formulas: x, y, ..., keep
    std::string text;              ///< of run = "text"
    Expression when;               ///< empty: always
    std::vector<int> exit = {0};   ///< expected codes
    int repeat = 1;
    bool may_fail = false;         ///< another code leaves the row without its figures
    bool single = false;           ///< a cloud step writes floats
    bool transient = false;        ///< its output is removed when its row is done
    std::string where;             ///< "quick.toml:12"

    bool expects(int code) const { return std::find(exit.begin(), exit.end(), code) != exit.end(); }
};

/// A band that figures of rows must lie in, or a curve's slope.
struct ReportCheck {
    std::string name, known;   ///< known: why it fails for the time being
    Expression value, least, most, when;
    std::string where;
};

struct ReportPlot {
    std::string title, x_label, y_label, series, theory_label;
    Expression x, y, when, theory, least_slope, most_slope, broken;
    bool log_x = true, log_y = true, slopes = false;
    std::string known, where;
};

struct ReportPictures {
    std::string of, caption;
    Expression when;
    std::string where;
};

/// A grid of parameters, the steps for each of its rows, and what to show of them.
struct Experiment {
    std::string name, title, text;
    std::string row, expected, found, health, known;  ///< a case: has a verdict
    Expression pass;
    std::vector<std::string> needs;                   ///< files, else left out
    Expression when;                                  ///< only these rows; of parameters and values
    std::vector<std::pair<std::string, std::vector<FigureValue>>> grid;
    std::vector<ReportStep> steps;
    std::vector<std::pair<std::string, Expression>> columns;
    std::vector<ReportPlot> plots;
    std::vector<ReportPictures> pictures;
    std::vector<ReportCheck> checks;
    std::string where;

    bool is_case() const { return !pass.empty(); }
};

/// A report file's meaning.
struct ReportFile {
    std::filesystem::path file;
    std::string name, title, text;  ///< name: the file's without ending
    std::vector<std::pair<std::string, FigureValue>> values;
    std::vector<Experiment> experiments;
    std::string hash;               ///< of the file and the settings
};

/// Reads report files, changed by settings ("values.points=1000"), each of which changes the files
/// that have its key in [values]. ConfigError with file:line for an unknown table or key (and the
/// nearest name), a wrong type, a formula that is none, a name used twice, or nothing to do; and
/// for a setting whose key none of the files has.
std::vector<ReportFile> read_report_files(const std::vector<std::string>& files,
                                          const std::vector<std::string>& settings = {});

}  // namespace slim
