#pragma once

#include "pipeline/render/render_config.h"
#include "raytrace/lines/line_kind.h"

#include <cstddef>
#include <string>
#include <vector>

namespace slim {

/// The word of --lines that asks for lines of that kind.
std::string line_word(LineKind kind);

/// Kinds of lines in the order of drawing: those that a model of that degree, with or without sharp
/// surfels, gives, and those that are asked for and that it cannot give.
struct LineChoice {
    std::vector<LineKind> drawn, lacking;
    std::size_t n_words = 0;  ///< that ask for them
};
LineChoice line_choice(const RenderConfig& config, const std::vector<std::string>& aovs, int degree,
                       bool sharp);

}  // namespace slim
