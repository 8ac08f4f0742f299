#include "pipeline/report/report_page_cells.h"

#include "pipeline/report/report_text.h"
#include "slim/base/markup.h"

#include <fmt/format.h>

#include <cmath>

namespace slim {

std::string esc(const std::string& text) { return escaped_markup(text); }

const char* class_of(Verdict v) {
    switch (v) {
        case Verdict::passed: return "ok";
        case Verdict::failed: return "bad";
        case Verdict::known_failure: return "known";
        default: return "none";
    }
}

std::string verdict_cell(Verdict v) {
    return fmt::format("<td class=\"text {}\">{}</td>", class_of(v), verdict_text(v));
}

std::string text_cell(const std::string& text) {
    return "<td class=\"text\">" + esc(text) + "</td>";
}

std::string cell(const std::optional<FigureValue>& value, const char* mark) {
    if (value && value->is_text) return text_cell(value->text);
    const bool shows = value && std::isfinite(value->number);
    return "<td>" + (shows ? number_text(value->number, 4) + mark : "") + "</td>";
}

}  // namespace slim
