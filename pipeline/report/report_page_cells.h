#pragma once

#include "pipeline/report/report_expression.h"
#include "pipeline/report/report_results.h"

#include <optional>
#include <string>

namespace slim {

/// Text as HTML has it.
std::string esc(const std::string& text);

/// The style's class of a verdict: ok, bad, known, none.
const char* class_of(Verdict v);

/// Cells of the page's tables; a number with 4 digits, empty unless it is finite, and `mark`, which
/// is HTML, behind it.
std::string verdict_cell(Verdict v);
std::string text_cell(const std::string& text);
std::string cell(const std::optional<FigureValue>& value, const char* mark = "");

}  // namespace slim
