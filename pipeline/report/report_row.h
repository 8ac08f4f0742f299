#pragma once

#include "pipeline/report/report_file.h"

#include <nlohmann/json.hpp>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace slim {

/// What a step came to in one row.
struct StepRecord {
    std::string step, run;
    bool done = false;         ///< it ended with an expected code
    std::string reason;        ///< why not, for people
    bool absent = false;       ///< its program or an input is not there: nobody's failure
    std::string run_started;   ///< when the run of the report that ran it began; empty: not said
    nlohmann::json figures;    ///< what it printed, and exit seconds seconds_min ...
    std::string output;        ///< path; empty: none
    std::string name;          ///< "fit-3f2a..." of its files in the folder of steps
};

/// One row of an experiment's grid: its parameters and what its steps found. What formulas look
/// names up in: a parameter, a value of the file, `seed`, a step (its output's path), step.figure
/// (numbers; members of members by further dots).
struct ReportRow {
    std::vector<std::pair<std::string, FigureValue>> parameters;
    std::vector<StepRecord> steps;

    /// throws MissingFigure
    FigureValue at(const std::string& name) const;
    Expression::Lookup lookup() const {
        return [this](const std::string& name) { return at(name); };
    }
    const StepRecord* step(const std::string& name) const;
    /// "degree 2, t 0.01"; of the grid's parameters only.
    std::string label(const Experiment& experiment) const;
    /// Nothing where a name has no value in this row.
    std::optional<FigureValue> value(const Expression& formula) const;
    std::optional<double> number(const Expression& formula) const;
    /// Whether the row is meant: true without a formula.
    bool is_meant(const Expression& when) const;
    std::string text(const std::string& with_formulas, int digits, const std::string& where) const;
};

/// The rows of a grid, the last parameter running fastest, that the experiment's `when` holds for.
/// Values of the parameter `points` above the cap are left out (0: none).
std::vector<ReportRow> rows_of(const Experiment& experiment,
                               const std::vector<std::pair<std::string, FigureValue>>& values,
                               double cap);

}  // namespace slim
