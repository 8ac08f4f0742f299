#include "pipeline/report/report_expression.h"

#include "pipeline/report/report_expression_parser.h"
#include "pipeline/report/report_functions.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace slim {

Expression::Expression(const std::string& text, const std::string& where)
    : text_(text), where_(where) {
    ExpressionParser(*this).parse();
}

std::size_t Expression::arity(Op op) {
    if (op == Op::negate || op == Op::opposite || op == Op::function) return 1;
    return op == Op::choose ? 3 : 2;
}

double Expression::apply(const Step& step, const double* a) {
    switch (step.op) {
        case Op::add: return a[0] + a[1];
        case Op::subtract: return a[0] - a[1];
        case Op::multiply: return a[0] * a[1];
        case Op::divide: return a[0] / a[1];
        case Op::power: return std::pow(a[0], a[1]);
        case Op::negate: return -a[0];
        case Op::less: return a[0] < a[1] ? 1 : 0;
        case Op::less_equal: return a[0] <= a[1] ? 1 : 0;
        case Op::greater: return a[0] > a[1] ? 1 : 0;
        case Op::greater_equal: return a[0] >= a[1] ? 1 : 0;
        case Op::equal: return a[0] == a[1] ? 1 : 0;
        case Op::unequal: return a[0] != a[1] ? 1 : 0;
        case Op::both: return a[0] != 0 && a[1] != 0 ? 1 : 0;
        case Op::either: return a[0] != 0 || a[1] != 0 ? 1 : 0;
        case Op::opposite: return a[0] == 0 ? 1 : 0;
        case Op::choose: return a[0] != 0 ? a[1] : a[2];
        case Op::least: return std::min(a[0], a[1]);
        case Op::greatest: return std::max(a[0], a[1]);
        case Op::function: return kReportFunctions[step.index].apply(a[0]);
        default: return std::numeric_limits<double>::quiet_NaN();
    }
}

FigureValue Expression::value_of(const Step& step, const Lookup& lookup) const {
    if (step.op == Op::constant) return step.value;
    if (step.op == Op::text) return texts_[step.index];
    try {
        return lookup(names_[step.index]);
    } catch (const MissingFigure& missing) {
        FigureValue value(missing.name);
        value.is_missing = true;
        return value;
    }
}

FigureValue Expression::combined(const Step& step, const std::vector<FigureValue>& taken) const {
    if (step.op == Op::choose && !taken[0].is_missing)
        return taken[0].number != 0 ? taken[1] : taken[2];
    // One side may settle it without the other.
    const auto settles = [&](const FigureValue& v) {
        return !v.is_missing && !v.is_text && (v.number != 0) == (step.op == Op::either);
    };
    if ((step.op == Op::both || step.op == Op::either) && (settles(taken[0]) || settles(taken[1])))
        return step.op == Op::either ? 1.0 : 0.0;
    for (const FigureValue& value : taken)
        if (value.is_missing) return value;
    const bool compares = step.op == Op::equal || step.op == Op::unequal;
    double numbers[3] = {};
    for (std::size_t i = 0; i < taken.size(); ++i) {
        if (taken[i].is_text && !compares)
            throw ConfigError(fmt::format("{}: '{}': expected a number, found '{}'", where_, text_,
                                          taken[i].text));
        numbers[i] = taken[i].number;
    }
    if (!compares || (!taken[0].is_text && !taken[1].is_text)) return apply(step, numbers);
    const bool same = taken[0].is_text && taken[1].is_text && taken[0].text == taken[1].text;
    return same == (step.op == Op::equal) ? 1.0 : 0.0;
}

FigureValue Expression::evaluate(const Lookup& lookup) const {
    std::vector<FigureValue> stack;
    for (const Step& step : code_) {
        if (step.op == Op::constant || step.op == Op::text || step.op == Op::name) {
            stack.push_back(value_of(step, lookup));
            continue;
        }
        const auto first = stack.end() - static_cast<std::ptrdiff_t>(arity(step.op));
        FigureValue value = combined(step, {first, stack.end()});
        stack.erase(first, stack.end());
        stack.push_back(std::move(value));
    }
    if (stack.back().is_missing) throw MissingFigure{stack.back().text};
    return stack.back();
}

double Expression::number(const Lookup& lookup) const {
    const FigureValue value = evaluate(lookup);
    if (value.is_text)
        throw ConfigError(
            fmt::format("{}: '{}': expected a number, found '{}'", where_, text_, value.text));
    return value.number;
}

double Expression::number(const std::vector<double>& values) const {
    std::array<double, 64> stack;
    std::size_t n = 0;
    for (const Step& step : code_) {
        if (n + 1 >= stack.size())
            throw ConfigError(fmt::format("{}: '{}': nested too deep", where_, text_));
        if (step.op == Op::constant) {
            stack[n++] = step.value;
        } else if (step.op == Op::name) {
            stack[n++] = values[step.index];
        } else if (step.op == Op::text) {
            throw ConfigError(fmt::format("{}: '{}': no texts here", where_, text_));
        } else {
            n -= arity(step.op);
            stack[n] = apply(step, &stack[n]);
            ++n;
        }
    }
    return stack[0];
}

}  // namespace slim
