#include "pipeline/report/report_names.h"

#include "pipeline/config.h"
#include "pipeline/report/report_text.h"
#include "slim/base/error.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <string_view>

namespace slim {
namespace {

/// Formulas that name what no row can have are typing errors.
class NameCheck {
public:
    explicit NameCheck(std::vector<std::string> known) : known_(std::move(known)) {}

    void formula(const Expression& formula, const std::string& where) const {
        for (const std::string& name : formula.names()) {
            const std::string first = name.substr(0, name.find('.'));
            if (std::find(known_.begin(), known_.end(), first) == known_.end())
                throw ConfigError(fmt::format("{}: '{}': unknown name '{}'{}", where,
                                              formula.text(), first, suggestion(first, known_)));
        }
    }
    void text(const std::string& text, const std::string& where) const {
        for (const Expression& in : formulas_in(text, where)) formula(in, where);
    }
    NameCheck with(std::vector<std::string> more) const {
        more.insert(more.end(), known_.begin(), known_.end());
        return NameCheck(std::move(more));
    }

private:
    std::vector<std::string> known_;
};

void check_step_names(const ReportStep& step, const NameCheck& row) {
    const NameCheck words = row.with({"out"});
    const NameCheck point = row.with({"x", "y", "z", "nx", "ny", "nz", "k1", "k2", "i", "n", "file",
                                      "r1", "r2", "r3", "r4", "g1", "g2", "g3"});
    words.text(step.args, step.where);
    for (const std::string& cloud : step.from) words.text(cloud, step.where);
    row.text(step.text, step.where);
    for (const Expression& formula : formulas_in(step.points, step.where))
        row.formula(formula, step.where);
    row.formula(step.when, step.where);
    for (const auto& [target, formula] : step.point) point.formula(formula, step.where);
}

/// The first key of "stages.fit.leeves" that a result lacks, as a message: empty if it has all.
std::string lacking_key(const nlohmann::json& figures, std::string_view path) {
    const nlohmann::json* at = &figures;
    while (!path.empty()) {
        const std::size_t dot = path.find('.');
        const std::string key(path.substr(0, dot));
        if (!at->is_object()) return "";  // items of a list, or what is null in this row
        if (!at->contains(key)) {
            std::vector<std::string> known;
            for (const auto& [name, value] : at->items()) known.push_back(name);
            return fmt::format("no '{}'{}", key, suggestion(key, known));
        }
        at = &at->at(key);
        path = dot == std::string_view::npos ? std::string_view() : path.substr(dot + 1);
    }
    return "";
}

/// The same of a name "step.key" in all rows; empty if one of them has it, or no step ended well.
std::string lacking_result(const std::string& name, const std::vector<ReportRow>& rows) {
    const std::size_t dot = name.find('.');
    if (dot == std::string::npos) return "";
    std::string lacking;
    for (const ReportRow& row : rows) {
        const StepRecord* step = row.step(name.substr(0, dot));
        if (!step || !step->done || step->figures.value("exit", 0) != 0) continue;
        lacking = lacking_key(step->figures, std::string_view(name).substr(dot + 1));
        if (lacking.empty()) return "";
    }
    return lacking;
}

}  // namespace

void check_columns(const Experiment& e, const std::vector<ReportRow>& rows) {
    for (const auto& [heading, formula] : e.columns)
        for (const std::string& name : formula.names())
            if (const std::string lacking = lacking_result(name, rows); !lacking.empty())
                throw ConfigError(fmt::format("{}: column '{}': {}: the results of step '{}' "
                                              "have {}",
                                              e.where, heading, name,
                                              name.substr(0, name.find('.')), lacking));
}

void check_formulas(const Experiment& e,
                    const std::vector<std::pair<std::string, FigureValue>>& values) {
    std::vector<std::string> known = {"seed"};
    for (const auto& [name, value] : values) known.push_back(name);
    for (const auto& [name, choices] : e.grid) known.push_back(name);
    NameCheck(known).formula(e.when, e.where);
    for (const ReportStep& step : e.steps) known.push_back(step.name);
    const NameCheck row(std::move(known));
    for (const ReportStep& step : e.steps) check_step_names(step, row);
    for (const auto& [heading, formula] : e.columns) row.formula(formula, e.where);
    for (const ReportPlot& plot : e.plots) {
        for (const Expression* formula : {&plot.x, &plot.y, &plot.when, &plot.theory,
                                          &plot.least_slope, &plot.most_slope, &plot.broken})
            row.formula(*formula, plot.where);
        row.text(plot.series, plot.where);
    }
    for (const ReportPictures& p : e.pictures)
        row.formula(p.when, p.where), row.text(p.caption, p.where);
    for (const ReportCheck& c : e.checks)
        for (const Expression* formula : {&c.value, &c.least, &c.most, &c.when})
            row.formula(*formula, c.where);
    row.formula(e.pass, e.where);
    row.text(e.found, e.where);
    for (const std::string& file : e.needs) row.text(file, e.where);
}

}  // namespace slim
