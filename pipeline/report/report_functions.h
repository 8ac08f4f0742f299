#pragma once

#include <array>
#include <cmath>

namespace slim {

/// The functions of one number that a report's formulas have.
struct ReportFunction {
    const char* name;
    double (*apply)(double);
};
inline constexpr std::array<ReportFunction, 10> kReportFunctions{{
    {"abs", [](double x) { return std::abs(x); }},
    {"sqrt", [](double x) { return std::sqrt(x); }},
    {"exp", [](double x) { return std::exp(x); }},
    {"log", [](double x) { return std::log(x); }},
    {"log10", [](double x) { return std::log10(x); }},
    {"sin", [](double x) { return std::sin(x); }},
    {"cos", [](double x) { return std::cos(x); }},
    {"floor", [](double x) { return std::floor(x); }},
    {"round", [](double x) { return std::round(x); }},
    {"finite", [](double x) { return std::isfinite(x) ? 1.0 : 0.0; }},
}};

}  // namespace slim
