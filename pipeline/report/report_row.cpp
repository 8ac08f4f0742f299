#include "pipeline/report/report_row.h"

#include "pipeline/report/report_text.h"

#include <fmt/format.h>

#include <algorithm>

namespace slim {
namespace {

using nlohmann::json;

/// A member of members: "stages.fit.leaves"; array items by number.
const json* member_of(const json& in, std::string_view path) {
    const json* at = &in;
    while (!path.empty()) {
        const std::size_t dot = path.find('.');
        const std::string key(path.substr(0, dot));
        if (at->is_object() && at->contains(key)) {
            at = &at->at(key);
        } else if (at->is_array() && !key.empty() &&
                   std::all_of(key.begin(), key.end(),
                               [](char c) { return c >= '0' && c <= '9'; }) &&
                   std::stoul(key) < at->size()) {
            at = &at->at(std::stoul(key));
        } else {
            return nullptr;
        }
        path = dot == std::string_view::npos ? std::string_view() : path.substr(dot + 1);
    }
    return at;
}

FigureValue figure_of(const json& value, const std::string& name) {
    if (value.is_boolean()) return value.get<bool>() ? 1.0 : 0.0;
    if (value.is_number()) return value.get<double>();
    if (value.is_string()) return value.get<std::string>();
    throw MissingFigure{name};
}

}  // namespace

const StepRecord* ReportRow::step(const std::string& name) const {
    const auto found = std::find_if(steps.begin(), steps.end(),
                                    [&](const StepRecord& s) { return s.step == name; });
    return found == steps.end() ? nullptr : &*found;
}

FigureValue ReportRow::at(const std::string& name) const {
    for (const auto& [key, value] : parameters)
        if (key == name) return value;
    const std::size_t dot = name.find('.');
    const StepRecord* record = step(name.substr(0, dot));
    if (!record) throw MissingFigure{name};
    if (dot == std::string::npos) {
        if (record->output.empty() || !record->done) throw MissingFigure{name};
        return record->output;
    }
    const json* value = member_of(record->figures, std::string_view(name).substr(dot + 1));
    if (!value) throw MissingFigure{name};
    return figure_of(*value, name);
}

std::string ReportRow::label(const Experiment& experiment) const {
    std::string out;
    for (const auto& [name, values] : experiment.grid) {
        const FigureValue value = at(name);
        out += fmt::format("{}{} {}", out.empty() ? "" : ", ", name,
                           value.is_text ? value.text : number_text(value.number, 6));
    }
    return out;
}

std::optional<FigureValue> ReportRow::value(const Expression& formula) const {
    try {
        return formula.evaluate(lookup());
    } catch (const MissingFigure&) {
        return std::nullopt;
    }
}

std::optional<double> ReportRow::number(const Expression& formula) const {
    const std::optional<FigureValue> v = value(formula);
    return v && !v->is_text ? std::optional(v->number) : std::nullopt;
}

bool ReportRow::is_meant(const Expression& when) const {
    return when.empty() || when.holds(lookup());
}

std::string ReportRow::text(const std::string& with_formulas, int digits,
                            const std::string& where) const {
    try {
        return filled(with_formulas, lookup(), digits, where);
    } catch (const MissingFigure& missing) {
        return "no figure '" + missing.name + "'";
    }
}

std::vector<ReportRow> rows_of(const Experiment& experiment,
                               const std::vector<std::pair<std::string, FigureValue>>& values,
                               double cap) {
    std::vector<ReportRow> rows(1);
    for (const auto& [name, choices] : experiment.grid) {
        std::vector<ReportRow> longer;
        for (const ReportRow& row : rows)
            for (const FigureValue& choice : choices) {
                if (name == "points" && cap > 0 && choice.number > cap) continue;
                longer.push_back(row);
                longer.back().parameters.emplace_back(name, choice);
            }
        rows = std::move(longer);
    }
    // What the grid names wins over the file's values.
    for (ReportRow& row : rows)
        row.parameters.insert(row.parameters.end(), values.begin(), values.end());
    std::erase_if(rows, [&](const ReportRow& row) { return !row.is_meant(experiment.when); });
    return rows;
}

}  // namespace slim
