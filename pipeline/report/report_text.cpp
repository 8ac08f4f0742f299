#include "pipeline/report/report_text.h"

#include "slim/base/error.h"

#include <fmt/format.h>

#include <cmath>

namespace slim {

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
        text.replace(at, what.size(), by);
    return text;
}

std::string number_text(double value, int digits) {
    const double most = digits >= 17 ? 1e15 : 1e7;  // people count zeros badly
    if (std::isfinite(value) && value == std::round(value) && std::abs(value) < most)
        return fmt::format("{:.0f}", value);
    return digits >= 17 ? fmt::format("{}", value) : fmt::format("{:.{}g}", value, digits);
}

namespace {

/// Calls literal(char) for what stands outside of braces and formula(text) for what stands inside.
template <class Literal, class Formula>
void scan_braces(const std::string& text, const std::string& where, Literal&& literal,
                 Formula&& formula) {
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if ((c == '{' || c == '}') && i + 1 < text.size() && text[i + 1] == c) {
            literal(c);
            ++i;
        } else if (c == '{') {
            const std::size_t end = text.find('}', i);
            if (end == std::string::npos)
                throw ConfigError(
                    fmt::format("{}: '{}': a brace without its closing one", where, text));
            formula(text.substr(i + 1, end - i - 1));
            i = end;
        } else {
            literal(c);
        }
    }
}

}  // namespace

std::string filled(const std::string& text, const Expression::Lookup& lookup, int digits,
                   const std::string& where) {
    std::string out;
    scan_braces(text, where, [&](char c) { out += c; },
                [&](const std::string& formula) {
                    const FigureValue value = Expression(formula, where).evaluate(lookup);
                    out += value.is_text ? value.text : number_text(value.number, digits);
                });
    return out;
}

std::vector<Expression> formulas_in(const std::string& text, const std::string& where) {
    std::vector<Expression> out;
    scan_braces(
        text, where, [](char) {},
        [&](const std::string& formula) { out.emplace_back(formula, where); });
    return out;
}

}  // namespace slim
