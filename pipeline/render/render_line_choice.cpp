#include "pipeline/render/render_line_choice.h"

#include "pipeline/contains.h"

#include <array>

namespace slim {
namespace {

constexpr std::array<LineKind, kLineKinds> kDrawingOrder{
    LineKind::reflection, LineKind::parabolic,      LineKind::suggestive,   LineKind::valley,
    LineKind::ridge,      LineKind::concave_crease, LineKind::convex_crease, LineKind::contour};

/// What is asked for in words.
std::vector<std::string> asked_lines(const RenderConfig& config,
                                     const std::vector<std::string>& aovs, int degree, bool sharp) {
    if (!config.lines.empty() || !contains(aovs, "lines")) return config.lines;
    std::vector<std::string> words{"contour"};
    if (degree >= line_degree(LineKind::suggestive)) words.push_back("suggestive");
    if (degree >= line_degree(LineKind::ridge)) words.push_back("crest");
    if (sharp) words.push_back("crease");
    return words;
}

bool lacks(LineKind kind, int degree, bool sharp) {
    return is_crease(kind) ? !sharp : line_degree(kind) > degree;
}

}  // namespace

std::string line_word(LineKind kind) {
    if (is_crease(kind)) return "crease";
    const bool crest = kind == LineKind::ridge || kind == LineKind::valley;
    return crest ? "crest" : std::string(line_name(kind));
}

LineChoice line_choice(const RenderConfig& config, const std::vector<std::string>& aovs, int degree,
                       bool sharp) {
    const std::vector<std::string> asked = asked_lines(config, aovs, degree, sharp);
    LineChoice choice;
    choice.n_words = asked.size();
    for (const LineKind kind : kDrawingOrder)
        if (contains(asked, line_word(kind)))
            (lacks(kind, degree, sharp) ? choice.lacking : choice.drawn).push_back(kind);
    return choice;
}

}  // namespace slim
