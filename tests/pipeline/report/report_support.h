#pragma once

#include "pipeline/report/report_expression.h"
#include "pipeline/report/report_row.h"

#include <string>

namespace slim::test {

inline Expression formula(const std::string& text) { return Expression(text, "test"); }

inline FigureValue lookup(const std::string& name) {
    if (name == "x") return 3.0;
    if (name == "m.l2") return 0.5;
    if (name == "shape") return std::string("torus");
    throw MissingFigure{name};
}

}  // namespace slim::test
