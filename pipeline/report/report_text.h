#pragma once

#include "pipeline/report/report_expression.h"

#include <string>
#include <vector>

namespace slim {

/// `text` with every {formula} in it replaced by its value: whole numbers and texts as they are,
/// other numbers with `digits` significant digits (17: exactly). `{{` and `}}` are braces.
std::string filled(const std::string& text, const Expression::Lookup& lookup, int digits,
                   const std::string& where);

/// The formulas in the braces of a text. Throws as filled, of formulas that are none.
std::vector<Expression> formulas_in(const std::string& text, const std::string& where);

/// `text` with `by` in each place of `what`, which is not empty.
std::string replaced(std::string text, const std::string& what, const std::string& by);

/// A number as text: whole ones without a point (up to ten million, unless it is to be exact: 17
/// digits), others with at most so many significant digits.
std::string number_text(double value, int digits);

}  // namespace slim
